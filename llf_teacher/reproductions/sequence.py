"""A small sequence model of errands: it predicts commands from observations and feedback. Needs the extra `learn`."""

from collections.abc import Sequence
from itertools import chain
from typing import Any, NamedTuple

import numpy as np
import torch
from torch import nn
from torch.nn import functional

from llf_teacher.reproductions.household import WORDS, Choose, Errand, numbers

_WIDTH, _INNER, _MEMORY = 64, 16, 32
"""Sizes of the embedding of a word, of its embedding in a sentence, and of the recurrent state."""
_DROPPED = 0.15  # share of the words that are dropped in training
_BATCH_SIZE = 8
_NEAR = 7  # width of the convolution, in words


class _Batch(NamedTuple):
    """Errands as numbers; the turns of all errands are concatenated, and padded with zeros."""

    tasks: torch.Tensor
    """Words per turn, as the next three."""
    seen: torch.Tensor
    heard: torch.Tensor
    last: torch.Tensor
    commands: torch.Tensor
    """Words of every command; the first command is empty."""
    offered: torch.Tensor
    """Per turn, the admissible commands, as indices of `commands`."""
    before: torch.Tensor
    """How often each was given before, as a logarithm."""
    returns: torch.Tensor
    """Per turn, whether the task is solved in the end."""
    done: torch.Tensor
    """Per turn, the index of the command among the admissible ones."""
    lengths: list[int]
    """Number of turns of each errand."""


def _filled(rows: Sequence[Sequence[float]], kind: type[np.generic] = np.int64) -> torch.Tensor:
    """Rows of different lengths as a rectangle, padded with zeros."""
    lengths = np.array([len(row) for row in rows])
    filled = np.zeros((len(rows), max(1, lengths.max())), kind)
    filled[np.arange(filled.shape[1]) < lengths[:, None]] = list(chain.from_iterable(rows))
    return torch.from_numpy(filled)


def _batch(errands: Sequence[Errand], *, last: bool = False) -> _Batch:
    """Errands as numbers; with `last` only their last turns, with success as the return."""
    turns = [(errand, turn) for errand in errands for turn in (errand.turns[-1:] if last else errand.turns)]
    place = {"": 0}
    for command in chain.from_iterable(turn.commands for _, turn in turns):
        place.setdefault(command, len(place))
    return _Batch(
        tasks=_filled([numbers(errand.task) for errand, _ in turns]),
        seen=_filled([numbers(turn.seen) for _, turn in turns]),
        heard=_filled([numbers(turn.heard) for _, turn in turns]),
        last=_filled([numbers(turn.last) for _, turn in turns]),
        commands=_filled([numbers(command) for command in place]),
        offered=_filled([[place[command] for command in turn.commands] for _, turn in turns]),
        before=_filled([turn.before for _, turn in turns], np.float32).log1p(),
        returns=torch.tensor([[float(last or errand.success)] for errand, _ in turns]),
        done=torch.tensor([turn.commands.index(turn.done) if turn.done else 0 for _, turn in turns]),
        lengths=[1 if last else len(errand.turns) for errand in errands],
    )


