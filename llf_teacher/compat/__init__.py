"""LLF-Bench's surface on our environments: `import llf_teacher.compat as llfbench`, or `install()`.

Observations are as in LLF-Bench (None in families without observations), an absent instruction or feedback is `None`,
and actions are native or text. The environments of `make` and all wrappers have the attributes and methods that
LLF-Bench's users rely on. `docs/coming-from-llf-bench.md` lists the intended differences.
"""

from llf_teacher.compat.env import LLFEnv, make
from llf_teacher.compat.env_wrappers import (
    EnvCompatibility,
    FullInformationWrapper,
    RandomActionOrderWrapper,
    TerminalFreeWrapper,
    TextWrapper,
)
from llf_teacher.compat.importing import install, uninstall
from llf_teacher.compat.llf_env import Feedback, LLFWrapper
from llf_teacher.registry import supported_types

__all__ = [
    "EnvCompatibility",
    "Feedback",
    "FullInformationWrapper",
    "LLFEnv",
    "LLFWrapper",
    "RandomActionOrderWrapper",
    "TerminalFreeWrapper",
    "TextWrapper",
    "install",
    "make",
    "supported_types",
    "uninstall",
]
