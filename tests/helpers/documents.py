"""The documents, and the code in them."""

import re
from pathlib import Path

ROOT = Path(__file__).parents[2]
DOCUMENTS = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]
LINKED = [
    *ROOT.glob("*.md"),
    *(ROOT / "docs").rglob("*.md"),
    *(ROOT / "docs" / "quickstart").glob("*.py"),
    ROOT / "changes" / "README.md",
]
"""What has links: the documents, and all that becomes a page of the site."""
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```", re.MULTILINE | re.DOTALL)


def python_blocks(*, shown=True):
    """The blocks of Python in the documents, each by the name of its document and its number there.

    A document is named by its file, or as `README.md` of a folder by that.

    Args:
        shown: also those before a block that shows what they print.
    """
    found = {}
    for path in DOCUMENTS:
        name = path.parent.name if path.stem == "README" and path.parent != ROOT else path.stem
        blocks = BLOCK.findall(path.read_text(encoding="utf-8"))
        for number, (language, code) in enumerate(blocks):
            printed = blocks[number + 1 : number + 2] and blocks[number + 1][0] == "output"
            if language == "python" and (shown or not printed):
                assert f"{name}-{number}" not in found, f"two documents are named {name}"
                found[f"{name}-{number}"] = code
    return found
