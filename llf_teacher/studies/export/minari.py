"""minari: Minari data sets, one per environment, teacher and feedback type, in a folder."""

import os
import re
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from gymnasium import spaces

from llf_teacher.episodes.loop import play_turns
from llf_teacher.gym import StudentEnv, make
from llf_teacher.studies.definition.custom_specs import parse_teacher
from llf_teacher.studies.definition.options import read_options
from llf_teacher.studies.export.dialogue import action_text
from llf_teacher.studies.results import Results
from teachers.personality import Personality
from worlds.actions import native
from worlds.extras import pip_install

_FOLDER = "MINARI_DATASETS_PATH"
_SETTING = ("id", "teacher", "instruction_type", "feedback_type", "max_turns", "options")


def write(results: Results, path: Path, *, text: bool = False, author: str = "unknown", email: str = "unknown") -> int:
    """Write the data sets; gives their number. Minari loads them if `MINARI_DATASETS_PATH` is the folder.

    A store has no numeric observations: episodes are replayed with the stored seed and actions, and must give the
    stored rewards. `recover_environment` gives the environment with its teacher.

    Args:
        results: the store.
        path: the folder.
        text: whether observations and actions are texts; else they are in the world's spaces, and episodes in which a
            text was no action are left out.
        author: for the metadata.
        email: of the author, for the metadata.

    Raises:
        ModuleNotFoundError: Minari is not installed.
        ValueError: a replayed episode gives other rewards.
    """
    try:
        import minari
        from minari.data_collector import EpisodeBuffer
    except ModuleNotFoundError:
        raise ModuleNotFoundError(f"the format minari needs Minari; run: {pip_install('data')}") from None
    if not isinstance(text, bool):
        raise ValueError(f"text must be True or False, got {text!r}")
    settings = dict.fromkeys(_setting(row) for row in results.rows() if _fits(row, text))
    path.mkdir(parents=True, exist_ok=True)
    with _folder(path.resolve()), warnings.catch_warnings():
        warnings.simplefilter("ignore")  # those of Minari on links to code and the like
        for setting in settings:
            id, teacher, instruction_type, feedback_type, max_turns, options = setting
            env = make(
                id,
                teacher=teacher,
                instruction_type=instruction_type,
                feedback_type=feedback_type,
                max_turns=max_turns,
                text=text,
                **{name: value for name, value in read_options(options, id, text).items() if name != "visual"},
            )
            students = {row["student"] for row in _rows(results, setting, text)}
            episodes = (EpisodeBuffer(**_played(results, row, env, text)) for row in _rows(results, setting, text))
            minari.create_dataset_from_buffers(
                dataset_id=_name(setting, text),
                buffer=episodes,
                env=env,
                algorithm_name=", ".join(sorted(students)),
                author=author,
                author_email=email,
                code_permalink="unknown",
                description=f"{id}, taught by {teacher}: instruction {instruction_type}, feedback {feedback_type}",
            )
            env.close()
    return len(settings)


def _fits(row: dict[str, Any], text: bool) -> bool:
    """Whether an episode can be replayed: it is no test after lessons, and its teacher is built in."""
    again = ":" not in row["teacher"] and isinstance(parse_teacher(row["teacher"]), Personality)
    return not row["lessons"] and again and (text or not row["parse_failures"])


def _setting(row: dict[str, Any]) -> tuple[Any, ...]:
    return tuple(row[name] for name in _SETTING)


def _rows(results: Results, setting: tuple[Any, ...], text: bool) -> Iterator[dict[str, Any]]:
    """The episodes of a data set."""
    return (row for row in results.rows() if _setting(row) == setting and _fits(row, text))


def _played(results: Results, row: dict[str, Any], env: StudentEnv, text: bool) -> dict[str, Any]:
    """The fields of an episode, which is replayed."""
    stored = results.turns(row["key"])
    did = [
        (turn.get("answer") or action_text(row["id"], turn)) if text else _native(env.action_space, turn["action"])
        for turn in stored[1:]
    ]
    seen, rewards, ends = [], [], []
    for turn, played in zip(stored, play_turns(env, _Replay(did), row["seed"]), strict=True):
        seen.append(env.observe())
        if not played.moment.turn:
            continue
        reward = played.moment.reward
        if not np.isclose(reward, turn["reward"]):
            raise ValueError(
                f"the replay of episode {row['key']} must give the stored reward {turn['reward']:g} in turn "
                f"{turn['turn']}, got {reward:g}; use the release that played it, {row['version']}"
            )
        rewards.append(float(reward))
        ends.append((played.terminated, played.truncated))
    ends[-1] = ends[-1][0], not ends[-1][0]  # a study truncates an episode at success
    return {
        "seed": row["seed"],
        "observations": _columns(seen),
        "actions": _columns(did),
        "rewards": rewards,
        "terminations": [terminated for terminated, _ in ends],
        "truncations": [truncated for _, truncated in ends],
        "infos": {},
    }


class _Replay:
    """A policy that repeats stored actions."""

    def __init__(self, actions: list[Any]) -> None:
        self._actions = actions

    def reset(self, rng: np.random.Generator) -> None:
        """Begin the episode."""
        self._left = iter(self._actions)

    def act(self, observation: Any, info: dict[str, Any]) -> Any:
        """The next action."""
        return next(self._left)


def _columns(values: list[Any]) -> Any:
    """A list of dicts or tuples as a dict or tuple of lists."""
    if isinstance(values[0], dict):
        return {name: _columns([value[name] for value in values]) for name in values[0]}
    if isinstance(values[0], tuple):
        return tuple(_columns(list(parts)) for parts in zip(*values, strict=True))
    return values


def _native(space: spaces.Space[Any], action: Any) -> Any:
    """An action, decoded from JSON, as an element of the space."""
    if isinstance(space, spaces.Discrete):
        return np.int64(action)
    return native(space, action)


def _name(setting: tuple[Any, ...], text: bool) -> str:
    """The id of a data set, such as `llf/gridworld-oracle-b-a-20-native-v0`."""
    id, *rest = setting
    name, _, version = id.removeprefix("llf-").rpartition("-v")
    words = filter(None, [name, *rest, "text" if text else "native"])
    return f"llf/{'-'.join(re.sub(r'[^A-Za-z0-9]+', '_', f'{word}').strip('_') for word in words)}-v{version}"


@contextmanager
def _folder(path: Path) -> Iterator[None]:
    """Set the folder of Minari's data sets."""
    before = os.environ.get(_FOLDER)
    os.environ[_FOLDER] = f"{path}"
    try:
        yield
    finally:
        if before is None:
            del os.environ[_FOLDER]
        else:
            os.environ[_FOLDER] = before
