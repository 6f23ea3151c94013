"""A small model of errands in words: it learns what was done from what was seen and heard. Needs the extra `learn`."""

from collections.abc import Sequence
from itertools import chain
from typing import Any, NamedTuple

import numpy as np
import torch
from torch import nn
from torch.nn import functional

from llf_teacher.reproductions.household import WORDS, Choose, Errand, numbers

_WIDTH, _INNER, _MEMORY = 64, 16, 32
"""Numbers of a word by which it is recognized, of one in its sentence, and of what is remembered."""
_UNHEARD = 0.15  # share of the words that are left out while it learns
_AT_ONCE = 8
_NEAR = 7  # words that make a neighbourhood


class _Batch(NamedTuple):
    """Errands as numbers; the turns of all of them stand below each other, filled up with zeros."""

    tasks: torch.Tensor
    """Words per turn, as in the next three."""
    seen: torch.Tensor
    heard: torch.Tensor
    last: torch.Tensor
    commands: torch.Tensor
    """Words of every command that comes up; the first one has none."""
    offered: torch.Tensor
    """Per turn the places of what can be done in `commands`."""
    before: torch.Tensor
    """How often each was done, as a logarithm."""
    returns: torch.Tensor
    """Per turn whether the task is done in the end."""
    done: torch.Tensor
    """Per turn the place of the command among what can be done."""
    lengths: list[int]
    """Turns of each errand."""


def _filled(rows: Sequence[Sequence[float]], kind: type[np.generic] = np.int64) -> torch.Tensor:
    """Rows of different lengths as a rectangle."""
    lengths = np.array([len(row) for row in rows])
    filled = np.zeros((len(rows), max(1, lengths.max())), kind)
    filled[np.arange(filled.shape[1]) < lengths[:, None]] = list(chain.from_iterable(rows))
    return torch.from_numpy(filled)


def _batch(errands: Sequence[Errand], *, last: bool = False) -> _Batch:
    """Errands as numbers; with `last` those that go on, of which it is the last turn, and success is asked for."""
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
    """Picks out words of what it hears, remembers by a recurrent layer over turns, and weighs what can be done.

    Like a decision transformer it is told the return, imitates what was done, and is asked for success in the end. A
    word is a vector, of which nothing is known before.

    Args:
        rng: what draws its weights, the order of errands, and the words that are left out.
    """

    def __init__(self, rng: np.random.Generator) -> None:
        self._rng = rng
        with torch.random.fork_rng(devices=[]):  # what is drawn here goes back, and is replaced below
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
        """Imitate what was done in errands, each of them `epochs` times."""
        adam = torch.optim.AdamW(self._net.parameters(), lr=0.01)
        for _ in range(epochs):
            order = self._rng.permutation(len(errands))
            for first in range(0, len(errands), _AT_ONCE):
                batch = _batch([errands[i] for i in order[first : first + _AT_ONCE]])
                heard = self._rng.random(tuple(batch.heard.shape)) > _UNHEARD
                adam.zero_grad()
                scores, _ = self._weigh(batch, torch.as_tensor(heard))
                functional.cross_entropy(scores, batch.done).backward()
                adam.step()

    def player(self) -> Choose:
        """What plays: it does what it holds to be best, and remembers what it has seen and heard in each errand."""
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
        """Per turn a score of each of what can be done, and what is remembered.

        Args:
            batch: the turns.
            heard: which words of the teacher are heard.
            before: what is remembered of the turns before these; None: they are the first.
        """
        net = self._net
        task, seen, last = (self._bag(each) for each in (batch.tasks, batch.seen, batch.last))
        there = (batch.heard > 0)[..., None]
        read = net["read"]((net["spoken"](batch.heard) * (there & heard[..., None])).mT).mT.relu() * there
        told = (torch.sigmoid(net["gate"](read)) * net["words"](batch.heard) * there).sum(dim=1)
        turns = torch.cat([task, seen, last, told, read.amax(dim=1), batch.returns], dim=1).split(batch.lengths)
        memory, _ = net["turns"](nn.utils.rnn.pad_sequence(turns, batch_first=True), before)
        state = torch.cat([memory[i, :length] for i, length in enumerate(batch.lengths)])
        named = (net["alike"].weight[:, None] * torch.stack([task, seen, told])).sum(dim=0)
        offered = self._bag(batch.commands)[batch.offered]
        scores = (offered @ (net["wish"](state) + named)[..., None])[..., 0] + net["again"](state) * batch.before
        return scores.masked_fill(batch.offered == 0, -torch.inf), state

    def _bag(self, words: torch.Tensor) -> torch.Tensor:
        """The sum of the vectors of words."""
        there = (words > 0).float()
        return functional.embedding_bag(words, self._net["words"].weight, per_sample_weights=there, mode="sum")
