"""The documents, and the code in them."""

import re
from pathlib import Path

ROOT = Path(__file__).parents[2]
DOCUMENTS = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```", re.MULTILINE | re.DOTALL)


def python_blocks():
    """The blocks of Python in the documents, each by the name of its document and its number there.

    A document is named by its file, or as `README.md` of a folder by that.
    """
    return {
        f"{path.parent.name if path.stem == 'README' and path.parent != ROOT else path.stem}-{number}": code
        for path in DOCUMENTS
        for number, (language, code) in enumerate(BLOCK.findall(path.read_text(encoding="utf-8")))
        if language == "python"
    }
