"""A language model learns from what a teacher says: its weights change, and it is tested without the teacher.

    pip install -e ".[trl,local]" -c tests/integrations/trl/constraints.txt
    llf models get smollm2-135m
    python examples/learn_from_words.py --out DIR --signals a b d f --seeds 3

runs for hours, may be killed at any time, and goes on from the last update when it is run again. Several such commands
with other signals share a folder: on two cores two of them, each with OMP_NUM_THREADS=1, do more than one with two
threads. `--table` prints the table from the stored rows alone; `--pilot` measures and says how long all of it takes;
`--device cuda --dtype bfloat16 --model FOLDER` trains a larger model. What follows was written before any run that it
judges.

**Worlds.** Houses of a town (`llf-gridworld-v0`, 6 rooms, no objects) in whose first room the agent sees at least 3
doors and the type of room behind each; the treasure is behind one of them, in a room of the town's type. An episode is
one move. So the right move follows from what is seen, once the law of the town is known, and nobody says it. Success
without a teacher is computed for the very worlds of the test: by chance, through any door, and by the law.

**Signals**, each with the same environment steps and the same optimizer steps: (a) the reward alone, GRPO in groups of
4; (b) SFT on the action that the advice (fp) names, as the schema's claims read it; (c) DPO on pairs of a praised (hp)
and a blamed (hn) answer, in groups of 4; (d) SFT on the model's own answers with the advice in its prompt that were
praised, both with that prompt and without the advice (in the spirit of arXiv 2601.20802 and 2602.02482, with praise as
the filter); (e) as (b), with the teacher `misaligned`, whose words are true of other houses; (f) SFT on random legal
actions: the format alone. Feedback is in the model's prompt in (d) alone. Every run begins with 3 updates of (f), since
SmolLM2-135M answers with no action at all, so that nothing could be rewarded, praised or blamed; they count as updates.
An update has 32 environment steps, and 4 optimizer steps on at most as many examples, of (c) and (d) half as many pairs
and answers.

**Seeds.** Training seed k is town k, its own houses of training, its own adapter and draws: k = 0, 1, 2 (and 3, 4, with
five seeds); laws: cellar, kitchen, library, hall, bathroom. All signals of a seed share town, houses and tests.
Tests are 100 houses from seed 10,000,000 on (the first 50 of them along the way), in the fourth paraphrase of each
claim and the voice `curt`; training has the first three paraphrases and the voice `plain`. Learning rates are the
defaults below, or those that `--tune` chooses in town 6 (attic), which no judged run plays: for each signal the one of
a half, one and two defaults with the greatest success in 50 houses of that town after half of the updates, and the
smaller one of equals. The default of SFT is of two pilots of (b) in that town, one run each: at 1e-3, without acting,
0.32 of 50 houses after 8 updates and 0.84 after 16; at 5e-4 0.43 of 30 houses after 12.

**Size.** 18 updates of 32 environment steps: the same pilots found 0.84 with (b) after 16. On a core of an Intel Xeon,
with one thread, SmolLM2-135M acts at 240 to 340 and learns at 100 to 150 tokens a second; an update of (b) takes 57 s
of a core and 10,300 tokens. A run with its tests is about 25 minutes of a core, so that (a), (b), (d) and (f) with 3
seeds are about 5 hours of a core, or 2.5 hours of two. Signals beyond these four get fewer seeds where time is short,
which the table then says.

**Primary outcome.** The share of test houses in which the treasure is found, without feedback in the prompt, by greedy
answers after the last update.

**Primary comparisons.** For each signal from words with the oracle's words (b, c, d) that was run: it beats (a) and it
beats (f). The unit is the training seed. p of a comparison is that of a one-sided paired t test over seeds; p of a
signal is the greater of its two, and Holm corrects over the signals. A signal from words wins if this p is below 0.05.
With fewer than 3 seeds, of any of the three, nothing is said of it. Any signal that was run is in the table, also where
words lose to rewards.

**Secondary, without a verdict.** (b) minus (e): what the truth of words is worth. The share of test houses in which the
model does what advice in its prompt says, in the held-out voice; and that share in families that it was never trained
in: bandits, movies, ALFWorld, 24 worlds each, before and after. Environment steps, tokens and CPU minutes.

**Noted after the runs.** The houses of the tests have the same seeds in all towns, so that only the names of their
rooms differ: intervals say nothing of other houses. A test with advice does not show by itself that advice is followed,
since who knows the law does the same: hence the column of the houses that were missed alone. Equal environment steps
are not equal houses: groups of 4 see a quarter as many. Differences that are all equal have the p of a sign test.

**Added after those runs, before its own.** (g) SFT on the model's own answers whose reward is no less than the mean of
the update's, if that is above 0 (in the spirit of STaR, arXiv 2203.14465). (a) differs from (b) in its trainer too, (g)
only in what is imitated. Its rate is that of SFT. It is exploratory, as (c) and (e) are with fewer than three seeds:
the table has them, and no verdict.
"""

