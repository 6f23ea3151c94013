"""A model in training: it answers, learns by a trainer of TRL with LoRA of peft, and is kept in checkpoints.

Needs the extra `trl`. What it learns from comes from `word_signals.py`.
"""

import json
import math
import os
import shutil
import tempfile
import warnings
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from word_signals import BATCH, Message

from llf_teacher.models.local.catalogue import at_hand, remedy

try:
    import torch
    from datasets import Dataset, disable_progress_bars
    from peft import LoraConfig, get_peft_model, get_peft_model_state_dict, set_peft_model_state_dict
    from transformers import AutoModelForCausalLM, AutoTokenizer, PreTrainedTokenizerBase, PrinterCallback, set_seed
    from transformers.utils import logging
    from trl import DPOConfig, DPOTrainer, GRPOConfig, GRPOTrainer, SFTConfig, SFTTrainer
except ModuleNotFoundError as error:
    raise SystemExit(
        f'{error}; install it by: pip install -e ".[trl]" -c tests/integrations/trl/constraints.txt'
    ) from None

logging.set_verbosity_error()
logging.disable_progress_bar()
disable_progress_bars()
warnings.filterwarnings("ignore", module="(torch|transformers|trl|peft|accelerate)")

RANK = 16
RATES = {"grpo": 2e-4, "sft": 1e-3, "dpo": 1e-4}
"""Learning rate of each trainer, unless the command chooses another."""
STEPS = 4
"""Optimizer steps of an update; each takes a quarter of its examples."""
_MADE = "checkpoint-{:05}"
_WEIGHTS, _OPTIMIZER, _PROGRESS = "adapter.pt", "optimizer.pt", "progress.json"


class Learned(NamedTuple):
    """What an update took."""

    examples: int
    loss: float | None
    """Mean over the optimizer steps; None without examples."""


