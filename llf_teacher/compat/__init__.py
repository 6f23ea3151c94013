"""LLF-Bench's surface on our environments: `import llf_teacher.compat as llfbench`, or `install()`.

Observations are what LLF-Bench's are (None where a family has none), `None` stands for an absent instruction or
feedback, actions may be given natively or as text, and the attributes and methods that LLF-Bench's users rely on are
on what `make` returns, and on every wrapper here. `docs/coming-from-llf-bench.md` says what differs on purpose.
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
