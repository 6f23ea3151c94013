"""What tests of local models share: small GGUF files, and a folder in which a scripted engine stands for llama.cpp."""

import json
import os
import struct
import time
from pathlib import Path

ENGINE = Path(__file__).with_name("scripted_engine")


def gguf(path, template="{{ messages }}", end=b"", **values):
    """Write the smallest GGUF file of a model."""
    facts = {"general.architecture": "llama", "llama.context_length": 4096, "llama.block_count": 2}
    facts |= {"llama.embedding_length": 64, "llama.attention.head_count": 4, "llama.attention.head_count_kv": 2}
    facts |= {"tokenizer.chat_template": template} if template else {}
    facts |= values
    data = b"GGUF" + struct.pack("<IQQ", 3, 1, len(facts) + 1)
    for name, value in facts.items():
        data += _text(name)
        data += struct.pack("<I", 8) + _text(value) if isinstance(value, str) else struct.pack("<II", 4, value)
    data += _text("tokenizer.ggml.tokens") + struct.pack("<IIQ", 9, 8, 3) + b"".join(map(_text, "abc"))
    data += _text("weight") + struct.pack("<IQIQ", 1, 8, 0, 0)
    data += b"\0" * (-len(data) % 32)
    path.write_bytes(data + b"\0" * 32 + end)
    return path


def _text(text):
    return struct.pack("<Q", len(text.encode())) + text.encode()


def requests(path):
    """The requests that the scripted engine got for a file."""
    log = path.with_suffix(".requests")
    return [json.loads(line) for line in log.read_text().splitlines()] if log.exists() else []


def lives(process):
    """Whether a process lives; one that nobody has waited for does not."""
    try:
        state = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0]
    except OSError:
        return False
    return state != "Z"


def ends(process, seconds=30.0):
    """Whether a process ends; it is waited for."""
    until = time.monotonic() + seconds
    while lives(process):
        if time.monotonic() > until:
            return False
        time.sleep(0.02)
    return True


def environment(folder):
    """The variables of a process that uses the scripted engine."""
    return {"LLF_CACHE": f"{folder}", "PYTHONPATH": os.pathsep.join([f"{ENGINE}", os.environ.get("PYTHONPATH", "")])}
