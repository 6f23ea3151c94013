"""What tests of language models share: what is asked, what is answered, and what must not be kept."""

import contextlib
import re
import sqlite3

from llf_teacher.models.client import Endpoint
from llf_teacher.models.settings import ClientSettings

KEY = "sk-very-secret-0123456789"
NORTH = "Thought: it said so.\nResponse: north"
MOVES = ("north", "east", "west", "south")
REQUEST = {"model": "m", "messages": [{"role": "user", "content": "north or south?"}]}


def endpoint(url, cache=":memory:", budget=None, timeout=5.0, retries=2, key=KEY):
    return Endpoint(url, ClientSettings(key=key, cache=f"{cache}", budget=budget, timeout=timeout, retries=retries))


def ledger(path):
    with contextlib.closing(sqlite3.connect(path)) as db:
        return db.execute("SELECT input_tokens, output_tokens, usd FROM ledger").fetchall()


def files_with(text, folder):
    return [path.name for path in folder.rglob("*") if path.is_file() and text.encode() in path.read_bytes()]


def obey(request):
    """Stands for a model: the way that the teacher's last words name last, or north."""
    told = request["messages"][-1]["content"].partition("You observe")[0].lower()
    ways = [word for word in re.findall(r"[a-z]+", told) if word in MOVES]
    return f"Thought: it said so.\nResponse: {ways[-1] if ways else 'north'}"
