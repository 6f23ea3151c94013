"""One seed is one world, through every door; and no stream depends on another."""

import numpy as np
import pettingzoo
import pytest
from sampling import ENTRIES, practice

import llf_teacher
from llf_teacher import compat
from llf_teacher.registry import PREFIX
from pz_envs.parallel_seats import ParallelSeats
from pz_envs.scripted import SayAll
from pz_envs.seats import TEACHER
from pz_envs.subject import TUTORING, seating_names
from teachers.seeds import STREAMS, Seeds, streams_beside
from worlds.testing import plain

SEED = 20_077
SEATINGS = [each for each in seating_names() if each != "curriculum"]  # which chooses a world after its reset


def worlds(entry):
    """What each door's world is like after `reset(seed)`, by door: its whole state, random stream included."""
    name = entry.id.removeprefix(PREFIX)
    short, _, version = name.rpartition("-")
    bare = entry.family.make_world(**entry.options)
    bare.reset(seed=SEED)
    yield "world", bare
    student = llf_teacher.make(entry.id, teacher="mix | delayed", instruction_type=practice(entry.family))
    student.reset(seed=SEED)
    yield "make", student.session.world
    teacher = llf_teacher.TeacherEnv(entry.id, student="random", episodes=2)
    teacher.reset(seed=SEED)
    yield "TeacherEnv", teacher.session.world
    old = compat.make(entry.id)
    old.reset(seed=SEED)
    yield "compat", old.unwrapped.session.world
    for seating in SEATINGS:
        id = f"llf/{name}" if seating == TUTORING else f"llf/{short}-{seating}-{version}"
        env = pettingzoo.make("aec", id)
        env.reset(seed=SEED)
        seats = env.unwrapped
        yield seating, (seats.sessions[0] if hasattr(seats, "sessions") else seats.session).world
    alone = ParallelSeats(entry.family.raw_env(speech="kinds", **entry.options), {TEACHER: SayAll()})
    alone.reset(seed=SEED)
    yield "parallel", alone.env.session.world


@pytest.mark.parametrize("entry", ENTRIES)
def test_one_seed_is_one_world_through_every_door(entry):
    found = dict(worlds(entry))
    expected = plain(found["world"].save())
    assert len(found) >= 5 + len(SEATINGS)
    assert {door: plain(world.save()) == expected for door, world in found.items()} == dict.fromkeys(found, True)


def test_every_stream_is_its_own():
    first, again = Seeds(7), Seeds(7)
    drawn = {}
    for episode in range(3):
        for seat in range(2):
            for name in STREAMS:
                value = first.stream(name, seat).random()
                assert value == again.stream(name, seat).random()
                drawn[name, seat, episode] = value
        first.episode += 1
        again.episode += 1
    assert len(set(drawn.values())) == len(drawn)
    assert np.random.default_rng(7).random() not in drawn.values()


def test_streams_are_apart_from_what_a_world_spawns():
    spawned = np.random.default_rng(7).spawn(50)
    assert not {rng.random() for rng in spawned} & {Seeds(7).stream(name).random() for name in STREAMS}


def test_streams_beside_a_generator_are_their_own_and_leave_it_as_it_is():
    rng, alone = np.random.default_rng(7), np.random.default_rng(7)
    beside = [stream.random() for stream in streams_beside(rng, 3)]
    assert beside == [stream.random() for stream in streams_beside(alone, 3)]
    child, child_alone = rng.spawn(1)[0], np.random.default_rng(7).spawn(1)[0]
    drawn = [*beside, *[stream.random() for stream in streams_beside(child, 3)], rng.random(), child.random()]
    assert len(set(drawn)) == len(drawn)
    assert drawn[-2:] == [alone.random(), child_alone.random()]


def test_seeds_without_a_seed_differ():
    assert Seeds().stream("voice").random() != Seeds().stream("voice").random()
