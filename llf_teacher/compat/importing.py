"""`import llfbench` without LLF-Bench."""

import sys
from collections.abc import Sequence
from importlib import import_module
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from types import MappingProxyType, ModuleType
from typing import Any

__all__ = ["install", "uninstall"]

_FAMILIES = ("alfworld", "bandits", "gridworld", "highway", "metaworld", "optimization", "poem", "reco")

_PLACES = MappingProxyType(
    {
        "llfbench": "llf_teacher.compat",
        "llfbench.agents": None,
        "llfbench.agents.abstract_agent": "llf_teacher.compat.abstract_agent",
        "llfbench.agents.basic_ai_agent": None,
        "llfbench.agents.llm": None,
        "llfbench.agents.user_agent": None,
        "llfbench.agents.utils": "llf_teacher.compat.agent_utils",
        "llfbench.envs": None,
        "llfbench.envs.env_wrappers": "llf_teacher.compat.env_wrappers",
        "llfbench.envs.llf_env": "llf_teacher.compat.llf_env",
        "llfbench.envs.utils": None,
        **{f"llfbench.envs.{family}": None for family in _FAMILIES},
        "llfbench.utils": "llf_teacher.compat.utils",
        "llfbench.utils.parser_utils": None,
        "llfbench.utils.utils": "llf_teacher.compat.utils",
    }
)
"""For each module of LLF-Bench, the module here; None if it only has submodules, or names in `_REFUSED`."""

_MODELS = "play llf_teacher's student `llm`, see docs/language-models.md"
_REFUSED = MappingProxyType(
    {
        "llfbench.agents.basic_ai_agent": {"BasicAIAgent": _MODELS},
        "llfbench.agents.llm": dict.fromkeys(("GPT", "LLM", "call_model", "make_llm"), _MODELS),
        "llfbench.agents.user_agent": {"UserAgent": "answer by hand in `llf play`"},
        "llfbench.envs.utils": {"format": "use the method `format` of LLFWrapper, which draws from its own stream"},
        "llfbench.utils.parser_utils": {"SimpleGuidanceParser": "write prompts with str.format"},
        **{f"llfbench.envs.{family}": {"make_env": "use llfbench.make(id)"} for family in _FAMILIES},
    }
)
"""For each module of LLF-Bench, the names that are not offered, each with its replacement."""


def _refusing(module: str, name: str, instead: str) -> type:
    """A placeholder for a name that is not offered: it can be imported, but neither called nor subclassed."""

    def refuse(*args: Any, **kwargs: Any) -> None:
        raise TypeError(f"{module}.{name} is not offered by llf_teacher; {instead}")

    return type(name, (), {"__new__": refuse, "__init_subclass__": refuse, "__module__": module})


class _Finder(MetaPathFinder, Loader):
    """Finds LLF-Bench's modules here if no other finder has found them."""

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        # A non-empty path belongs to the real package, which stays as it is.
        if fullname.partition(".")[0] != "llfbench" or path:
            return None
        if fullname not in _PLACES:
            raise ModuleNotFoundError(
                f"{fullname} is not offered by llf_teacher; docs/coming-from-llf-bench.md says what is", name=fullname
            )
        return ModuleSpec(fullname, self, origin=_PLACES[fullname], is_package=True)

    def exec_module(self, module: ModuleType) -> None:
        names = {
            name: _refusing(module.__name__, name, instead)
            for name, instead in _REFUSED.get(module.__name__, {}).items()
        }
        place = _PLACES[module.__name__]
        if place:
            ours = import_module(place)
            names |= {name: getattr(ours, name) for name in ours.__all__}
            module.__doc__ = ours.__doc__
        vars(module).update(names, __all__=[*names])
        for submodule in _PLACES:
            if submodule.rpartition(".")[0] == module.__name__:
                import_module(submodule)


_FINDER = _Finder()


def install() -> None:
    """Let `import llfbench` and its submodules import the modules here, unless LLF-Bench itself is installed.

    The finder is the last one, so an installed LLF-Bench is found first. Further calls change nothing.
    """
    if _FINDER not in sys.meta_path:
        sys.meta_path.append(_FINDER)


def uninstall() -> None:
    """Undo `install`; its modules are removed from `sys.modules`."""
    if _FINDER in sys.meta_path:
        sys.meta_path.remove(_FINDER)
    for name in _PLACES:
        if name in sys.modules and sys.modules[name].__loader__ is _FINDER:
            del sys.modules[name]
