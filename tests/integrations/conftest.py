"""Frameworks that train and judge models: each folder has an environment of its own, where `.ci/integrations` tests it.

Plain pytest leaves them all out. The variable `LLF_INTEGRATION` names the folder whose packages are installed.
"""

import os
from pathlib import Path

WANTED = os.environ.get("LLF_INTEGRATION")
collect_ignore = [path.name for path in Path(__file__).parent.iterdir() if path.is_dir() and path.name != WANTED]
