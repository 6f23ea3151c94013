"""Libraries for reinforcement learning: each folder has an environment of its own, in which `.ci/learn` tests it.

Plain pytest leaves them all out. The variable `LLF_LEARN` names the folder whose packages are installed.
"""

import os
from pathlib import Path

WANTED = os.environ.get("LLF_LEARN")
collect_ignore = [path.name for path in Path(__file__).parent.iterdir() if path.is_dir() and path.name != WANTED]

if WANTED:
    import torch

    torch.set_num_threads(1)  # the tests run side by side
