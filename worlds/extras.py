"""How extras of this distribution are installed, for messages."""


def pip_install(extra: str) -> str:
    """The command that installs an extra, and its form for a clone of the repository."""
    return f"pip install 'llf-teacher[{extra}]' (in a clone: pip install -e '.[{extra}]')"
