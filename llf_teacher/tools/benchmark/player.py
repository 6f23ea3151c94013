"""What is timed or compared, in a process of its own: it plays what it is sent, and answers with times or with records.

An environment is made once and reset again and again, as its users do. The process may run another installation of this
package than the one that asks, so that this module keeps to what every release offers. It reads pickled calls of
`FORMS` from its standard input, and writes pickled results to its standard output. Both ends are ours.
"""

import gc
import pickle
import resource
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import fields, is_dataclass
from functools import cache
from itertools import chain
from pathlib import Path
from time import perf_counter, process_time
from typing import Any, NamedTuple

Script = tuple[int, Sequence[Any]]
"""An episode to play: its seed, and the student's actions."""


class Times(NamedTuple):
    """What some episodes took, in seconds."""

    steps: list[float]
    """Of each step, on the clock."""
    resets: list[float]
    """Of each reset, on the clock."""
    cpu: float
    """Of all steps, on the processor."""
    peak: float
    """MB that the process has used at most, until now."""


def lake(scripts: Sequence[Script]) -> Times:
    """FrozenLake's steps, by Gymnasium alone."""
    return _steps(_lake(), scripts)


@cache
def _lake() -> Any:
    import gymnasium

    return gymnasium.make("FrozenLake-v1")


def student(scripts: Sequence[Script], id: str, feedback_type: str) -> Times:
    """The student's environment."""
    return _steps(_student(id, feedback_type), scripts)


@cache
def _student(id: str, feedback_type: str) -> Any:
    import llf_teacher

    return llf_teacher.make(id, feedback_type=feedback_type)


def world(scripts: Sequence[Script], id: str) -> Times:
    """The bare world."""
    return _steps(_world(id), scripts)


@cache
def _world(id: str) -> Any:
    return _family_of(id).make_world(**_options_of(id))


def original(scripts: Sequence[Script], id: str) -> Times:
    """The environment of another package whose work the world does."""
    bare = _world(id)
    times = [_steps(bare.original(actions, seed), [(seed, actions)]) for seed, actions in scripts]
    steps, resets, cpu, _ = zip(*times, strict=True)
    return Times([*chain(*steps)], [*chain(*resets)], sum(cpu), _peak())


def tictactoe(scripts: Sequence[Script]) -> Times:
    """PettingZoo's tictactoe: the first square that is free."""

    def first_free(observation: Any, agent: str) -> int:
        return int(observation["action_mask"].argmax())

    return _turns(_tictactoe(), ((seed, first_free) for seed, _ in scripts))


@cache
def _tictactoe() -> Any:
    import pettingzoo

    return pettingzoo.make("aec", "classic/tictactoe-v3").unwrapped


def seats(scripts: Sequence[Script], id: str, form: str, students: int = 0, silent: bool = False) -> Times:
    """An AEC environment, `raw_env` or `env`, of a class if there are `students`; its teacher says all, or nothing."""
    return _turns(_seats(id, form, students), ((seed, _actors(actions, silent)) for seed, actions in scripts))


@cache
def _seats(id: str, form: str, students: int) -> Any:
    options: dict[str, Any] = {"speech": "kinds", **_options_of(id)}
    if students:
        options |= {"seating": "classroom", "students": students, "attention": students, "until_success": False}
    return getattr(_family_of(id), form)(**options)


def teacher(scripts: Sequence[Script], id: str) -> Times:
    """The teacher's environment, where it says everything; each step is a turn of each seat."""
    env, played = _teacher(id)
    subsets = int(env.action_space.n)
    everything = []
    for seed, actions in scripts:
        played.scripts.append(list(actions))
        everything.append((seed, [subsets - 1] * len(actions)))
    return _steps(env, everything)


@cache
def _teacher(id: str) -> tuple[Any, "_Actor"]:
    import llf_teacher

    played = _Actor()
    return llf_teacher.TeacherEnv(id, student=played), played


def record(scripts: Sequence[Script], id: str, personality: str) -> tuple[list[str], ...]:
    """All that the student's environment answers, reset first: a text of each turn, floats to the last bit."""
    import llf_teacher

    types = sorted(llf_teacher.make(id).teacher.oracle.instruction_types)
    envs = [llf_teacher.make(id, teacher=personality, instruction_type=each) for each in types]
    return tuple(
        [_written(answer) for answer in _answers(envs[seed % len(envs)], seed, actions)] for seed, actions in scripts
    )


