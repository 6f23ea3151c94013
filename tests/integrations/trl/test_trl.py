"""TRL trains in our environments and on our data: a tiny model of random weights, made here, on the CPU."""

import json
import runpy
import sys
from functools import partial
from types import ModuleType

import pytest
import torch
from datasets import Dataset
from documents import python_blocks
from tokenizers import Tokenizer, models, pre_tokenizers, trainers
from transformers import PreTrainedTokenizerFast, Qwen3Config, Qwen3ForCausalLM
from transformers.utils import get_json_schema
from trl import GRPOConfig, GRPOTrainer
from trl.chat_template_utils import qwen3_chat_template, qwen3_training_chat_template

from llf_teacher import rollout
from llf_teacher.integrations.trl import FeedbackEnvironment

GRID = "llf-gridworld-v0"
WAYS = ("north", "east", "south", "west")
CALLS = [f'<tool_call>\n{{"name": "act", "arguments": {{"action": "{way}"}}}}\n</tool_call>' for way in WAYS]
SMALL = {"max_steps": 2, "report_to": "none", "save_strategy": "no", "use_cpu": True, "bf16": False}


@pytest.fixture
def tokenizer():
    """Each word is a token, and so is each call of the tool."""
    words = Tokenizer(models.WordLevel(unk_token="?"))
    words.pre_tokenizer = pre_tokenizers.Whitespace()
    environment = FeedbackEnvironment(GRID)
    texts = [environment.reset(seed=seed) for seed in range(50)]
    words.train_from_iterator(texts, trainers.WordLevelTrainer(special_tokens=["?", "<|im_end|>", "<|im_start|>"]))
    made = PreTrainedTokenizerFast(tokenizer_object=words, unk_token="?", eos_token="<|im_end|>", pad_token="?")
    made.add_tokens(CALLS)
    made.chat_template = qwen3_chat_template
    return made


@pytest.fixture
def model(tokenizer):
    torch.manual_seed(0)
    torch.set_num_threads(1)
    sizes = {"hidden_size": 32, "intermediate_size": 32, "num_attention_heads": 2, "num_key_value_heads": 2}
    return Qwen3ForCausalLM(Qwen3Config(vocab_size=len(tokenizer), num_hidden_layers=1, head_dim=16, **sizes))


@pytest.fixture
def calling(tokenizer):
    """Keeps a model of random weights to calls, and the end of its turn."""
    allowed = {*tokenizer.convert_tokens_to_ids(CALLS), tokenizer.eos_token_id}
    return {"suppress_tokens": [token for token in range(len(tokenizer)) if token not in allowed]}


def test_the_tool_is_described():
    schema = get_json_schema(FeedbackEnvironment(GRID).act)["function"]
    assert schema["name"] == "act"
    assert schema["parameters"]["required"] == ["action"]
    assert schema["parameters"]["properties"]["action"]["description"] == "The action, as the task describes it."


def test_grpo_trains_in_an_environment(tmp_path, tokenizer, model, calling):
    made = []

    def factory():
        made.append(FeedbackEnvironment(GRID, reward="regret", max_turns=3))
        return made[-1]

    before = model.lm_head.weight.detach().clone()
    trainer = GRPOTrainer(
        model=model,
        args=GRPOConfig(
            output_dir=f"{tmp_path}",
            learning_rate=1e-2,
            per_device_train_batch_size=8,
            num_generations=4,
            max_completion_length=128,
            generation_kwargs=calling,
            logging_steps=1,
            **SMALL,
        ),
        processing_class=tokenizer,
        train_dataset=Dataset.from_list([{"id": GRID, "seed": seed, "teacher": "oracle"} for seed in range(8)]),
        environment_factory=factory,
    )
    trainer.train()
    steps = [row for row in trainer.state.log_history if "reward" in row]
    assert len(steps) == 2
    assert len(made) == 8  # one for each conversation of a batch, kept for the next
    assert all(row["tools/call_frequency"] > 0 for row in steps)
    assert steps[-1]["reward"] == steps[-1]["rewards/FeedbackEnvironment/mean"]
    assert steps[-1]["reward"] == pytest.approx(sum(each.get_reward() for each in made) / 8)
    assert steps[-1]["reward"] < 0
    assert not torch.equal(model.lm_head.weight, before)


def test_the_tokens_of_a_rollout_are_masked(tokenizer):
    """By the offsets that the tokenizer gives."""
    tokenizer.chat_template = qwen3_training_chat_template  # which writes the beginning of a conversation as it was
    (played,) = rollout(lambda each: ["west"], GRID, 1, max_turns=3)
    render = partial(tokenizer.apply_chat_template, tokenize=False)
    text, spans = played.spans(render)
    tokens = tokenizer(text, return_offsets_mapping=True, add_special_tokens=False)
    own = [
        id
        for id, (begin, end) in zip(tokens["input_ids"], tokens["offset_mapping"], strict=True)
        if any(first <= begin and end <= last for first, last in spans)
    ]
    assert tokenizer.convert_ids_to_tokens(own).count("west") == 3
    assert tokenizer.convert_ids_to_tokens(own).count("<|im_end|>") == 3
    assert "treasure" not in tokenizer.convert_ids_to_tokens(own)
    assert json.dumps(played.messages)


def test_the_pages_example(tmp_path, monkeypatch, tokenizer, model, calling):
    (code,) = [each for each in python_blocks().values() if each.startswith("# Needs the extra `trl`")]
    (tmp_path / "example.py").write_text(code)
    mine = ModuleType("my_model")
    mine.model, mine.tokenizer = model, tokenizer
    mine.settings = SMALL | {"output_dir": f"{tmp_path}", "generation_kwargs": calling}
    monkeypatch.setitem(sys.modules, "my_model", mine)
    trainer = runpy.run_path(f"{tmp_path / 'example.py'}")["trainer"]
    steps = [row for row in trainer.state.log_history if "reward" in row]
    assert len(steps) == 2
    assert all(row["reward"] < 0 < row["tools/call_frequency"] for row in steps)
    assert trainer.args.max_tool_calling_iterations == 3, "or a model that always calls would never end"
