"""A tiny model of random weights."""

import sys
from pathlib import Path

import pytest
import torch
from tokenizers import Tokenizer, models, pre_tokenizers, trainers
from transformers import LlamaConfig, LlamaForCausalLM, PreTrainedTokenizerFast

sys.path.insert(0, f"{Path(__file__).parents[3] / 'examples'}")
from word_signals import Town

TEMPLATE = (
    "{% for m in messages %}<s> {{ m['content'] }} </s> {% endfor %}{% if add_generation_prompt %}<s> {% endif %}"
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A model in a folder; each word is a token."""
    torch.set_num_threads(1)
    torch.manual_seed(0)
    made = tmp_path_factory.mktemp("model")
    words = Tokenizer(models.WordLevel(unk_token="<unk>"))
    words.pre_tokenizer = pre_tokenizers.Whitespace()
    town = Town("gridworld", 0)
    steps = town.play(lambda conversations: ["Response: north"] * len(conversations), range(50), hears=True)
    texts = [f"{message['content']} {step.answer}" for step in steps for message in step.heard]
    words.train_from_iterator(texts, trainers.WordLevelTrainer(special_tokens=["<unk>", "<pad>", "<s>", "</s>"]))
    tokenizer = PreTrainedTokenizerFast(tokenizer_object=words, unk_token="<unk>", eos_token="</s>", pad_token="<pad>")
    tokenizer.chat_template = TEMPLATE
    tokenizer.save_pretrained(made)
    sizes = {"hidden_size": 32, "intermediate_size": 32, "num_attention_heads": 2, "num_hidden_layers": 1}
    config = LlamaConfig(vocab_size=len(tokenizer), initializer_range=0.3, **sizes)
    LlamaForCausalLM(config).save_pretrained(made)
    return made