import argparse
import hashlib
import json
import math
import tempfile
import time
from collections import Counter, defaultdict
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from rich.console import Console
from rich.progress import Progress
from scipy.stats import t as student_t
from scipy.stats import ttest_rel
from word_signals import (
    HELD_OUT,
    HELD_OUT_PHRASE,
    HELD_OUT_VOICE,
    PLACES,
    REFERENCES,
    SIGNALS,
    Rows,
    Step,
    Town,
    examples,
)

from llf_teacher.studies.analysis.statistics import holm
from llf_teacher.studies.store import StoreError
from llf_teacher.studies.store.store_lock import lock_store

if TYPE_CHECKING:
    from word_training import Learner

UPDATES, STEPS_OF_UPDATE, TESTS = 18, 32, 3
"""Updates of a run, environment steps of an update, and number of tests along the way, the last at the end."""
START, FORMAT = 3, "f"
"""Updates at the beginning of each run that teach the format alone, and the signal that they have."""
WORLDS, ELSEWHERE = 100, 24
"""Worlds of the last test in the trained family, twice as many as of those along the way, and in each other one."""
TUNING_TOWN, TUNING_WORLDS, FACTORS = 6, 50, (0.5, 1.0, 2.0)
FAMILY = "gridworld"
WORDS = "bcd"
"""Signals from the oracle's words, in the primary comparisons."""
BASE = "base"
"""The run of the model before training."""
LEVEL, LEAST, TINY = 0.05, 3, 1e-9
"""Level of the tests, seeds that a comparison needs, and what counts as no difference."""
RATES_FILE = "rates.json"
SETTINGS = "settings"
TRANSCRIPTS = 10
PACKED = ("kind", "update", "seed", "answer", "success", "failure", "follows", "test", "family", "last")
"""Fields of a test in a file of rows."""


def number(*parts: Any) -> int:
    """A seed for torch from some values, the same in every process."""
    return int.from_bytes(hashlib.sha256(repr(parts).encode()).digest()[:4]) % 2**31


