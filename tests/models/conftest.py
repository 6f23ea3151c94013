"""A real model: `.ci/run local` tests it where llama.cpp and the model are at hand; plain pytest leaves it out.

`LLF_TEST_MODELS` names the cache folder with the model.
"""

import os
from importlib.util import find_spec
from pathlib import Path

MODELS = Path(os.environ.get("LLF_TEST_MODELS") or "-")
AT_HAND = find_spec("xllamacpp") and (MODELS / "models" / "smollm2-135m.json").exists()

collect_ignore = [] if AT_HAND else ["test_smollm2.py"]
