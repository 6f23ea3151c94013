"""The costs of a study's models, and warnings about their answers, as lines for the command line."""

from collections.abc import Iterator

from llf_teacher.models.local.catalogue import is_local
from llf_teacher.studies.store import Store

MANY = 0.05
"""Greatest share of answers that are not actions without a warning."""


def cost_lines(store: Store) -> Iterator[str]:
    """A line for each model that was asked, and for each student whose answers were cut or often were not actions."""
    for spent in store.manifest().get("llm", ()):
        unpriced = spent.get("unpriced", 0)
        price = f"{spent['usd']:.4f} USD" if unpriced < spent["requests"] else "at an unknown price"
        rest = f", without {unpriced} of unknown price" if 0 < unpriced < spent["requests"] else ""
        free = is_local(spent["model"]) and not spent["usd"]
        trials = f", {spent['trials']} of them to try the form of answers" if spent.get("trials") else ""
        yield (
            f"{spent['model']}: {spent['requests']} requests {'' if free else 'paid '}so far{trials}, "
            f"{spent['input_tokens']} tokens in, {spent['output_tokens']} out, "
            f"{'on this machine, free of charge' if free else price + rest}"
        )
        if form := spent.get("form"):
            yield f"{spent['model']}: asked for answers as {form}"
        if lost := spent.get("lost"):
            yield f"{spent['model']}: no reply to {lost} of {spent['sent']} requests, which may be charged nevertheless"
    for row in store.answers():
        student, answers, failures = row["student"], row["answers"], row["parse_failures"]
        if row["truncated"]:
            yield f"{student}: {row['truncated']} of {answers} answers were cut for their length; raise max_tokens"
        keys = [row["key"] for row in store.episodes() if row["student"] == student]
        if invented := sum(turn["invented"] is not None for key in keys for turn in store.turns(key)):
            yield f"{student}: {invented} of {answers} answers went on to speak for others; that part was cut"
        if failures > MANY * answers:
            yield f"{student}: {failures} of {answers} answers were no actions; see the transcripts"