class Learner:
    """A causal model with an adapter, which alone is trained.

    Args:
        model: the name of a model of `llf models`, a GGUF file, a folder, or a name of the Hugging Face hub.
        device: as in torch.
        dtype: of the frozen weights, as in torch; the adapter is float32.
        longest_prompt: the most tokens of a prompt.

    Raises:
        ValueError: there is no such model, or it has no chat template.
    """

    def __init__(self, model: str, device: str = "cpu", dtype: str = "float32", longest_prompt: int = 2048) -> None:
        place, options = _source(model)
        self.longest_prompt, self._device = longest_prompt, torch.device(device)
        self._tokenizer: PreTrainedTokenizerBase = AutoTokenizer.from_pretrained(place, **options)
        if not self._tokenizer.chat_template:
            raise ValueError(f"model must have a chat template, got {model!r}, which has none; take an instruct model")
        if self._tokenizer.pad_token is None:
            self._tokenizer.pad_token = self._tokenizer.eos_token
        self._tokenizer.padding_side = "left"
        base = AutoModelForCausalLM.from_pretrained(place, dtype=getattr(torch, dtype), **options)
        if options:  # of a GGUF file, whose weights are ordinary ones now, though transformers refuses to train them
            plain = AutoModelForCausalLM.from_config(base.config, dtype=base.dtype)
            plain.load_state_dict(base.state_dict())
            base = plain
        lora = LoraConfig(r=RANK, lora_alpha=2 * RANK, target_modules="all-linear", task_type="CAUSAL_LM")
        self.model = get_peft_model(base, lora).to(self._device)
        self.tokens = 0
        """Tokens of prompts and answers so far, of acting and learning."""

    def begin(self, seed: int) -> None:
        """An adapter that changes nothing yet, and a new optimizer."""
        set_seed(seed)
        for module in self.model.modules():
            if hasattr(module, "reset_lora_parameters"):
                module.reset_lora_parameters("default", True)
        trained = [parameter for parameter in self.model.parameters() if parameter.requires_grad]
        self._optimizer = torch.optim.AdamW(trained, weight_decay=0.0)

    def seed(self, seed: int) -> None:
        """Seed all draws that follow."""
        set_seed(seed)

    def set_rate(self, rate: float) -> None:
        """Set the learning rate of what follows."""
        for group in self._optimizer.param_groups:
            group["lr"] = group["initial_lr"] = rate

    def answer(self, conversations: Sequence[list[Message]], longest: int, sample: bool) -> list[str]:
        """Answers to some conversations, at temperature 1 or the most probable tokens.

        Raises:
            ValueError: a prompt is too long.
        """
        answers: list[str] = []
        self.model.eval()
        for first in range(0, len(conversations), BATCH):
            texts = [self._rendered(each) for each in conversations[first : first + BATCH]]
            tokens = self._tokenizer(texts, return_tensors="pt", padding=True, add_special_tokens=False)
            self._check(tokens["attention_mask"].sum(dim=1).tolist())
            tokens = tokens.to(self._device)
            chosen = (
                {"do_sample": True, "temperature": 1.0, "top_k": 0, "top_p": 1.0} if sample else {"do_sample": False}
            )
            with torch.no_grad():
                whole = self.model.generate(
                    **tokens,
                    max_new_tokens=longest,
                    pad_token_id=self._tokenizer.pad_token_id,
                    eos_token_id=self._tokenizer.eos_token_id,  # trainers change this and the next in the configuration
                    use_cache=True,
                    **chosen,
                )
            said = whole[:, tokens["input_ids"].shape[1] :]
            self.tokens += int(tokens["attention_mask"].sum() + (said != self._tokenizer.pad_token_id).sum())
            answers += self._tokenizer.batch_decode(said, skip_special_tokens=True)
        return answers

    def learn(self, trainer: str, examples: Sequence[dict[str, Any]], seed: int) -> Learned:
        """Learn from examples by SFT or DPO.

        Raises:
            FloatingPointError: the loss is not finite.
        """
        if not examples:
            return Learned(0, None)
        shared = self._shared(seed, -(-len(examples) // STEPS))
        rows = Dataset.from_list(list(examples))
        self.tokens += sum(self._size(row) for row in examples)
        made: Any
        if trainer == "sft":
            made = SFTTrainer(self.model, SFTConfig(max_length=None, **shared), **self._given(rows))
        else:
            made = DPOTrainer(self.model, args=DPOConfig(max_length=None, **shared), **self._given(rows))
        try:
            return self._train(made, len(examples))
        finally:
            if "ref" in self.model.peft_config:  # DPO's reference is the model before the update
                self.model.delete_adapter("ref")

    def learn_by_reward(
        self, prompts: Sequence[dict[str, Any]], reward: Callable[..., list[float]], group: int, longest: int, seed: int
    ) -> Learned:
        """Answer each prompt `group` times, and learn by GRPO from the rewards of the answers.

        Args:
            prompts: rows with a `prompt`, and columns that `reward` gets.
            reward: as TRL calls it, with `completions` and the columns.
            group, longest: answers to a prompt, and their tokens.
            seed: of the answers.
        """
        answers = len(prompts) * group
        if answers % (STEPS * group):
            raise ValueError(f"there must be a multiple of {STEPS} prompts, got {len(prompts)}")
        sizes = [self._count(self._rendered(row["prompt"])) for row in prompts]
        self._check(sizes)

        def counted(completions: list[list[Message]], **columns: Any) -> list[float]:
            answered = sum(self._count(completion[0]["content"]) for completion in completions)
            self.tokens += 2 * (group * sum(sizes) + answered)  # acting and learning
            return reward(completions=completions, **columns)

        options = {
            "num_generations": group,
            "steps_per_generation": STEPS,
            "max_completion_length": longest,
            "temperature": 1.0,
            "top_k": 0,
            "beta": 0.0,
            "generation_kwargs": {"use_cache": True},
        }
        made = GRPOTrainer(
            self.model,
            reward_funcs=counted,
            args=GRPOConfig(**options, **self._shared(seed, answers // STEPS)),
            **self._given(Dataset.from_list(list(prompts))),
        )
        return self._train(made, answers)

    def save(self, folder: Path, update: int, end: int) -> None:
        """A checkpoint after an update, in place of the earlier ones; until it is whole, the earlier ones stay.

        Args:
            folder: of the run.
            update: number of updates so far.
            end: where the run's rows end, in bytes.
        """
        whole, part = folder / _MADE.format(update), folder / "checkpoint.part"
        shutil.rmtree(part, ignore_errors=True)
        part.mkdir(parents=True)
        torch.save(get_peft_model_state_dict(self.model), part / _WEIGHTS)
        torch.save(self._optimizer.state_dict(), part / _OPTIMIZER)
        (part / _PROGRESS).write_text(json.dumps({"update": update, "end": end, "tokens": self.tokens}), "utf-8")
        for path in part.iterdir():
            with path.open("rb") as file:
                os.fsync(file.fileno())
        shutil.rmtree(whole, ignore_errors=True)
        part.rename(whole)
        for old in folder.glob("checkpoint-*"):
            if old != whole:
                shutil.rmtree(old)

    def load(self, folder: Path) -> dict[str, int]:
        """The newest checkpoint of a run; update 0 if there is none."""
        found = sorted(folder.glob("checkpoint-*"))
        if not found:
            return {"update": 0, "end": 0, "tokens": 0}
        weights = torch.load(found[-1] / _WEIGHTS, map_location=self._device, weights_only=True)
        set_peft_model_state_dict(self.model, weights)
        state = torch.load(found[-1] / _OPTIMIZER, map_location=self._device, weights_only=True)
        self._optimizer.load_state_dict(state)
        progress: dict[str, int] = json.loads((found[-1] / _PROGRESS).read_text("utf-8"))
        self.tokens = progress["tokens"]
        return progress

    def weights(self) -> dict[str, Any]:
        """The adapter's weights by their names."""
        found: dict[str, Any] = get_peft_model_state_dict(self.model)
        return found

    def _train(self, trainer: Any, count: int) -> Learned:
        trainer.remove_callback(PrinterCallback)
        trainer.train()
        losses = [row["loss"] for row in trainer.state.log_history if "loss" in row]
        mean = sum(losses) / len(losses)
        finite = all(bool(torch.isfinite(each).all()) for each in self.weights().values())
        if not math.isfinite(mean) or not finite:
            raise FloatingPointError(
                f"the loss must be finite, got {mean}; the checkpoint before this update stays; take a lower --rate"
            )
        return Learned(count, mean)

    def _given(self, rows: Dataset) -> dict[str, Any]:
        return {
            "train_dataset": rows,
            "processing_class": self._tokenizer,
            "optimizers": (self._optimizer, None),
        }

    def _shared(self, seed: int, batch: int) -> dict[str, Any]:
        return {
            "output_dir": tempfile.gettempdir(),  # trainers want one; nothing is written
            "per_device_train_batch_size": batch,
            "max_steps": STEPS,
            "lr_scheduler_type": "constant",
            "logging_steps": 1,
            "save_strategy": "no",
            "report_to": "none",
            "disable_tqdm": True,
            "gradient_checkpointing": False,
            "bf16": False,
            "use_cpu": self._device.type == "cpu",
            "dataloader_pin_memory": False,
            "seed": seed,
        }

    def _rendered(self, messages: list[Message]) -> str:
        text: str = self._tokenizer.apply_chat_template(messages, tokenize=False, add_generation_prompt=True)
        return text

    def _count(self, text: str) -> int:
        return len(self._tokenizer(text, add_special_tokens=False)["input_ids"])

    def _size(self, row: dict[str, Any]) -> int:
        """Tokens of an example."""
        said = [row[name][0]["content"] for name in ("completion", "chosen", "rejected") if name in row]
        prompt = self._count(self._rendered(row["prompt"]))
        return sum(prompt + self._count(each) for each in said)

    def _check(self, sizes: Sequence[int]) -> None:
        if max(sizes) > self.longest_prompt:
            raise ValueError(
                f"a prompt must have at most {self.longest_prompt} tokens, got {max(sizes)}; give a greater "
                "--max-prompt if the model takes it, or leave this environment out"
            )


def _source(model: str) -> tuple[str, dict[str, Any]]:
    """Where transformers finds a model."""
    for each in at_hand():
        if each.name == model.removeprefix("local:"):
            if problem := each.problem():
                raise ValueError(problem)
            return f"{Path(each.path).parent}", {"gguf_file": Path(each.path).name}
    path = Path(model)
    if path.suffix == ".gguf":
        if not path.is_file():
            raise ValueError(f"model must be an existing file, got {model!r}")
        return f"{path.parent}", {"gguf_file": path.name}
    if not path.is_dir() and "/" not in model:
        raise ValueError(f"model {model!r} is not on this machine; run: {remedy(model)}")
    return model, {}
