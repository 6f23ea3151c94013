"""`import llfbench` without LLF-Bench."""

import sys
from collections.abc import Sequence
from importlib import import_module
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from types import MappingProxyType, ModuleType

__all__ = ["install", "uninstall"]

_PLACES = MappingProxyType(
    {
        "llfbench": "llf_teacher.compat",
        "llfbench.agents": None,
        "llfbench.agents.utils": "llf_teacher.compat.agent_utils",
        "llfbench.envs": None,
        "llfbench.envs.env_wrappers": "llf_teacher.compat.env_wrappers",
        "llfbench.envs.llf_env": "llf_teacher.compat.llf_env",
        "llfbench.utils": "llf_teacher.compat.utils",
        "llfbench.utils.utils": "llf_teacher.compat.utils",
    }
)
"""What LLF-Bench's modules are here; None: they are there for their submodules only."""


class _Finder(MetaPathFinder, Loader):
    """Gives ours for LLF-Bench's modules where nobody else finds any."""

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        # A path that is not empty is that of the real package, of which there is nothing to be added.
        if fullname not in _PLACES or path:
            return None
        package = any(name.startswith(f"{fullname}.") for name in _PLACES)
        return ModuleSpec(fullname, self, origin=_PLACES[fullname], is_package=package)

    def exec_module(self, module: ModuleType) -> None:
        place = _PLACES[module.__name__]
        if place:
            ours = import_module(place)
            names = ours.__all__
            vars(module).update({name: getattr(ours, name) for name in names}, __all__=names, __doc__=ours.__doc__)


_FINDER = _Finder()


def install() -> None:
    """Let `import llfbench` and its submodules give what is here, unless LLF-Bench itself is installed.

    It is asked last, so that an installed one is found first. To do it again changes nothing.
    """
    if _FINDER not in sys.meta_path:
        sys.meta_path.append(_FINDER)


def uninstall() -> None:
    """Undo `install`: the modules that it gave have to be imported anew, from elsewhere."""
    if _FINDER in sys.meta_path:
        sys.meta_path.remove(_FINDER)
    for name in _PLACES:
        if name in sys.modules and sys.modules[name].__loader__ is _FINDER:
            del sys.modules[name]
