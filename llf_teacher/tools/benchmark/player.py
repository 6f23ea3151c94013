"""The process that plays episodes for benchmarks and comparisons, and answers with times or with records.

Each environment is made once and reset for each episode. The process can import another installation of these packages
than its parent, so this module uses only public names: `llf_teacher.make` and other names of the package itself, and
the methods of environments and families. It reads pickled calls of `FORMS` from standard input, and writes pickled
results to standard output; its parent is `measuring.Player`.
"""

import gc
import pickle
import resource
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import fields, is_dataclass
from functools import cache
from itertools import chain, islice
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter, process_time
from typing import Any, NamedTuple

_ROUND = 50  # steps in arrays whose actions are drawn at once
Script = tuple[int, Sequence[Any]]
"""An episode to play: its seed, and the student's actions."""


class Times(NamedTuple):
    """Times of some episodes, in seconds."""

    steps: list[float]
    """Wall time of each step."""
    resets: list[float]
    """Wall time of each reset."""
    cpu: float
    """CPU time of all steps together."""
    peak: float
    """Peak memory of the process so far, in MB."""


def lake(scripts: Sequence[Script]) -> Times:
    """Steps of Gymnasium's FrozenLake."""
    return _steps(_lake(), scripts)


@cache
def _lake() -> Any:
    import gymnasium

    return gymnasium.make("FrozenLake-v1")


def student(scripts: Sequence[Script], id: str, feedback_type: str) -> Times:
    """Steps of the student's environment."""
    return _steps(_student(id, feedback_type), scripts)


@cache
def _student(id: str, feedback_type: str) -> Any:
    import llf_teacher

    return llf_teacher.make(id, feedback_type=feedback_type)


def world(scripts: Sequence[Script], id: str) -> Times:
    """Steps of the bare world."""
    return _steps(_world(id), scripts)


@cache
def _world(id: str) -> Any:
    return _family_of(id).make_world(**_options_of(id))


def original(scripts: Sequence[Script], id: str) -> Times:
    """Steps of the environment of another package that the world reimplements."""
    bare = _world(id)
    times = [_steps(bare.original(actions, seed), [(seed, actions)]) for seed, actions in scripts]
    steps, resets, cpu, _ = zip(*times, strict=True)
    return Times([*chain(*steps)], [*chain(*resets)], sum(cpu), peak())


def tictactoe(scripts: Sequence[Script]) -> Times:
    """Turns of PettingZoo's tictactoe; each player takes the first free square."""

    def first_free(observation: Any, agent: str) -> int:
        return int(observation["action_mask"].argmax())

    return _turns(_tictactoe(), ((seed, first_free) for seed, _ in scripts))


@cache
def _tictactoe() -> Any:
    import pettingzoo

    return pettingzoo.make("aec", "classic/tictactoe-v3").unwrapped


def seats(scripts: Sequence[Script], id: str, form: str, students: int = 0, silent: bool = False) -> Times:
    """Turns of an AEC environment, `raw_env` or `env`; with `students` a classroom. The teacher says all or nothing."""
    return _turns(_seats(id, form, students), ((seed, _actors(actions, silent)) for seed, actions in scripts))


@cache
def _seats(id: str, form: str, students: int) -> Any:
    options: dict[str, Any] = {"speech": "kinds", **_options_of(id)}
    if students:
        options |= {"seating": "classroom", "students": students, "attention": students, "until_success": False}
    return getattr(_family_of(id), form)(**options)


def teacher(scripts: Sequence[Script], id: str) -> Times:
    """Steps of the teacher's environment, in which the teacher says everything; a step is a turn of each seat."""
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


def study(scripts: Sequence[Script], id: str, spec: str) -> Times:
    """The mean turn of a study with the seeds of the scripts: episodes are played, stored and counted in this process.

    Its student is `spec`, and it chooses its own actions.
    """
    from llf_teacher.studies import Study, run

    planned = Study(ids=[id], teachers=("oracle",), students=(spec,), seeds=tuple(seed for seed, _ in scripts))
    with TemporaryDirectory() as folder:
        begin, started = perf_counter(), process_time()
        results = run(planned, Path(folder) / "study.db", 1)
        cpu, wall = process_time() - started, perf_counter() - begin
        turns = sum(row["turns"] for row in results.rows())
        del results  # closes the file; older installations have no `close`
    return Times([wall / turns] * turns, [0.0], cpu, peak())


