"""What tests of language models share: what is asked, what is answered, and what must not be kept."""

import contextlib
import json
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


def heard(request):
    """The teacher's last words in a request."""
    return "".join(re.findall(r"^Teacher: (.*)", request["messages"][-1]["content"], re.MULTILINE)[-1:])


def obey(request):
    """Stands for a model: the way that the teacher's last words name last, or north."""
    told = heard(request).lower()
    ways = [word for word in re.findall(r"[a-z]+", told) if word in MOVES]
    return f"Thought: it said so.\nResponse: {ways[-1] if ways else 'north'}"


ANSWERS = {
    "words": "Go north, I would say.",
    "nothing": "",
    "deep": '{"claims": ' + "[" * 20_000,
    "another family": '{"claims": [{"type": "Pull", "action": 0}]}',
    "wrong types": '{"claims": [{"type": "Go", "action": {"way": "north"}}]}',
    "endless number": '{"claims": [{"type": "Reward", "reward": 1e999}]}',
    "long number": '{"claims": [{"type": "Reward", "reward": ' + "9" * 5000 + "}]}",
    "huge": json.dumps({"claims": [{"type": "Found", "room": "x" * 100_000}]}),
    "twice": '{"claims": [], "claims": [{"type": "Solved"}]}',
    "the key": f'{{"claims": [{{"type": "Found", "room": "{KEY}"}}, {{"type": "{KEY}"}}]}}',
    "code": '{"claims": [{"type": "__import__(\'os\').system(\'true\')"}]}',
}
"""Answers of a hostile model in place of a claim."""
LONG = 1_500_000
HUGE = {
    "lists": '{"claims": ' + "[" * LONG,
    "objects": '{"claims": [{"type": ' * (LONG // 21),
    "many claims": json.dumps({"claims": [{"type": "Reward", "reward": 0.5}] * (LONG // 40)}),
    "many sentences": json.dumps({"claims": [{"type": "Solved"}] * 32, "text": "Go. " * 2_000}),
    "a long sentence": json.dumps({"claims": [{"type": "Solved"}] * 32, "text": "Go " * 2_700}),
    "many keys": json.dumps({"claims": [{f"k{n}": 0 for n in range(LONG // 12)}]}),
    "a long name": json.dumps({"claims": [{"type": "Go" * (LONG // 2)}]}),
    "a long plan": json.dumps({"claims": [{"type": "Plan", "actions": ["north"] * (LONG // 10)}]}),
    "words": "Go north. " * (LONG // 10),
}
"""Such answers of more than a megabyte, or with many claims and sentences."""
