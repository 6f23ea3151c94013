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
"""Per module of LLF-Bench the module here; None: a package that only has submodules."""


class _Finder(MetaPathFinder, Loader):
    """Finds LLF-Bench's modules here if no other finder has found them."""

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        # A non-empty path is that of the real package, to which nothing is added.
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
