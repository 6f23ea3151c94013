"""The suite taken by a model behind an endpoint: here a scripted server, which has no model and costs nothing.

    python examples/suite_endpoint.py --card card.md

The script does what the teacher's words name: in a house the way that was named last in this turn, with a bandit the
arm that was named last at all. The prices are invented.
"""

import argparse
import os
import re
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from llf_teacher.models.testing import ScriptedEndpoint
from llf_teacher.suite import Card, take
from llf_teacher.suite.estimate import estimate

WAYS = ("north", "east", "south", "west")
STUDENT = "llm(model='scripted', max_tokens=50, answer='text', input_price=1.0, output_price=4.0)"


def follow(request: dict[str, Any]) -> str:
    """The answer to a request: what the teacher named, or else one action after the other."""
    said = [
        " ".join(re.findall(r"^Teacher: (.*)", each["content"], re.MULTILINE))
        for each in request["messages"]
        if each["role"] == "user"
    ]
    if WAYS[0] not in request["messages"][0]["content"]:
        arms = re.findall(r"(?<![\d.])\d(?!\.?\d)", " ".join(said))
        return f"Response: {arms[-1] if arms else len(said) % 10}"
    ways = re.findall("|".join(WAYS), said[-1].lower())
    return f"Response: {ways[-1] if ways else WAYS[len(said) % 4]}"


def played(folder: Path, quick: bool = True) -> Card:
    """The card of the scripted student; its answers are kept in the folder."""
    with ScriptedEndpoint(follow) as endpoint:
        os.environ |= {"LLF_LLM_BASE_URL": endpoint.url, "LLF_LLM_CACHE": f"{folder / 'answers.db'}"}
        print(f"The student plays {estimate(STUDENT, quick=quick)}.")
        return take(STUDENT, folder / "suite.db", quick=quick, workers=1)


def main() -> None:
    """Take the quick suite, and print the card."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--full", action="store_true", help="the whole suite")
    parser.add_argument("--card", type=Path, help="file to write: .json, .md, .svg or .html")
    args = parser.parse_args()
    with TemporaryDirectory() as folder:
        card = played(Path(folder), quick=not args.full)
    print(card.as_markdown())
    if args.card is not None:
        card.write(args.card)


if __name__ == "__main__":
    main()