class SequenceModel:
    """A model with gated words of the teacher and a recurrent layer over turns, which scores the admissible commands.

    As in a decision transformer, the return is an input: the model imitates the commands, and success is its input in
    tests. Embeddings of words are learned from scratch.

    Args:
        rng: draws the weights, the order of errands, and the dropped words.
    """

    def __init__(self, rng: np.random.Generator) -> None:
        self._rng = rng
        with torch.random.fork_rng(devices=[]):  # keeps the global generator; the weights are replaced below
            self._net: Any = nn.ModuleDict(
                {
                    "words": nn.Embedding(WORDS, _WIDTH),
                    "spoken": nn.Embedding(WORDS, _INNER),
                    "read": nn.Conv1d(_INNER, _INNER, _NEAR, padding=_NEAR // 2),
                    "gate": nn.Linear(_INNER, 1),
                    "turns": nn.GRU(4 * _WIDTH + _INNER + 1, _MEMORY, batch_first=True),
                    "wish": nn.Linear(_MEMORY, _WIDTH),
                    "again": nn.Linear(_MEMORY, 1),
                    "alike": nn.Linear(_WIDTH, 3, bias=False),
                }
            )
        with torch.no_grad():
            for name, weights in self._net.named_parameters():
                reach = 3**0.5 if name == "words.weight" else 1.0
                drawn = rng.uniform(-reach, reach, tuple(weights.shape)) / weights.shape[-1] ** 0.5
                weights.copy_(torch.as_tensor(drawn))
            self._net["alike"].weight.fill_(0.1)

    def learn(self, errands: Sequence[Errand], epochs: int) -> None:
        """Imitate the commands of errands, each `epochs` times."""
        adam = torch.optim.AdamW(self._net.parameters(), lr=0.01)
        for _ in range(epochs):
            order = self._rng.permutation(len(errands))
            for first in range(0, len(errands), _BATCH_SIZE):
                batch = _batch([errands[i] for i in order[first : first + _BATCH_SIZE]])
                heard = self._rng.random(tuple(batch.heard.shape)) > _DROPPED
                adam.zero_grad()
                scores, _ = self._weigh(batch, torch.as_tensor(heard))
                functional.cross_entropy(scores, batch.done).backward()
                adam.step()

    def player(self) -> Choose:
        """A policy that gives the command with the greatest score, and keeps the recurrent state of each errand."""
        memories: dict[int, torch.Tensor] = {}

        def choose(errands: Sequence[Errand]) -> list[str]:
            before = torch.stack([memories.get(id(errand), torch.zeros(_MEMORY)) for errand in errands])
            batch = _batch(errands, last=True)
            with torch.no_grad():
                scores, after = self._weigh(batch, batch.heard > 0, before[None])
            memories.update(zip(map(id, errands), after, strict=True))
            best = scores.argmax(dim=1).tolist()
            return [errand.turns[-1].commands[each] for errand, each in zip(errands, best, strict=True)]

        return choose

    def _weigh(
        self, batch: _Batch, heard: torch.Tensor, before: torch.Tensor | None = None
    ) -> tuple[torch.Tensor, torch.Tensor]:
        """Scores of the admissible commands per turn, and the recurrent state.

        Args:
            batch: the turns.
            heard: which words of the teacher are not dropped.
            before: the recurrent state; None: these are the first turns.
        """
        net = self._net
        task, seen, last = (self._bag(each) for each in (batch.tasks, batch.seen, batch.last))
        there = (batch.heard > 0)[..., None]
        read = net["read"]((net["spoken"](batch.heard) * (there & heard[..., None])).mT).mT.relu() * there
        stressed = (torch.sigmoid(net["gate"](read)) * net["words"](batch.heard) * there).sum(dim=1)
        turns = torch.cat([task, seen, last, stressed, read.amax(dim=1), batch.returns], dim=1).split(batch.lengths)
        memory, _ = net["turns"](nn.utils.rnn.pad_sequence(turns, batch_first=True), before)
        state = torch.cat([memory[i, :length] for i, length in enumerate(batch.lengths)])
        named = (net["alike"].weight[:, None] * torch.stack([task, seen, stressed])).sum(dim=0)
        offered = self._bag(batch.commands)[batch.offered]
        scores = (offered @ (net["wish"](state) + named)[..., None])[..., 0] + net["again"](state) * batch.before
        return scores.masked_fill(batch.offered == 0, -torch.inf), state

    def _bag(self, words: torch.Tensor) -> torch.Tensor:
        """The sum of the vectors of words."""
        there = (words > 0).float()
        return functional.embedding_bag(words, self._net["words"].weight, per_sample_weights=there, mode="sum")
