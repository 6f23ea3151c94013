"""What `pyproject.toml` cannot say: README as a package index shows it, where links of the repository lead nowhere."""

import re
from pathlib import Path

from setuptools import setup

HERE = Path(__file__).parent
(REPOSITORY,) = re.findall(
    r'^Repository = "(.+)"$', (HERE / "pyproject.toml").read_text(encoding="utf-8"), re.MULTILINE
)
(VERSION,) = re.findall(
    r'^__version__ = "(.+)"$', (HERE / "llf_teacher" / "__init__.py").read_text("utf-8"), re.MULTILINE
)


LINK = re.compile(r"""(!?\[[^]]*\]\(|\b(?:src|srcset|href)=")(?![a-z]+:|#)([^)"]+)""")
"""A link or an image to a file of the repository, in Markdown or HTML."""


def absolute(link: re.Match[str]) -> str:
    """The same link to the release's file; an image is the file itself, not its page."""
    before, file = link.groups()
    return f"{before}{REPOSITORY}/{'raw' if before.startswith(('!', 'src')) else 'blob'}/v{VERSION}/{file}"


readme = (HERE / "README.md").read_text(encoding="utf-8")
setup(long_description=LINK.sub(absolute, readme), long_description_content_type="text/markdown")
