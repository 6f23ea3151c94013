"""How well the sentences of others are read: the share that is read, and of that the share that is read right."""

import math
import string
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import NamedTuple
from zlib import crc32

import numpy as np
from numpy.typing import NDArray
from rich.table import Table
from scipy.stats import binomtest

from pz_envs.family import Family
from pz_envs.reading import known_phrases, make_reader, same_value
from pz_envs.subject import Subject
from teachers.atoms import Claim
from teachers.common import Better
from teachers.near import Near, load_synonyms
from teachers.reading import own_phrases
from teachers.schema import Vocabulary
from teachers.templates import Template
from teachers.testing import Pupil

LEVEL = 0.95
"""Of the interval of a precision, by Clopper and Pearson."""
LEFT_OUT, SENTENCES = "left out", "sentences"
"""What was read: phrases of all voices, each by a reader that does not know it; and labelled sentences of people."""


class LabelledSentence(NamedTuple):
    """A sentence with what it states."""

    family: str
    claim: str | None
    """The name of the claim; None: nothing that can be checked."""
    slots: Mapping[str, str]
    text: str


class Result(NamedTuple):
    """What became of a sentence."""

    what: str
    """`LEFT_OUT` or `SENTENCES`."""
    family: str
    layer: str
    """The layer that read it; empty if none did."""
    stated: str
    """The claim that it states; empty: none."""
    read: str
    """The claim that was read; empty: none."""
    right: bool
    """Whether claim and slots are those that it states."""
    text: str
    lead: float = 0.0
    """How clear the claim was, for phrases that are left out."""
    phrase: str = ""
    """The phrase that was left out."""


def labelled(path: Path) -> Iterator[LabelledSentence]:
    """The sentences of a file, whose form its head describes.

    Raises:
        ValueError: a line has another form.
    """
    family = ""
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
        if not line or line.startswith("#"):
            continue
        if line.startswith("["):
            family = line[1:-1]
            continue
        label, between, text = line.partition(" | ")
        name, _, rest = label.partition(" ")
        pairs = [pair.partition("=") for pair in rest.split("; ")] if rest else []
        if not (family and between and text and all(equals for _, equals, _ in pairs)):
            raise ValueError(f"{path}, line {number} must be `CLAIM slot=value; ... | sentence`, got {line!r}")
        yield LabelledSentence(family, None if name == "-" else name, {slot: value for slot, _, value in pairs}, text)


def read_sentences(sentences: Iterable[LabelledSentence], families: Mapping[str, Subject]) -> Iterator[Result]:
    """Read labelled sentences by all layers."""
    readers = {name: make_reader(family) for name, family in families.items()}
    for each in sentences:
        if each.family not in readers:
            continue
        found = [reading for reading in readers[each.family].read(each.text) if reading.layer]
        claim, slots = (found[0].claim, found[0].slots) if len(found) == 1 else (None, {})
        name = _name(families[each.family], claim) if claim else "several" if found else ""
        alike = all(same_value(slots.get(slot, ""), value) for slot, value in each.slots.items())
        layer = found[0].layer if found else ""
        yield Result(SENTENCES, each.family, layer, each.claim or "", name, name == each.claim and alike, each.text)


def read_left_out(family: Family, turns: int = 200) -> Iterator[Result]:
    """Read each phrase, with the values of a claim, by a near layer that does not know this phrase.

    Args:
        family: with claims of random play, and those that err or hint.
        turns: number of turns of that play.
    """
    vocabulary = Vocabulary(family.oracle_class().claims())
    phrases = own_phrases(family.phrasebook, vocabulary.classes)
    others = [(phrase, kind) for name, phrase, kind in known_phrases() if name != family.name]
    near = Near(vocabulary.classes, phrases, load_synonyms(family.name), others)
    samples = _samples(family, vocabulary, turns)
    for name, sources in phrases.items():
        for source in sources if name in samples else ():
            text = Template(source).format(samples[name])
            found = near.read(text, without=source)
            read, layer = (found.claim, "near") if found.claim else ("", "")
            right = found.candidates[:1] == (name,) and _fit(source, samples[name], found.slots)
            yield Result(LEFT_OUT, family.name, layer, name, read, right, text, found.lead, source)


def _fit(source: str, claim: Claim, slots: Mapping[str, str]) -> bool:
    """Whether the values in slots are those that the claim has there."""
    specs = {slot: spec for _, slot, spec, _ in string.Formatter().parse(source) if slot and slot in slots}
    return all(same_value(slots[slot], Template(f"{{{slot}:{spec}}}").format(claim)) for slot, spec in specs.items())


