"""What the checks of the conformance kits teach: a world, its teachers, and random students."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from teachers.atoms import Atom, Claim, Moment, ParseFailure
from teachers.oracle import Oracle
from teachers.personality import Personality
from teachers.session import Session
from teachers.teacher import Teacher
from teachers.testing.habits import HABITS, Habit, Seen, Unread
from worlds.world import World


class Taught(NamedTuple):
    """What a teacher said in a turn."""

    moment: Moment
    atoms: tuple[Atom, ...]
    """The feedback."""
    true: tuple[Claim, ...]
    """The claims of the oracle, and its clues."""


@dataclass(frozen=True)
class Pupil:
    """A world with the means to teach it."""

    make_world: Callable[[], World[Any]]
    make_teacher: Callable[..., Teacher]
    """Takes a world and the keyword arguments of `Teacher`."""
    max_turns: int = 20
    turns: int = 100
    """Turns that a check plays."""

    def session(self, world: World[Any], *teachers: Teacher, **settings: Any) -> Session:
        """A session of a world with these teachers, or else with a teacher of default settings."""
        return Session(world, teachers or [self.make_teacher(world)], max_turns=self.max_turns, **settings)

    def play(self, session: Session, seed: int = 0, habit: str = "") -> Iterator[Moment]:
        """Moments of random play, or of one of the `HABITS`. Each episode begins with an opening moment.

        The teachers have not yet spoken about the moment.
        """
        rng = np.random.default_rng(seed)
        world, lab = session.world, session.world.scratch()
        policy = HABITS.get(habit, _RANDOM)
        played = 0
        while played < self.turns:
            yield session.open(int(rng.integers(2**31)))
            for turn in range(1, self.max_turns + 1):
                claims = session.teacher_turns[0].claims() if habit else ()
                listed = session.info.get(world.actions_key, ()) if habit else ()
                action = policy.act(Seen(lab, session.moment, claims, listed, rng))
                if isinstance(action, Unread):
                    action = ParseFailure(repr(action[:40]), world.action_syntax)
                yield session.act(action)
                played += 1
                if session.over or played == self.turns or turn == policy.patience:
                    break

    def moments(self, world: World[Any], seed: int = 0, habit: str = "") -> Iterator[Moment]:
        """The moments of such play in a world."""
        return self.play(self.session(world, instructs=True), seed, habit)

    def episodes(self, turns: int) -> list[list[Moment]]:
        """Episodes of at least `turns` turns in all; the student follows a plan, repeats itself, or plays at random."""
        session = self.session(self.make_world(), instructs=True)
        world, oracle = session.world, session.teacher.oracle
        rng = np.random.default_rng(0)
        played: list[list[Moment]] = []
        while sum(map(len, played)) - len(played) < turns:
            moments = [session.open(int(rng.integers(2**31)))]
            while not session.over:
                draw, plan = rng.random(), oracle.plan(world.truth, 1)
                if draw < 0.4 and plan:
                    action = plan[0]
                elif draw < 0.7 and session.moment.turn:
                    action = session.moment.action
                else:
                    action = world.sample_action(rng)
                moments.append(session.act(action))
            played.append(moments)
        return played

    def taught(self, personality: str | Personality, turns: int) -> list[list[Taught]]:
        """What a teacher says in `episodes`, turn by turn."""
        world = self.make_world()
        session = self.session(world, self.make_teacher(world, personality))
        heard: list[list[Taught]] = []
        for seed, moments in enumerate(self.episodes(turns)):
            session.open(seed)
            heard.append([])
            for moment in moments:
                session.follow(moment)
                session.speak()
                atoms = tuple(atom for atom in session.atoms if atom.kind is not None)
                oracle = session.teacher.oracle
                heard[-1].append(Taught(moment, atoms, oracle.judge(moment) + oracle.clues(moment.after)))
        return heard

    def atoms(self, seed: int = 0, **settings: Any) -> Iterator[tuple[Atom, Moment, World[Any]]]:
        """All that a teacher says about random play: each atom with the moment that it is about, and a lab."""
        for said in self.said(settings, seed=seed):
            yield from said

    def said(
        self, *teachers: Mapping[str, Any], seed: int = 0, habit: str = ""
    ) -> Iterator[list[tuple[Atom, Moment, World[Any]]]]:
        """The same, turn by turn, for teachers with different settings that watch the same play."""
        world = self.make_world()
        lab, seen = world.scratch(), world.scratch()
        watching = [self.session(seen, self.make_teacher(world, **settings)) for settings in teachers]
        history: list[Moment] = []
        for number, moment in enumerate(self.moments(world, seed, habit)):
            if moment.turn == 0:
                for each in watching:
                    each.open(number)
                history = []
            history.append(moment)
            for each in watching:
                each.follow(moment)
                each.speak()
            yield [(atom, history[atom.about_turn], lab) for each in watching for atom in each.atoms]

    def judged(self, seed: int = 0, habit: str = "") -> Iterator[tuple[Oracle, Moment]]:
        """An oracle that has started its episode, and a moment of it."""
        session = self.session(self.make_world(), instructs=True)
        for moment in self.play(session, seed, habit):
            yield session.teacher.oracle, moment


_RANDOM = Habit(Seen.anything)