class Run:
    """A signal with a training seed: its folder, rows and checkpoints."""

    advised = True
    """Whether the last test is also played with advice in the prompt."""
    tests_from = HELD_OUT
    """First seed of the worlds of its tests."""

    def __init__(self, out: Path, signal: str, seed: int, settings: Mapping[str, Any], town: int | None = None) -> None:
        self.signal, self.seed, self.settings = signal, seed, settings
        self.folder = out / f"{signal}-{seed}"
        self.rows = Rows(self.folder / "rows.jsonl")
        self.town = Town(settings["family"], seed if town is None else town)

    def check(self) -> None:
        """Write down the settings, or compare them with those of the run so far.

        Raises:
            ValueError: they differ.
        """
        path = self.folder / "settings.json"
        if not path.exists():
            self.folder.mkdir(parents=True, exist_ok=True)
            path.write_text(json.dumps(self.settings, indent=1), "utf-8")
        was = json.loads(path.read_text("utf-8"))
        for name in {*was, *self.settings}:
            if was.get(name) != self.settings.get(name):
                raise ValueError(
                    f"{self.folder} was begun with {name}={was.get(name)!r}, got {self.settings.get(name)!r}; "
                    "give the same settings or another --out"
                )

    @property
    def done(self) -> bool:
        """Whether all updates and tests are stored."""
        return finished(self.rows.read())

    def go(self, learner: "Learner", step: Callable[[int, str], object] = lambda *_: None) -> None:
        """Begin or continue, up to the last test.

        Args:
            learner: the model.
            step: is called after each update, with their number so far and a line about the last.
        """
        self.check()
        learner.tokens = 0
        learner.begin(number("adapter", self.seed))
        progress = learner.load(self.folder)
        self.rows.cut(progress["end"])
        if self.signal == BASE:
            self._test(learner, 0)
        for update in range(progress["update"], 0 if self.signal == BASE else self.settings["updates"]):
            said = self._update(learner, update)
            if self._tested(update + 1):
                self._test(learner, update + 1)
            learner.save(self.folder, update + 1, self.rows.end)
            step(update + 1, said)
        self.rows.add([{"kind": "end"}])

    def _tested(self, update: int) -> bool:
        every = max(1, self.settings["updates"] // TESTS)
        return bool(update == self.settings["updates"] or update % every == 0)

    def _update(self, learner: "Learner", update: int) -> str:
        """Act and learn; returns a line about it."""
        learner.seed(number("update", self.seed, update))
        began, cpu, tokens = time.perf_counter(), time.process_time(), learner.tokens
        rows, learned = self._learn(learner, update)
        found = np.mean([row["success"] for row in rows])
        last = {
            "kind": "update",
            "update": update,
            "steps": len(rows),
            "examples": learned.examples,
            "loss": learned.loss,
            "tokens": learner.tokens - tokens,
            "seconds": round(time.perf_counter() - began, 2),
            "cpu": round(time.process_time() - cpu, 2),
        }
        self.rows.add([*rows, last])
        return f"found {found:.2f}, loss {'-' if learned.loss is None else f'{learned.loss:.3f}'}"

    def _learn(self, learner: "Learner", update: int) -> tuple[list[dict[str, Any]], Any]:
        """The rows of an update's environment steps, and what the learner says of it."""
        letter = FORMAT if update < self.settings["format"] else self.signal
        signal = SIGNALS[letter]
        learner.set_rate(self.settings["rates"][letter])
        count = self.settings["steps"] // signal.group
        # The signals without groups see the same worlds as those with groups, and more of them.
        seeds = self.town.seeds(self.first(update), count)
        longest = self.town.place.longest
        steps: list[Step]
        if signal.trainer == "grpo":
            steps, learned = self._rewarded(learner, seeds, update)
        else:
            steps = self.town.play(
                lambda conversations: learner.answer(conversations, longest, sample=True),
                [seed for seed in seeds for _ in range(signal.group)],
                hears=signal.hears,
                teacher=signal.teacher,
            )
            rng = np.random.default_rng([self.seed, update])
            made = examples(letter, self.town, steps, rng)
            learned = learner.learn(signal.trainer, made, number("learn", self.seed, update))
        return [row_of(step, "step", update) for step in steps], learned

    def first(self, update: int) -> int:
        """Where the worlds of an update begin, so far apart that no update repeats one."""
        return int((self.settings["updates"] * self.seed + update) * 40 * self.settings["steps"])

    def _rewarded(self, learner: "Learner", seeds: Sequence[int], update: int) -> tuple[list[Step], Any]:
        """Answers by TRL's trainer, which asks for their rewards."""
        looks = self.town.judge(seeds, [""] * len(seeds))  # for the prompts alone
        prompts = [{"prompt": look.prompt, "world": look.seed} for look in looks]
        steps: list[Step] = []

        def reward(completions: list[list[dict[str, str]]], world: list[int], **_: Any) -> list[float]:
            steps.extend(played := self.town.judge(world, [completion[0]["content"] for completion in completions]))
            return [step.reward for step in played]

        group = SIGNALS[self.signal].group
        learned = learner.learn_by_reward(
            prompts, reward, group, self.town.place.longest, number("learn", self.seed, update)
        )
        return steps, learned

    def _test(self, learner: "Learner", update: int) -> None:
        """Greedy answers in the worlds of the test; with advice and elsewhere only before training and at its end."""
        last = self.signal == BASE or update == self.settings["updates"]
        count = self.settings["worlds"]
        self._tests(learner, update, last, "alone", self.town, count if last else -(-count // 2))
        if last and self.advised:
            self._tests(learner, update, last, "advised", self.town, self.settings["worlds"])
            for name in PLACES:
                if name != self.town.name and self.settings["elsewhere"]:
                    self._tests(
                        learner, update, last, "advised", Town(name, self.town.number), self.settings["elsewhere"]
                    )

    def _tests(self, learner: "Learner", update: int, last: bool, test: str, town: Town, count: int) -> None:
        steps = town.play(
            lambda conversations: learner.answer(conversations, town.place.longest, sample=False),
            town.seeds(self.tests_from, count),
            hears=True,
            feedback="n" if test == "alone" else "fp",
            voice=HELD_OUT_VOICE,
            phrases=(HELD_OUT_PHRASE,),
        )
        rows = []
        for place, step in enumerate(steps):
            row = row_of(step, "test", update) | {"test": test, "family": town.name, "last": last}
            if test == "advised":
                row["follows"] = town.follows(step)
            if place < TRANSCRIPTS:
                row["prompt"] = [message["content"] for message in step.heard]
            rows.append(row)
        self.rows.add(rows)


def row_of(step: Step, kind: str, update: int) -> dict[str, Any]:
    """A step as a stored row, without its prompts."""
    values = step._asdict()
    return {"kind": kind, "update": update} | {k: v for k, v in values.items() if k not in ("prompt", "heard")}


def finished(rows: Sequence[Mapping[str, Any]]) -> bool:
    """Whether rows are those of a run that has ended."""
    return bool(rows) and rows[-1]["kind"] == "end"


def results(out: Path, signals: Sequence[str] = (BASE, *SIGNALS)) -> dict[str, dict[int, list[dict[str, Any]]]]:
    """The checked rows of the finished runs, by signal and training seed; the first row of a run has its settings.

    Args:
        out: the folder of the runs, or a file of `pack`.
        signals: which ones.

    Raises:
        ValueError: rows are missing, doubled or no rows of such runs; runs have other settings or worlds than others.
    """
    found: dict[str, dict[int, list[dict[str, Any]]]] = defaultdict(dict)
    first: dict[str, Any] = {}
    for name, rows in (_unpacked(out) if out.is_file() else _of_folders(out)).items():
        signal, _, seed = name.rpartition("-")
        if signal in signals and seed.isdecimal():
            try:
                fault = _fault(signal, rows) or _difference(first, signal, seed, rows)
            except KeyError as error:
                fault = f"must have rows of these runs, got one without {error}"
            except TypeError as error:
                fault = f"must have rows of these runs, got a value of a wrong type: {error}"
            if fault:
                raise ValueError(f"{name} in {out} {fault}; run it again, or write the file again with --rows")
            found[signal][int(seed)] = rows
    return dict(found)


def _of_folders(out: Path) -> dict[str, list[dict[str, Any]]]:
    runs = {}
    for folder in sorted(out.glob("*-*")):
        rows = Rows(folder / "rows.jsonl").read()
        if finished(rows):
            settings = json.loads((folder / "settings.json").read_text("utf-8"))
            runs[folder.name] = [{"kind": SETTINGS} | settings, *_without_steps(rows)]
    return runs


def _without_steps(rows: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """Rows of tests and updates; an update says in how many of its worlds the answers were not equally good."""
    goods: dict[tuple[int, int], set[bool]] = defaultdict(set)
    for row in rows:
        if row["kind"] == "step":
            goods[row["update"], row["seed"]].add(row["success"])
    mixed = Counter(update for (update, _), good in goods.items() if len(good) > 1)
    return [
        {**row, "mixed": mixed[row["update"]]} if row["kind"] == "update" else row
        for row in rows
        if row["kind"] != "step"
    ]


def _unpacked(file: Path) -> dict[str, list[dict[str, Any]]]:
    runs: dict[str, list[dict[str, Any]]] = defaultdict(list)
    for row in Rows(file).read():
        if not isinstance(row, dict) or "run" not in row:
            raise ValueError(f"{file} must have rows that --rows wrote, each with the name of its run, got {row!s:.60}")
        runs[row.pop("run")].append(row)
    return runs


def _fault(signal: str, rows: Sequence[Mapping[str, Any]]) -> str:
    """What is wrong with the rows of a run; empty if nothing is."""
    settings, *_, end = rows
    if settings["kind"] != SETTINGS or end["kind"] != "end":
        return "must begin with its settings and have an end"
    updates = [row["update"] for row in rows if row["kind"] == "update"]
    if updates != [*range(0 if signal == BASE else settings["updates"])]:
        return f"must have updates 0 to {settings['updates'] - 1}, each once, got {updates}"
    tests = [row for row in rows if row["kind"] == "test"]
    if len({(row["update"], row["test"], row["family"], row["seed"]) for row in tests}) < len(tests):
        return "must have each test once, got one twice"
    if (count := len(alone_of(rows))) != settings["worlds"]:
        return f"must have {settings['worlds']} last tests, got {count}"
    if any(type(row["success"]) is not bool for row in tests):
        return "must say of each test whether it succeeded, true or false"
    along = Counter(row["update"] for row in tests if not row["last"])
    if any(count != -(-settings["worlds"] // 2) for count in along.values()):
        return f"must have half as many tests along the way as at the end, got {[*along.values()]}"
    numbers = [row[name] for row in rows if row["kind"] == "update" for name in ("steps", "tokens", "cpu")]
    if not all(map(math.isfinite, numbers)):
        return "must have finite steps, tokens and CPU seconds"
    return ""


def _difference(first: dict[str, Any], signal: str, seed: str, rows: Sequence[Mapping[str, Any]]) -> str:
    """How a run differs from the first, and from the first of its training seed; empty if it does not."""
    compared: dict[str, Any] = {
        f"{SETTINGS} but for learning rates": {k: v for k, v in rows[0].items() if k != "rates"},
        f"worlds of the tests of training seed {seed}": sorted(row["seed"] for row in alone_of(rows)),
    }
    for what, value in compared.items():
        if first.setdefault(what, value) != value:
            return f"must have the {what} of the other runs, as in {signal}"
    return ""


def settings_of(out: Path) -> dict[str, Any]:
    """The settings of the first run in a folder or in a file of `pack`."""
    runs = _unpacked(out) if out.is_file() else _of_folders(out)
    settings: dict[str, Any] = next(iter(runs.values()))[0]
    return settings


def pack(out: Path, file: Path, signals: Sequence[str] = (BASE, *SIGNALS)) -> None:
    """Write what tables, curves and transcripts are made of into one file: the rows of finished runs without steps."""
    runs = results(out, signals)
    lines = []
    for name, seeds in runs.items():
        for seed, rows in seeds.items():
            for row in rows:
                kept = {key: row[key] for key in (PACKED if row["kind"] == "test" else row) if key in row}
                if "prompt" in row and seed == min(seeds) and row["test"] == "alone":
                    kept["prompt"] = row["prompt"][-1:]
                lines.append(json.dumps({"run": f"{name}-{seed}"} | kept, ensure_ascii=False) + "\n")
    file.write_text("".join(lines), "utf-8")


def share(rows: Sequence[Mapping[str, Any]], field: str, **where: Any) -> float | None:
    """The mean of a field over the rows of tests with these values; None without a row."""
    values = [row[field] for row in rows if row["kind"] == "test" and all(row[k] == v for k, v in where.items())]
    return float(np.mean(values)) if values else None


def alone_of(rows: Sequence[Mapping[str, Any]]) -> list[Mapping[str, Any]]:
    """The last tests without feedback of a run."""
    return [row for row in rows if row["kind"] == "test" and row["last"] and row["test"] == "alone"]


def alone(rows: Sequence[Mapping[str, Any]]) -> float:
    """The primary outcome of a run."""
    return float(np.mean([row["success"] for row in alone_of(rows)]))


def table(out: Path) -> list[str]:
    """The table and the verdicts, from the stored rows."""
    runs = results(out)
    if not runs:
        raise ValueError(f"{out} must have finished runs, got none; run it without --table first")
    family = settings_of(out)["family"]
    elsewhere = [name for name in PLACES if name != family]
    names = ["signal", "seeds", "found alone", "commonest answer", "found when advised", "of those missed alone"]
    names += [f"follows advice in {name}" for name in elsewhere]
    names += ["groups that differ", "no action", "steps", "tokens", "CPU min"]
    lines = [" | ".join(names), " | ".join("---" for _ in names)]
    for letter in (BASE, *SIGNALS):
        if letter in runs:
            lines.append(" | ".join(_cells(letter, runs[letter], family, elsewhere)))
    lines += [*references(runs, family), "", *verdicts(runs)]
    return lines


def _cells(letter: str, runs: Mapping[int, list[dict[str, Any]]], family: str, elsewhere: Sequence[str]) -> list[str]:
    def mean(field: str, **where: Any) -> str:
        values = [share(rows, field, last=True, **where) for rows in runs.values()]
        return interval_of([value for value in values if value is not None])

    updates = [row for rows in runs.values() for row in rows if row["kind"] == "update"]
    last = [row for rows in runs.values() for row in alone_of(rows)]
    commonest = [Counter(row["answer"] for row in alone_of(rows)).most_common(1)[0][1] for rows in runs.values()]
    turned = [each for rows in runs.values() for each in turned_by_advice(rows, family)]
    title = "before training" if letter == BASE else f"({letter}) {SIGNALS[letter].title}"
    return [
        title,
        f"{len(runs)}",
        mean("success", test="alone"),
        f"{sum(commonest) / len(last):.0%}",
        mean("success", test="advised", family=family),
        f"{np.mean(turned):.0%} of {len(turned)}" if turned else "-",
        *(mean("follows", test="advised", family=name) for name in elsewhere),
        _mixed(letter, updates, [rows[0] for rows in runs.values()]),
        f"{np.mean([row['failure'] is not None for row in last]):.0%}",
        *(f"{sum(row[name] for row in updates) / len(runs):,.0f}" for name in ("steps", "tokens")),
        f"{sum(row['cpu'] for row in updates) / 60 / len(runs):,.1f}",
    ]


def _mixed(letter: str, updates: Sequence[Mapping[str, Any]], settings: Sequence[Mapping[str, Any]]) -> str:
    """Of the groups of answers to one prompt, the share in which not all were equally good: others teach nothing."""
    if letter not in SIGNALS or SIGNALS[letter].group == 1:
        return "-"
    own = [row for row in updates if row["update"] >= settings[0]["format"]]
    groups = sum(row["steps"] for row in own) // SIGNALS[letter].group
    return f"{sum(row['mixed'] for row in own) / groups:.0%} of {groups}" if groups else "-"


def turned_by_advice(rows: Sequence[Mapping[str, Any]], family: str) -> list[bool]:
    """Of each world of the last tests that was missed without feedback, whether advice in the prompt led to success."""
    missed = {row["seed"] for row in alone_of(rows) if not row["success"]}
    advised = [row for row in rows if row["kind"] == "test" and row["last"] and row["test"] == "advised"]
    return [row["success"] for row in advised if row["family"] == family and row["seed"] in missed]


def interval_of(values: Sequence[float]) -> str:
    """The mean over training seeds with its interval, where there are enough."""
    if not values:
        return "-"
    mean, low, high = interval(values)
    return f"{mean:.2f}" if len(values) < 2 else f"{mean:.2f} ({low:.2f} to {high:.2f})"


REFERENCE_TITLES = dict(
    zip(REFERENCES, ("any action", "any action that could be right", "by the law: best without a teacher"), strict=True)
)


def references(runs: Mapping[str, Mapping[int, list[dict[str, Any]]]], family: str) -> list[str]:
    """Success without a teacher in the very worlds of the tests, as further lines of the table."""
    seeds = len({seed for each in runs.values() for seed in each})
    lines = [f"{title} | {seeds} | {share:.2f}" for title, share in levels(runs, family).items()]
    return [*lines, f"oracle | {seeds} | 1.00"]


def levels(runs: Mapping[str, Mapping[int, list[dict[str, Any]]]], family: str) -> dict[str, float]:
    """The mean success without a teacher in the very worlds of the tests, by title."""
    found = []
    for seed, rows in sorted({seed: rows for each in runs.values() for seed, rows in each.items()}.items()):
        found.append(Town(family, seed).references([row["seed"] for row in alone_of(rows)]))
    return {title: float(np.mean([each[name] for each in found])) for name, title in REFERENCE_TITLES.items()}


def verdicts(runs: Mapping[str, Mapping[int, list[dict[str, Any]]]]) -> list[str]:
    """The primary comparisons, by the rule above."""
    lines, judged = [], {}
    for letter in [each for each in WORDS if each in runs]:
        p_values = []
        for other in "af":
            seeds = sorted({*runs[letter]} & {*runs.get(other, {})})
            if len(seeds) < LEAST:
                lines.append(f"({letter}) against ({other}): not judged, {len(seeds)} common seeds of at least {LEAST}")
                continue
            ours, theirs = ([alone(runs[each][seed]) for seed in seeds] for each in (letter, other))
            p_values.append(p_greater(ours, theirs))
            gain = np.mean(np.subtract(ours, theirs))
            lines.append(f"({letter}) against ({other}): {gain:+.2f} over {len(seeds)} seeds, p = {p_values[-1]:.3f}")
        if len(p_values) == len("af"):
            judged[letter] = max(p_values)
    corrected = dict(zip(judged, holm([*judged.values()]), strict=True))
    for letter, p in corrected.items():
        won = "beats (a) and (f)" if p < LEVEL else "does not beat both (a) and (f)"
        lines.append(f"({letter}) {SIGNALS[letter].title}: {won}, p = {p:.3f} after Holm")
    if not judged:
        lines.append("No primary comparison is judged yet.")
    elif min(corrected.values()) >= LEVEL:
        lines.append("No signal from words beats both (a) and (f).")
    return lines


def p_greater(ours: Sequence[float], theirs: Sequence[float]) -> float:
    """P of a one-sided paired t test; of a sign test where all differences are equal."""
    differences = np.subtract(ours, theirs)
    if np.ptp(differences) < TINY:
        return float(0.5 ** len(differences)) if differences[0] > TINY else 1.0
    return float(ttest_rel(ours, theirs, alternative="greater").pvalue)


def draw(out: Path, plot: Path) -> None:
    """The share of test houses in which the treasure is found without feedback, by updates, with 95 % intervals."""
    settings = settings_of(out)
    titles, runs = {letter: f"({letter}) {signal.title}" for letter, signal in SIGNALS.items()}, results(out)
    along = f"updates, each of {settings['steps']} environment steps"
    draw_curves(runs, titles, levels(runs, settings["family"]), along, plot)


def draw_curves(
    runs: Mapping[str, Mapping[int, list[dict[str, Any]]]],
    titles: Mapping[str, str],
    without: Mapping[str, float],
    along: str,
    plot: Path,
) -> None:
    """Draw the curves of runs by name and training seed.

    Args:
        runs: as of `results`.
        titles: of the names, in the order of the legend.
        without: success without a teacher, by title; but for `any action`, a line each.
        along: what the updates are.
        plot: the file.
    """
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(figsize=(7, 4), layout="constrained")
    updates: list[int] = []
    shown = [each for each in titles if each in runs]
    for number, name in enumerate(shown):
        curves = []
        for seed, rows in runs[name].items():
            before = {0: share(runs[BASE][seed], "success", test="alone")} if seed in runs.get(BASE, {}) else {}
            tested = {row["update"] for row in rows if row["kind"] == "test"}
            curves.append(before | {each: share(rows, "success", test="alone", update=each) for each in tested})
        updates = sorted(set.intersection(*({*curve} for curve in curves)))
        bands = [interval([curve[each] for curve in curves]) for each in updates]
        means, lows, highs = np.array(bands).T
        places = np.array(updates) + 0.25 * (number - (len(shown) - 1) / 2)  # beside each other
        axes.errorbar(places, means, (means - lows, highs - means), marker=".", capsize=2, label=titles[name])
    for (title, height), style in zip([*without.items()][1:], (":", "--"), strict=True):
        axes.axhline(height, color="grey", linestyle=style, linewidth=1, label=title)
    axes.set(xlabel=along, ylabel="found without feedback", ylim=(-0.02, 1.02), xticks=updates)
    figure.legend(loc="outside upper left", ncols=2, frameon=False)
    figure.savefig(plot, dpi=110)
    plt.close(figure)


def interval(values: Sequence[float]) -> tuple[float, float, float]:
    """The mean over training seeds with its 95 % interval by t, within 0 to 1; of one seed the value thrice."""
    mean = float(np.mean(values))
    if len(values) < 2:
        return mean, mean, mean
    half = float(student_t.ppf(0.975, len(values) - 1) * np.std(values, ddof=1) / len(values) ** 0.5)
    return mean, max(0.0, mean - half), min(1.0, mean + half)


def transcripts(out: Path) -> list[str]:
    """The first tests without feedback of each signal's first seed, before training and after it."""
    runs, lines = results(out), []
    for letter in [each for each in SIGNALS if each in runs]:
        seed = min(runs[letter])
        tests = [alone_of(runs.get(name, {}).get(seed, [])) for name in (BASE, letter)]
        lines.append(f"## ({letter}) {SIGNALS[letter].title}, seed {seed}")
        for before, after in list(zip(*tests, strict=False))[:TRANSCRIPTS]:
            lines += ["", after["prompt"][-1]]
            for when, row in (("before", before), ("after", after)):
                lines.append(
                    f"{when}: {row['answer']!r}, {'found' if row['success'] else row['failure'] or 'not found'}"
                )
    return lines


def pilot(
    learner: "Learner",
    out: Path,
    letters: Sequence[str],
    seeds: int,
    settings: Mapping[str, Any],
    kind: type[Run] = Run,
) -> list[str]:
    """Measure an update of each signal and a small test, and say how long all runs take."""
    few, ends = 5, 1 + kind.advised
    total, lines = 0.0, []
    tests = ((min(TESTS, settings["updates"]) - 1) / 2 + ends) * settings["worlds"] / few
    measured = {**settings, "updates": 2, "format": 1, "worlds": few, "elsewhere": 0}
    for letter in letters:
        with tempfile.TemporaryDirectory(dir=out) as folder:
            run = kind(Path(folder), letter, 0, measured)
            began = time.perf_counter()
            run.go(learner)
            whole = time.perf_counter() - began
            start, row = [row for row in run.rows.read() if row["kind"] == "update"]
        testing = (whole - start["seconds"] - row["seconds"]) / (1 + ends)  # of `few` worlds
        seconds = settings["updates"] * row["seconds"] + tests * testing
        total += seconds * seeds
        speed = row["tokens"] / row["seconds"]
        lines.append(
            f"({letter}) {row['seconds']:.1f} s an update ({row['cpu']:.1f} s of CPU), {row['tokens']} tokens, "
            f"{speed:.0f} tokens a second: {seconds / 60:.0f} minutes a run"
        )
    return [*lines, f"{len(letters) * seeds} runs: about {total / 3600:.1f} hours, tests in other families apart"]


def tune(learner: "Learner", out: Path, letters: Sequence[str], settings: Mapping[str, Any], progress: Any) -> None:
    """Choose the learning rate of each signal in a town that no judged run plays, and store it."""
    chosen = {}
    for letter in letters:
        tried = {}
        for factor in FACTORS:
            rate = settings["rates"][letter] * factor
            short = {
                "updates": max(1, settings["updates"] // 2),
                "worlds": TUNING_WORLDS,
                "elsewhere": 0,
                "rates": {**settings["rates"], letter: rate},
            }
            run = Run(out / "tuning" / f"{factor:g}", letter, TUNING_TOWN, {**settings, **short})
            if not run.done:
                run.go(learner, progress(f"tuning ({letter}) at {rate:g}", short["updates"]))
            tried[rate] = alone(run.rows.read())
        chosen[letter] = max(sorted(tried), key=lambda rate: tried[rate])
    (out / RATES_FILE).write_text(json.dumps(chosen, indent=1), "utf-8")


def main(arguments: Sequence[str] | None = None) -> None:
    """Run what is asked for, and print the table."""
    options = _parser().parse_args(arguments)
    console = Console(soft_wrap=True, highlight=False, markup=False)
    try:
        if not (options.table or options.transcripts):
            _work(options, console)
        for line in (
            transcripts(options.out)
            if options.transcripts
            else ()
            if options.pilot or options.tune
            else table(options.out)
        ):
            console.print(line)
        if options.rows:
            if not options.out.is_dir():
                raise ValueError(f"--rows needs a folder of runs as --out, got {options.out}")
            pack(options.out, options.rows)
        drawn = options.out.is_dir() and not (options.pilot or options.tune or options.transcripts)
        if plot := options.plot or (options.out / "curve.png" if drawn else None):
            draw(options.out, plot)
    except (ValueError, FloatingPointError, OSError) as error:
        raise SystemExit(f"{error}") from None
    except KeyboardInterrupt:
        raise SystemExit("interrupted; the same command goes on from the last update") from None


def _work(options: argparse.Namespace, console: Console) -> None:
    from word_training import RATES, Learner

    letters = [letter for letter in SIGNALS if letter in options.signals]
    options.out.mkdir(parents=True, exist_ok=True)
    rates = {letter: RATES[SIGNALS[letter].trainer] for letter in SIGNALS}
    if (options.out / RATES_FILE).exists() and not options.tune:
        rates |= json.loads((options.out / RATES_FILE).read_text("utf-8"))
    names = ("model", "dtype", "family", "updates", "format", "steps", "worlds", "elsewhere")
    settings = {name: getattr(options, name) for name in names} | {"rates": rates}
    learner = Learner(options.model, options.device, options.dtype, options.max_prompt)
    with Progress(console=console, disable=not console.is_terminal) as bars:
        if options.tune:
            tune(learner, options.out, letters, settings, partial(follow, bars))
            console.print(f"chosen: {(options.out / RATES_FILE).read_text('utf-8')}")
            return
        estimate = options.out / "pilot.txt"
        if options.pilot or not estimate.exists():
            estimate.write_text("\n".join(pilot(learner, options.out, letters, options.seeds, settings)), "utf-8")
        console.print(estimate.read_text("utf-8"))
        if options.pilot:
            return
        for seed in range(options.seeds):  # seed by seed, so that an early end has all signals of some seeds
            for letter in (BASE, *letters):
                own = {"rates": {name: rate for name, rate in rates.items() if name in (FORMAT, letter)}}
                play(Run(options.out, letter, seed, settings | own), learner, f"({letter}) seed {seed}", bars)


def play(run: Run, learner: "Learner", title: str, bars: Progress) -> None:
    """Play a run unless it is done or another command plays it."""
    try:
        with lock_store(run.folder):
            if not run.done:
                run.go(learner, follow(bars, title, run.settings["updates"]))
    except StoreError:
        bars.console.print(f"{title} is being run by another command")


def follow(bars: Progress, title: str, updates: int) -> Callable[[int, str], None]:
    """What shows the progress of a run: it gets the number of updates so far, and a line about the last."""
    bar = bars.add_task(title, total=updates)

    def step(update: int, said: str) -> None:
        bars.update(bar, completed=update, description=f"{title}: {said}")
        if not bars.console.is_terminal:
            bars.console.print(f"{title}, update {update} of {updates}: {said}")

    return step


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument(
        "--out", type=Path, required=True, help="folder of the rows, checkpoints and curve, or a file of --rows"
    )
    parser.add_argument(
        "--rows", type=Path, metavar="FILE", help="write the rows that the table is made of into a file"
    )
    parser.add_argument("--plot", type=Path, metavar="FILE", help="where to draw the curve; default: OUT/curve.png")
    parser.add_argument(
        "--signals", nargs="+", default=["a", "b", "d", "f"], choices=[*SIGNALS], help="default: a b d f"
    )
    parser.add_argument("--seeds", type=int, default=3, help="number of training seeds; default: 3")
    parser.add_argument("--updates", type=int, default=UPDATES, help=f"updates of a run; default: {UPDATES}")
    parser.add_argument("--format", type=int, default=START, help=f"updates of a run's start; default: {START}")
    parser.add_argument("--steps", type=int, default=STEPS_OF_UPDATE, help="environment steps of an update")
    parser.add_argument("--worlds", type=int, default=WORLDS, help="worlds of a test")
    parser.add_argument("--elsewhere", type=int, default=ELSEWHERE, help="worlds of a test in each other family")
    parser.add_argument("--family", default=FAMILY, choices=["gridworld", "bandits"], help="where the model is trained")
    add_model(parser)
    what = parser.add_mutually_exclusive_group()
    what.add_argument("--table", action="store_true", help="print the table of the stored rows, and draw the curve")
    what.add_argument("--transcripts", action="store_true", help="print tests before and after training")
    what.add_argument("--pilot", action="store_true", help="measure, and say how long all runs take")
    what.add_argument("--tune", action="store_true", help="choose learning rates in another town")
    return parser


def add_model(parser: argparse.ArgumentParser) -> None:
    """Add the options of the model."""
    parser.add_argument(
        "--model", default="smollm2-135m", help="of `llf models`, a GGUF file, a folder, or a hub's name"
    )
    parser.add_argument("--device", default="cpu", help="as in torch: cpu, cuda")
    parser.add_argument("--dtype", default="float32", choices=["float32", "bfloat16"], help="of the frozen weights")
    parser.add_argument("--max-prompt", type=int, default=2048, help="most tokens of a prompt")


if __name__ == "__main__":
    main()
