"""TextWorld's own engine, set up as in the `alfworld` package: the reference for the exact one.

TextWorld keeps every fact of every game in a cache, which is cleared for each game, since facts are equal by value. The
PDDL planner is a shared library with a single state, which cannot be unloaded safely. All engines of a process share
it; each loads its state before it uses the library. Translating a problem overwrites `sys.argv` and redirects
`sys.stdout`; both are restored.
"""

import re
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from typing import Any

from worlds.alfworld.games import CHANGING, Fact, Game
from worlds.alfworld.shipped import package, rules

__all__ = ["StockEngine"]

_LOCK = threading.RLock()
_STATE = re.compile(r"begin_state\n(.*?)\nend_state", re.DOTALL)
_VARIABLE = re.compile(r"begin_variable\n\w+\n(-?\d+)\n\d+\nAtom (\w\S*)\((.*?)\)\n")
_owner: Any = None  # the engine whose state the library holds


@contextmanager
def _library_lock() -> Iterator[None]:
    """Lock the library and restore `sys.argv` and `sys.stdout` afterwards."""
    with _LOCK:
        argv, stdout = sys.argv, sys.stdout
        try:
            yield
        finally:
            sys.argv, sys.stdout = argv, stdout


@cache
def _library() -> Any:
    import fast_downward

    return fast_downward.load_lib()


def _memory() -> dict[Any, Any]:
    """TextWorld's cache of facts."""
    from mementos import core

    facts: dict[Any, Any] = core._memento_cache
    return facts


@cache
def _environment() -> type:
    """The class of TextWorld's environment, with the library of this process."""
    package()
    import textworld
    from textworld.envs import PddlEnv

    class Environment(PddlEnv):
        def __init__(self) -> None:
            textworld.Environment.__init__(self, textworld.EnvInfos(admissible_commands=True, won=True))
            self.downward_lib = _library()

    return Environment


class StockEngine:
    """TextWorld's engine with the interface of `worlds.alfworld.exact.ExactEngine`.

    Args:
        game: the game to play, from its start.
    """

    def __init__(self, game: Game) -> None:
        global _owner
        self.game = game
        domain, grammar = rules()
        with _library_lock():
            self._env = _environment()()
            _memory().clear()
            _owner = self
            grammar = grammar.replace("UNKNOWN GOAL", game.goal)
            self._env.load({"pddl_domain": domain, "grammar": grammar, "pddl_problem": game.problem})
            from alfworld.agents.utils.misc import Demangler

            infos = self._env._entity_infos
            named = Demangler(game_infos=infos, shuffle=False)
            for info in infos.values():
                info.name = named.demangle_alfred_name(info.id)
            self._sas: str = self._env._pddl_state.sas
            self._variables = [
                (int(layer), (name, *filter(None, arguments.split(", "))))
                for layer, name, arguments in _VARIABLE.findall(self._sas)
            ]
            self._signs = _STATE.findall(self._sas)[0].split("\n")
            if len(self._signs) != len(self._variables):
                raise RuntimeError(
                    f"{len(self._variables)} variables, but {len(self._signs)} values in the translation"
                )
        self.load(game.start)

    @property
    def facts(self) -> frozenset[Fact]:
        """The true facts of `CHANGING` predicates, and those that have become false, as `not_...`."""
        return frozenset(fact for fact in self.all_facts() if fact[0].removeprefix("not_") in CHANGING)

    def all_facts(self) -> frozenset[Fact]:
        """All of TextWorld's facts except the planner's auxiliary ones."""
        facts = ((fact.name, *fact.names) for fact in self._env._pddl_state.facts)
        return frozenset(fact for fact in facts if not fact[0].startswith("new-axiom"))

    def load(self, facts: frozenset[Fact]) -> None:
        """Load a state."""
        from textworld import GameState
        from textworld.logic import Proposition, Variable

        with _library_lock():
            state = self._env._pddl_state
            for fact in list(state.facts):
                if fact.name.removeprefix("not_") in CHANGING:
                    state.remove_fact(fact)
            state.add_facts(
                Proposition(name, [Variable(each, state.name2type[each]) for each in arguments])
                for name, *arguments in sorted(facts)
            )
            self._hand_over()
            env = self._env
            env.state, env.prev_state, env._last_action, env._moves = GameState(), None, None, 0
            env._gather_infos()

    def _hand_over(self) -> None:
        """Load this engine's state into the library."""
        global _owner
        known = self.all_facts()
        values = [
            sign if layer >= 0 or fact[0] not in CHANGING else str(int(fact not in known))
            for sign, (layer, fact) in zip(self._signs, self._variables, strict=True)
        ]
        sas = _STATE.sub(lambda _: "begin_state\n" + "\n".join(values) + "\nend_state", self._sas)
        self._env.downward_lib.load_sas(sas.encode())
        _owner = self

    def intro(self) -> str:
        """The introduction to the game."""
        state, infos = self._env._pddl_state, self._env._entity_infos
        context = {"state": state, "facts": list(state.facts), "variables": {}, "mapping": {}, "entity_infos": infos}
        with _library_lock():
            return str(self._env._logic.grammar.derive("#intro#", context))

    def commands(self) -> list[str]:
        """The commands that can be carried out, sorted."""
        return list(self._env.state["admissible_commands"])

    def do(self, command: str) -> str:
        """Carry out a command; returns the answer."""
        with _library_lock():
            if _owner is not self:
                self._hand_over()
            return str(self._env.step(command)[0].feedback)

    def won(self) -> bool:
        """Whether the goal is reached in the current state."""
        return bool(self._env.state["won"])
