"""A world with the means to teach it, for the checks of the conformance kits."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from teachers.atoms import Atom, Claim, Moment, ParseFailure
from teachers.oracle import Oracle
from teachers.personality import Personality
from teachers.teacher import Teacher
from teachers.testing.habits import HABITS, Habit, Seen, Unread
from worlds.world import World


class Taught(NamedTuple):
    """What was said in a turn."""

    moment: Moment
    atoms: tuple[Atom, ...]
    """The feedback."""
    true: tuple[Claim, ...]
    """What the oracle would have said."""


@dataclass(frozen=True)
class Pupil:
    """A world with the means to teach it."""

    make_world: Callable[[], World[Any]]
    make_teacher: Callable[..., Teacher]
    """Takes a world and the keyword arguments of `Teacher`."""
    max_turns: int = 20
    turns: int = 100
    """Turns that a check plays."""

    def moments(self, world: World[Any], seed: int = 0, habit: str = "") -> Iterator[Moment]:
        """Random play, or that of one of the `HABITS`, episode after episode; each opens with an opening moment."""
        rng = np.random.default_rng(seed)
        oracle, lab = self.make_teacher(world).oracle, world.scratch()
        play = HABITS.get(habit, _RANDOM)
        played = 0
        while played < self.turns:
            info = world.reset(seed=int(rng.integers(2**31)))[1]
            moment = Moment.opening(world.truth)
            if habit:
                oracle.start(moment.after)
            yield moment
            for turn in range(1, self.max_turns + 1):
                told = oracle.judge(moment) if habit else ()
                listed = info.get(world.actions_key, ()) if habit else ()
                action = play.act(Seen(lab, moment, told, listed, rng))
                late = turn == self.max_turns
                if isinstance(action, Unread):
                    failure = ParseFailure(repr(action[:40]), world.action_syntax)
                    moment = Moment.unread(moment.after, failure, world.failure_reward, moment.success, turn, late)
                else:
                    before, action = world.truth, world.legal(action)
                    _, reward, terminated, truncated, info = world.advance(action)
                    over = terminated or truncated or late
                    moment = Moment(before, action, reward, world.truth, info["success"], turn, over)
                yield moment
                played += 1
                if moment.over or played == self.turns or turn == play.patience:
                    break

    def episodes(self, turns: int) -> list[list[Moment]]:
        """Episodes, at least so many turns in all, of a student who follows a plan, tries something, or insists."""
        world = self.make_world()
        oracle = self.make_teacher(world).oracle
        rng = np.random.default_rng(0)
        played: list[list[Moment]] = []
        while sum(map(len, played)) - len(played) < turns:
            world.reset(seed=int(rng.integers(2**31)))
            oracle.start(world.truth)
            moments = [Moment.opening(world.truth)]
            for turn in range(1, self.max_turns + 1):
                draw, plan = rng.random(), oracle.plan(world.truth, 1)
                if draw < 0.4 and plan:
                    action = plan[0]
                elif draw < 0.7 and turn > 1:
                    action = moments[-1].action
                else:
                    action = world.sample_action(rng)
                before, action = world.truth, world.legal(action)
                _, reward, terminated, truncated, info = world.advance(action)
                over = terminated or truncated or turn == self.max_turns
                moments.append(Moment(before, action, reward, world.truth, info["success"], turn, over))
                if over:
                    break
            played.append(moments)
        return played

    def taught(self, personality: str | Personality, turns: int) -> list[list[Taught]]:
        """What a teacher says in these episodes, turn by turn."""
        teacher = self.make_teacher(self.make_world(), personality)
        rng = np.random.default_rng(0)
        heard: list[list[Taught]] = []
        for moments in self.episodes(turns):
            teacher.reset(rng.spawn(1)[0])
            heard.append([])
            for moment in moments:
                atoms = tuple(atom for atom in teacher.speak(moment).atoms if atom.kind is not None)
                heard[-1].append(Taught(moment, atoms, teacher.oracle.judge(moment)))
        return heard

    def atoms(self, seed: int = 0, **settings: Any) -> Iterator[tuple[Atom, Moment, World[Any]]]:
        """All that a teacher says of random play, each atom with the moment that it is about and a lab."""
        for said in self.said(settings, seed=seed):
            yield from said

    def said(
        self, *teachers: Mapping[str, Any], seed: int = 0, habit: str = ""
    ) -> Iterator[list[tuple[Atom, Moment, World[Any]]]]:
        """The same, turn by turn, of teachers with different settings who watch the same play, as in `moments`."""
        world = self.make_world()
        lab = world.scratch()
        watching = [self.make_teacher(world, **settings) for settings in teachers]
        rng = np.random.default_rng(seed)
        history: list[Moment] = []
        for moment in self.moments(world, seed, habit):
            if moment.turn == 0:
                for teacher in watching:
                    teacher.reset(rng.spawn(1)[0])
                history = []
            history.append(moment)
            yield [(atom, history[atom.about_turn], lab) for each in watching for atom in each.speak(moment).atoms]

    def judged(self, seed: int = 0) -> Iterator[tuple[Oracle, Moment]]:
        """An oracle that has started its episode, and a moment of it."""
        world = self.make_world()
        oracle = self.make_teacher(world).oracle
        for moment in self.moments(world, seed):
            if moment.turn == 0:
                oracle.start(moment.after)
            yield oracle, moment


_RANDOM = Habit(Seen.anything)