def record(scripts: Sequence[Script], id: str, personality: str) -> tuple[list[str], ...]:
    """All results of the student's environment, as a text for the reset and for each step, floats to the last bit."""
    import llf_teacher

    types = sorted(llf_teacher.supported_types(id)[0])
    envs = [llf_teacher.make(id, teacher=personality, instruction_type=each) for each in types]
    return tuple(
        [_written(answer) for answer in _answers(envs[seed % len(envs)], seed, actions)] for seed, actions in scripts
    )


def rows(scripts: Sequence[Script], make: bytes, number: int, steps: int) -> tuple[float]:
    """The rate of an environment in arrays; the pickled `make` makes it for a number of rows."""
    return (rate(_made(make, number), steps),)


@cache
def _made(make: bytes, number: int) -> Any:
    return pickle.loads(make)(num_envs=number)  # noqa: S301  # of the parent process


def rate(env: Any, steps: int) -> float:
    """Steps of all rows per second, in millions; drawing the actions is not timed."""
    env.reset(seed=0)
    env.reset()
    env.step(next(_fresh(env)))
    fresh = _fresh(env)
    spent, done = 0.0, 0
    while done < steps:
        actions = list(islice(fresh, min(_ROUND, steps - done)))  # no action is played twice
        begin = process_time()
        for each in actions:
            env.step(each)
        spent += process_time() - begin
        done += len(actions)
    return float(done * env.num_envs / spent / 1e6)


def resident(scripts: Sequence[Script], make: bytes, number: int, steps: int) -> tuple[float]:
    """The peak memory of this process per row, for a number of rows, in kB."""
    peaks = []
    for count in (1, number):
        env = _made(make, count)
        env.reset(seed=0)
        for actions in islice(_fresh(env), steps):
            env.step(actions)
        peaks.append(peak())
    return ((peaks[1] - peaks[0]) * 2**20 / number / 1000,)


def _fresh(env: Any) -> Iterator[Any]:
    """Random actions for all rows, without end."""
    import numpy as np

    rng, space = np.random.default_rng(0), env.single_action_space
    while True:
        if hasattr(space, "n"):
            yield rng.integers(int(space.n), size=env.num_envs)
        else:
            yield rng.uniform(space.low, space.high, (env.num_envs, *space.shape))


FORMS: dict[str, Callable[..., tuple[Any, ...]]] = {
    form.__name__: form
    for form in (lake, student, world, original, tictactoe, seats, teacher, study, record, rows, resident)
}


class _Actor:
    """A student that plays scripts, one in each episode."""

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
    return Times(steps, resets, cpu, peak())


def _turns(env: Any, episodes: Iterator[tuple[int, Callable[[Any, str], Any]]]) -> Times:
    """The times of an AEC environment's turns, each with `last`, as in the usual loop."""
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
    return Times(steps, resets, cpu, peak())


def _actors(actions: Sequence[Any], silent: bool) -> Callable[[Any, str], Any]:
    """A policy for both seats: teachers say all or nothing, students play the script."""
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


def peak() -> float:
    """Greatest resident memory of this process so far, in MB."""
    try:  # unlike `getrusage`, this does not count memory of the parent process
        status = Path("/proc/self/status").read_text(encoding="ascii")
        return int(status.partition("VmHWM:")[2].split()[0]) / 1024
    except (OSError, IndexError):
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def main() -> None:
    """Answer calls until standard input ends."""
    calls, answers = sys.stdin.buffer, sys.stdout.buffer
    sys.stdout = sys.stderr  # simulators print, too
    while True:
        try:
            form, arguments = pickle.load(calls)  # noqa: S301  # of the parent process
        except EOFError:
            return
        gc.collect()  # a collection within a block would double its time
        pickle.dump(tuple(FORMS[form](*arguments)), answers)
        answers.flush()


if __name__ == "__main__":
    main()