def _samples(family: Family, vocabulary: Vocabulary, turns: int) -> dict[str, Claim]:
    """A claim of each class that occurs, or has no field but the action."""
    options = family.environments[family.showcase[0]]
    turns = max(turns // 20, 1) if family.slow else turns
    pupil = Pupil(lambda: family.make_world(**options), family.make_teacher, max_turns=family.max_turns, turns=turns)
    found: dict[str, Claim] = {}
    for oracle, moment in pupil.judged():
        for claim in oracle.judge(moment):
            for each in (claim, *claim.coarser(moment, oracle.lab), *claim.counterparts(moment, oracle.lab)):
                name = _name(family, type(each), vocabulary)
                if name and each.kind is not None:
                    found.setdefault(name, each)
    if "Better" in vocabulary.classes and "Better" not in found:
        world = family.make_world(**options)
        world.reset(seed=0)
        rng = np.random.default_rng(0)
        actions = [world.legal(world.sample_action(rng)) for _ in range(9)]
        other = next(each for each in actions if each != actions[0])
        found["Better"] = Better(this=actions[0], that=other)
    for name in vocabulary.classes:
        fields = {field: form for field, form in vocabulary.schema_of(name)["properties"].items() if field != "type"}
        if not any(fields.values()) and name not in found:  # no field, or an action of any form, which is not said
            found[name] = vocabulary.claim_of({"type": name, **dict.fromkeys(fields, 0)})
    return found


def _name(subject: Subject, cls: type[Claim], vocabulary: Vocabulary | None = None) -> str:
    vocabulary = vocabulary or Vocabulary(subject.oracle_class().claims())  # type: ignore[attr-defined]
    return next((name for name, each in vocabulary.classes.items() if each is cls), "")


class Counted(NamedTuple):
    """Counts over some sentences."""

    stating: int
    """Those that state a claim."""
    read: int
    right: int

    @property
    def precision(self) -> tuple[float, float]:
        """The share of what was read that was read right, and the lower end of its interval."""
        if not self.read:
            return 1.0, 0.0
        return self.right / self.read, binomtest(self.right, self.read).proportion_ci(LEVEL, "exact").low

    @property
    def recall(self) -> float:
        """The share of the sentences that state a claim that was read right."""
        return self.right / self.stating if self.stating else 0.0


def score(results: Iterable[Result]) -> Counted:
    """The counts of some results."""
    results = list(results)
    read = [each for each in results if each.layer]
    return Counted(sum(bool(each.stated) for each in results), len(read), sum(each.right for each in read))


def table(results: Iterable[Result]) -> Table:
    """Per kind of sentence, family and layer what was read, and what was read right."""
    shown = Table("what", "family", "states a claim", "exact", "near", "right", "precision", "at least", "recall")
    groups: dict[tuple[str, str], list[Result]] = defaultdict(list)
    for each in results:
        groups[each.what, each.family].append(each)
        groups[each.what, "all"].append(each)
    for (what, family), mine in sorted(groups.items(), key=lambda item: (item[0][0], item[0][1] == "all", item[0][1])):
        found, layers = score(mine), Counter(each.layer for each in mine)
        share, low = found.precision
        counts = (found.stating, layers["exact"], layers["near"], found.right)
        shown.add_row(what, family, *map(str, counts), f"{share:.3f}", f"{low:.3f}", f"{found.recall:.3f}")
    return shown


def curve(results: Iterable[Result], precisions: Iterable[float] = (0.995, 0.994, 0.992, 0.99, 0.98, 0.95)) -> Table:
    """What becomes of the phrases that are left out, if the lead that is asked of some is chosen by the others.

    Per precision that is aimed at, a family's phrases are read from the least lead on with which those of the other
    families reach it. Phrases that several families have are in eight parts, each of which is like a family here.
    """
    shown = Table(
        "aim", "lead", "read", "right", "precision", "recall", title="Phrases that are left out, cross-validated"
    )
    left = [each for each in results if each.what == LEFT_OUT]
    having = Counter(phrase for phrase, _ in {(each.phrase, each.family) for each in left})
    parts = np.array([f"{crc32(e.phrase.encode()) % 8}" if having[e.phrase] > 1 else e.family for e in left])
    lead, right = np.array([each.lead for each in left]), np.array([each.right for each in left])
    for aim in precisions:
        asked = {part: _least_lead(lead[parts != part], right[parts != part], aim) for part in {*parts.tolist()}}
        read = lead >= np.array([asked[part] for part in parts])
        share = right[read].mean() if read.any() else 1.0
        leads = f"{min(asked.values()):.3f} to {max(asked.values()):.3f}"
        counts = f"{read.sum()}", f"{right[read].sum()}"
        shown.add_row(f"{aim:g}", leads, *counts, f"{share:.3f}", f"{right[read].sum() / len(left):.3f}")
    return shown


def _least_lead(lead: NDArray[np.float64], right: NDArray[np.bool_], aim: float) -> float:
    """The least lead from which on the share of what is right reaches the aim."""
    order = np.argsort(-lead)
    reached = np.flatnonzero(np.cumsum(right[order]) >= aim * np.arange(1, len(order) + 1))
    return float(lead[order[reached[-1]]]) if len(reached) else math.inf


def confusion(results: Iterable[Result]) -> Table:
    """What was read wrong: what it states, what was read, by which layer, and the sentence."""
    shown = Table("what", "family", "layer", "states", "read as", "sentence", title="Read wrong")
    for each in results:
        if each.layer and not each.right:
            shown.add_row(each.what, each.family, each.layer, each.stated or "nothing", each.read, each.text)
    return shown