FORMS: dict[str, Callable[..., tuple[Any, ...]]] = {
    form.__name__: form for form in (lake, student, world, original, tictactoe, seats, teacher, record)
}


class _Actor:
    """A student that acts as its scripts say, one for each episode."""

    def __init__(self) -> None:
        self.scripts: list[list[Any]] = []
        self._actions: Iterator[Any] = iter(())

    def reset(self, rng: Any) -> None:
        """Take the next script."""
        self._actions = iter(self.scripts.pop(0))

    def act(self, observation: Any, info: Any) -> Any:
        """The next action."""
        return next(self._actions)


def _family_of(id: str) -> Any:
    from llf_teacher.registry import entry

    return entry(id).family


def _options_of(id: str) -> dict[str, Any]:
    from llf_teacher.registry import entry

    return dict(entry(id).options)


def _steps(env: Any, scripts: Sequence[Script]) -> Times:
    steps, resets, cpu = [], [], 0.0
    for seed, actions in scripts:
        begin = perf_counter()
        env.reset(seed=seed)
        resets.append(perf_counter() - begin)
        started = process_time()
        for action in actions:
            begin = perf_counter()
            ended = env.step(action)[2:4]
            steps.append(perf_counter() - begin)
            if any(ended):
                break
        cpu += process_time() - started
    return Times(steps, resets, cpu, _peak())


def _turns(env: Any, episodes: Iterator[tuple[int, Callable[[Any, str], Any]]]) -> Times:
    """An AEC environment's turns, each with `last`, as its users play it."""
    steps, resets, cpu = [], [], 0.0
    for seed, choose in episodes:
        begin = perf_counter()
        env.reset(seed=seed)
        resets.append(perf_counter() - begin)
        started = process_time()
        for agent in env.agent_iter():
            begin = perf_counter()
            observation, _, terminated, truncated, _ = env.last()
            try:
                action = None if terminated or truncated else choose(observation, agent)
            except StopIteration:
                break
            env.step(action)
            steps.append(perf_counter() - begin)
        cpu += process_time() - started
    return Times(steps, resets, cpu, _peak())


def _actors(actions: Sequence[Any], silent: bool) -> Callable[[Any, str], Any]:
    """Teachers say the most that they can say, or the least; students act as the script says."""
    script = chain(actions)

    def choose(observation: Any, agent: str) -> Any:
        if not agent.startswith("teacher"):
            return next(script)
        mask = observation["action_mask"]
        return int(mask.argmax()) if silent else len(mask) - 1 - int(mask[::-1].argmax())

    return choose


def _answers(env: Any, seed: int, actions: Sequence[Any]) -> Iterator[Any]:
    observation, info = env.reset(seed=seed)
    yield observation, info["atoms"]
    for action in actions:
        observation, reward, terminated, truncated, info = env.step(action)
        yield observation, reward, terminated, truncated, info["success"], info["atoms"]
        if terminated or truncated:
            return


def _written(value: Any) -> str:
    if is_dataclass(value) and not isinstance(value, type):
        said = ", ".join(f"{field.name}={_written(getattr(value, field.name))}" for field in fields(value))
        return f"{type(value).__name__}({said})"
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{key!r}: {_written(each)}" for key, each in value.items()) + "}"
    if isinstance(value, tuple):
        return "(" + ", ".join(map(_written, value)) + ")"
    return repr(value.tolist() if hasattr(value, "tolist") else value)


def _peak() -> float:
    try:  # the system counts what the process that began this one used, too, but not here
        status = Path("/proc/self/status").read_text(encoding="ascii")
        return int(status.partition("VmHWM:")[2].split()[0]) / 1024
    except (OSError, IndexError):
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def main() -> None:
    """Answer until nothing more is asked."""
    calls, answers = sys.stdin.buffer, sys.stdout.buffer
    sys.stdout = sys.stderr  # what simulators print is no answer
    while True:
        try:
            form, arguments = pickle.load(calls)  # noqa: S301  # of the process that began this one
        except EOFError:
            return
        gc.collect()  # of all modules: if it came within a block, it would double its time
        pickle.dump(tuple(FORMS[form](*arguments)), answers)
        answers.flush()


if __name__ == "__main__":
    main()
