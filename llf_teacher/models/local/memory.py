"""How much memory a model's server needs, and how much this machine has."""

import contextlib
import os
from pathlib import Path

from llf_teacher.models.local.gguf import Header

PROMPTS = 256
"""Memory for prompts that a server keeps beside those of its slots, in MiB."""
_PROCESS = 200_000_000  # Python, llama.cpp and their buffers, in bytes
_BATCH = 512 * 4  # bytes of a batch's numbers, per token of the vocabulary
_GROUP = Path("/sys/fs/cgroup")


def needed(header: Header, context: int, slots: int) -> int:
    """Memory that a server takes at most, about, in bytes.

    Args:
        header: of the model.
        context: tokens of context of a slot.
        slots: number of conversations at once.
    """
    buffers = header.vocabulary * _BATCH + (PROMPTS << 20) + _PROCESS
    return header.size + context * slots * header.bytes_per_token + buffers


def available() -> int | None:
    """Memory that new processes can take, in bytes; None where the system does not tell."""
    with contextlib.suppress(OSError, ValueError):
        lines = dict(line.split(":", 1) for line in Path("/proc/meminfo").read_text().splitlines())
        return min([int(lines["MemAvailable"].split()[0]) * 1024, *_of_group()])
    with contextlib.suppress(ValueError, OSError, AttributeError):  # all that there is
        return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    return None


def _of_group() -> list[int]:
    """Memory that is left to this control group, in a list; empty if it has no limit."""
    with contextlib.suppress(OSError, ValueError, KeyError):
        limit = int((_GROUP / "memory.max").read_text())
        statistics = dict(line.split() for line in (_GROUP / "memory.stat").read_text().splitlines())
        used = int((_GROUP / "memory.current").read_text())
        return [limit - used + int(statistics["inactive_file"])]
    return []


def shown(size: int) -> str:
    """A size in bytes, for readers."""
    return f"{size / 1e9:.1f} GB" if size >= 1e9 else f"{size / 1e6:.0f} MB"
