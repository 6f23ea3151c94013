"""Which teacher teaches a language model most with as many words? A single study, with its rules before the data.

    pip install -e ".[trl,local]" -c tests/integrations/trl/constraints.txt
    llf models get smollm2-135m
    python examples/teachers_for_a_model.py --out DIR --stage 1
    python examples/teachers_for_a_model.py --out DIR --stage 2

Each stage runs for hours, may be killed at any time, and goes on from the last update when it is run again; several
commands share a folder. `--table` prints the table from the stored rows alone, `--plot FILE` draws the curves of stage
2, if it was begun, `--pilot` says how long a stage takes, and `--words-alone` prints what the words are worth without
any model. What follows was written before any training that it judges.

**Worlds and tests** are those of `learn_from_words.py`: one move in a house of a town, held-out houses, phrasing and
voice, no feedback in the prompt. The tests of training seed k have houses from seed 10,000,000 + 1,000,000 k on.

**From words to targets.** In each house of training a teacher may speak before the move. A reader, the built-in student
`reasoner(worlds=256, forget=False)`, has the plan of the house, hears the claims of the sentences and never sees the
truth. Its move is the target that the model imitates (SFT), from a prompt without the plan and without the sentence. A
rule of the town that was said once bears on every later house. Where nothing is said, and no rule was said before, the
move is no target.

**Teachers.** Each may say 200 words over the whole training, counted in its sentences. The first sentence that does not
fit into the rest, and all after it, are not said.

- `early`: the personality `early`, advice (fp) in each house from the first on.
- `mistake_correcting`: the same advice, only where the model in training would have been wrong: it announces its greedy
  answer first, as in Torrey & Taylor 2013. Where the answer is right nothing is said, and there is no target.
- `ruler`: the personality `ruler`. In a house of one move only rules of the town carry over, so it is asked for its
  next sentence until that is a rule of the town that it has not said in an earlier house.
- `half_bit`, `one_bit`, `two_bits`: the personality `informative` with so many bits. Its measure of what the student
  knows contains the rules of the town that were said in earlier houses.

`unlimited` is a reference: `early` without a budget, which is signal (b) of `learn_from_words.py` with replay.

**Training.** 15 updates: 3 of the format (random legal actions) without a teacher, then 12. Each of these visits 32 new
houses, and takes 4 optimizer steps on 32 targets, drawn from all targets so far, without repetition if there are as
many. All teachers of a seed have the same town, houses, draws of the reader, adapter and tests, and equally many
environment steps, which are the reader's moves; an announced answer is no step. The learning rate is that of SFT in
`learn_from_words.py`.

**Why 200 words and 15 updates.** By `--words-alone`, which has no model, in towns 0 and 1: 200 words are advice in 34
houses, all of it right; or 40 of them are the law of the town, which makes a target of each of the 384 houses, 79 % of
them right; `two_bits` also spends the rest, 83 %. (The law alone would be 86 %: the reader does not know that only
houses with the treasure behind a door of the first room take part.) So the question is of few targets that are right
against many that are often right. 100 words are advice in 17 houses, fewer than an update has targets, and 400 in 70;
rules gain little by more words. In pilots of (b) in another town success was 0.32 after 8 updates and 0.84 after 16: 12
updates with targets lie within this rise, and fewer might teach nothing.

**Stage 1, exploratory.** All six teachers and the reference, training seeds 0 and 1.

**Stage 2.** The three teachers with the greatest mean outcome in stage 1 (among equals those that said fewer words,
then in the order above), training seeds 2, 3, 4, 5 and 9: their towns have five laws, and none is the law of town 6,
in which learning rates are tuned. If neither `early` nor `mistake_correcting` is among the three, the better one of
both in stage 1 is run as a fourth: without it the primary hypothesis could not be judged just where it holds.

**Outcome.** The share of test houses in which the treasure is found by greedy answers after the last update.

**The three best against each other.** Two-sided paired t tests over the five seeds of stage 2 alone, corrected by Holm
over the three pairs; a teacher teaches more than another if the difference is positive and p is below 0.05. They are
judged once all three teachers have all five seeds.

**Primary hypothesis.** Rules that last teach more with as many words than advice. The better of `ruler` and `two_bits`
in stage 1 plays against the better of `early` and `mistake_correcting` in stage 1: one two-sided paired t test over the
five seeds of stage 2, at 0.05, without correction. The hypothesis holds if the difference is positive and p below 0.05;
the opposite holds if it is negative and p below 0.05; otherwise nothing is shown. It is not judged if neither `ruler`
nor `two_bits` is among the three best, or before both teachers have all five seeds.

**Second hypothesis.** `mistake_correcting` teaches more than `early`. It is judged in the same way if both are among
the three best, and otherwise not.

The table has all runs of both stages, with the words that were said, the houses in which they were said, the share of
targets that are right, tokens and CPU minutes; success by chance, through any door, by the law, and of the oracle, are
computed from the test houses, of stage 2 if it was begun.
"""

import argparse
import math
from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from itertools import combinations
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from learn_from_words import (
    FAMILY,
    FORMAT,
    LEVEL,
    START,
    STEPS_OF_UPDATE,
    WORLDS,
    Run,
    add_model,
    alone,
    draw_curves,
    interval_of,
    levels,
    number,
    p_greater,
    pack,
    pilot,
    play,
    references,
    results,
)
from rich.console import Console
from rich.progress import Progress
from word_signals import HELD_OUT, Town, imitated, response

from llf_teacher import make
from llf_teacher.studies.analysis.statistics import holm
from pz_envs.text.answer_formats import worded
from teachers.atoms import Atom, Claim, Scope, Utterance
from teachers.oracle import POSTERIOR
from teachers.personality import Claims, Personality, View, parse_personality, personality

if TYPE_CHECKING:
    from word_training import Learner

WORDS, UPDATES = 200, 15
"""Words of a teacher over the whole training, and updates of a run."""
READER = "reasoner(worlds=256, forget=False)"
STAGES = {1: (0, 1), 2: (2, 3, 4, 5, 9)}
"""The training seeds of each stage."""
BEST = 3


class Teaching(NamedTuple):
    """How a teacher teaches."""

    title: str
    personality: str
    kinds: str = "fp+fn"
    corrects: bool = False
    """Whether it speaks only where the announced answer of the model is wrong."""
    rules: bool = False
    """Whether it says rules of the town alone."""


REFERENCE = "unlimited"
TEACHERS = {
    "early": Teaching("advice from the start", "early", "fp"),
    "mistake_correcting": Teaching("advice where the announced answer is wrong", "early", "fp", corrects=True),
    "ruler": Teaching("rules of the town", "ruler", rules=True),
    "half_bit": Teaching("sentences of half a bit", "informative(bits=0.5)"),
    "one_bit": Teaching("sentences of one bit", "informative(bits=1.0)"),
    "two_bits": Teaching("sentences of two bits", "informative(bits=2.0)"),
    REFERENCE: Teaching("advice without a budget", "early", "fp"),
}
"""By name."""
ADVICE, RULES = ("early", "mistake_correcting"), ("ruler", "two_bits")
"""The teachers of the hypotheses."""


class Speaker:
    """A personality in the teacher's seat; it counts its words, and keeps in mind the rules of the town that it said.

    Args:
        town: where it teaches.
        teaching: how it teaches.
        words: its budget; infinite: none.
    """

    def __init__(self, town: Town, teaching: Teaching, words: float) -> None:
        self.left, self.wanted = words, True
        """Words that are left, and whether it may speak in this house."""
        self.rules: list[Claim[Any]] = []
        self._rules_alone = teaching.rules
        env, speaks = make(town.place.id, options=mapped(town)), parse_personality(teaching.personality)
        if POSTERIOR in speaks.needs:
            speaks = self._reminded() | speaks
        self._teacher = env.family.make_teacher(env.session.world, speaks, feedback_type=teaching.kinds)
        self.reset = self._teacher.reset

    def _reminded(self) -> Personality:
        """Lets the personality behind it know what the student has heard in earlier houses."""

        @personality()
        def reminded(claims: Claims, view: View) -> Claims:
            view.hear([Atom(rule, "", view.turn) for rule in self.rules])
            return claims

        return reminded()

    def act(self, observation: Any, info: dict[str, Any]) -> Utterance:
        """The instruction, and what it says of the house while words are left."""
        said = self._teacher.act(observation, info)
        while self._rules_alone and not all(map(self._new_rule, feedback_of(said))):
            said = self._teacher.act(observation, info)
        heard = feedback_of(said)
        words = sum(len(atom.text.split()) for atom in heard)
        if self.wanted and words > self.left:
            self.left = 0
        if not self.wanted or not self.left:
            return Utterance.of([atom for atom in said.atoms if atom.kind is None])
        self.left -= words
        self.rules += [atom.claim for atom in heard if atom.claim.scope is Scope.FAMILY]
        return said

    def _new_rule(self, atom: Atom) -> bool:
        return atom.claim.scope is Scope.FAMILY and atom.claim not in self.rules


def feedback_of(said: Utterance) -> list[Atom]:
    """What was said beside the instruction."""
    return [atom for atom in said.atoms if atom.kind is not None]


def mapped(town: Town) -> dict[str, Any]:
    """The options of a town's houses with their plan in the instruction; the houses are the same."""
    return {**town.options, "map": True}


class House(NamedTuple):
    """What was said in a house, and what the reader did there."""

    seed: int
    mistaken: bool
    """Whether the announced answer is wrong; True if none was announced."""
    said: str
    words: int
    answer: str
    target: bool
    """Whether the model imitates the answer."""
    success: bool
    """Whether the answer is right; no one in training sees this."""


class Lesson:
    """A teacher and a reader in the houses of a town.

    Args:
        town, teaching, words: as in `Speaker`.
    """

    def __init__(self, town: Town, teaching: Teaching, words: float) -> None:
        self.town, self.speaker = town, Speaker(town, teaching, words)
        self.targets: list[dict[str, Any]] = []
        """All targets so far, as rows for SFT."""
        self._env = make(town.place.id, teacher=self.speaker, max_turns=1, options=mapped(town))
        self._reader = self._env.seat(READER)

    def teach(self, seeds: Sequence[int], mistaken: Sequence[bool]) -> list[House]:
        """Teach in the houses of some seeds; `mistaken` is as in `House`."""
        houses = [self._taught(*each) for each in zip(seeds, mistaken, strict=True)]
        steps = self.town.judge(seeds, [house.answer for house in houses])
        self.targets += [
            imitated(step.prompt, house.answer) for step, house in zip(steps, houses, strict=True) if house.target
        ]
        return [house._replace(success=step.success) for step, house in zip(steps, houses, strict=True)]

    def _taught(self, seed: int, mistaken: bool) -> House:
        self.speaker.wanted = mistaken
        observation, _ = self._env.reset(seed=seed)
        self._reader.reset(np.random.default_rng([self.town.number, seed]))
        action = self._reader.act(*self._env.seen_by(self._reader))
        said = observation["feedback"]
        target = bool(said or self.speaker.rules)
        answer = response(worded(self._env.session.world, action))
        return House(seed, mistaken, said, len(said.split()), answer, target, False)


class Taught(Run):
    """A run whose signal is a teacher of `TEACHERS`."""

    advised = False

    @property
    def tests_from(self) -> int:  # type: ignore[override]
        """First seed of the worlds of its tests, other houses in each town."""
        return HELD_OUT + 1_000_000 * self.town.number

    def go(self, learner: "Learner", step: Callable[[int, str], object] = lambda *_: None) -> None:
        """As in `Run`; what was said before an interruption is said to the reader again."""
        vars(self).pop("lesson", None)
        super().go(learner, step)

    @cached_property
    def lesson(self) -> Lesson:
        """The lesson up to the last stored update."""
        words = math.inf if self.signal == REFERENCE else self.settings["words"]
        lesson = Lesson(self.town, TEACHERS[self.signal], words)
        said: dict[int, list[Mapping[str, Any]]] = {}
        for row in houses_of(self.rows.read()):
            said.setdefault(row["update"], []).append(row)
        for rows in said.values():
            lesson.teach([row["seed"] for row in rows], [row["mistaken"] for row in rows])
        return lesson

    def _learn(self, learner: "Learner", update: int) -> tuple[list[dict[str, Any]], Any]:
        if update < self.settings["format"]:
            return super()._learn(learner, update)
        learner.set_rate(self.settings["rates"][FORMAT])
        lesson, count = self.lesson, self.settings["steps"]
        seeds = self.town.seeds(self.first(update), count)
        mistaken = [True] * count
        if TEACHERS[self.signal].corrects and lesson.speaker.left:
            longest = self.town.place.longest
            announced = self.town.play(lambda some: learner.answer(some, longest, sample=False), seeds, hears=False)
            mistaken = [not step.success for step in announced]
        houses = lesson.teach(seeds, mistaken)
        drawn = draw_targets(lesson.targets, count, np.random.default_rng([self.seed, update]))
        learned = learner.learn("sft", drawn, number("learn", self.seed, update))
        return [{"kind": "house", "update": update} | house._asdict() for house in houses], learned


def draw_targets(targets: Sequence[dict[str, Any]], count: int, rng: np.random.Generator) -> list[dict[str, Any]]:
    """Draw so many targets, without repetition if there are as many; none if there are none."""
    if not targets:
        return []
    return [targets[place] for place in rng.choice(len(targets), count, replace=len(targets) < count)]


def houses_of(rows: Sequence[Mapping[str, Any]]) -> list[Mapping[str, Any]]:
    """The rows of houses that were taught."""
    return [row for row in rows if row["kind"] == "house"]


def words_of(rows: Sequence[Mapping[str, Any]]) -> int:
    """The words that were said."""
    return sum(row["words"] for row in houses_of(rows))


Runs = Mapping[str, Mapping[int, list[dict[str, Any]]]]
"""Stored rows by teacher and training seed."""


def taught_runs(out: Path) -> Runs:
    """As `results`, with the houses checked, too.

    Raises:
        ValueError: as there; houses are missing, doubled, or no such houses.
    """
    runs = results(out, [*TEACHERS])
    for name, seeds in runs.items():
        for seed, rows in seeds.items():
            if fault := _fault_of_houses(name, rows):
                raise ValueError(f"{name}-{seed} in {out} {fault}; run it again, or write the file again with --rows")
    return runs


def _fault_of_houses(name: str, rows: Sequence[Mapping[str, Any]]) -> str:
    """What is wrong with the houses of a run; empty if nothing is."""
    settings, houses = rows[0], houses_of(rows)
    updates = [update for update in range(settings["format"], settings["updates"]) for _ in range(settings["steps"])]
    if [house["update"] for house in houses] != updates or len({house["seed"] for house in houses}) < len(houses):
        return f"must have {settings['steps']} houses in each update with a teacher, each once"
    if any(type(house[field]) is not bool for house in houses for field in ("mistaken", "target", "success")):
        return "must say true or false of each house: mistaken, target, success"
    if any(house["words"] != len(house["said"].split()) for house in houses):
        return "must have as many words in each house as were said"
    if name != REFERENCE and (said := words_of(houses)) > settings["words"]:
        return f"must have at most {settings['words']} words, got {said}"
    return ""


def of_stage(runs: Runs, stage: int) -> dict[str, dict[int, list[dict[str, Any]]]]:
    """The runs with the seeds of a stage, in the order of `TEACHERS`."""
    kept = {name: {seed: runs[name][seed] for seed in STAGES[stage] if seed in runs[name]} for name in runs}
    return {name: kept[name] for name in TEACHERS if kept.get(name)}


def ranking(runs: Runs) -> list[str]:
    """The teachers from the best in stage 1 to the worst.

    Raises:
        ValueError: stage 1 is not complete.
    """
    names = [name for name in TEACHERS if name != REFERENCE]
    missing = [f"{name}-{seed}" for name in names for seed in STAGES[1] if seed not in runs.get(name, {})]
    if missing:
        raise ValueError(f"all runs of stage 1 must have ended, missing: {', '.join(missing)}; run --stage 1 first")

    def place(name: str) -> tuple[float, float]:
        rows = [runs[name][seed] for seed in STAGES[1]]
        return -round(float(np.mean([*map(alone, rows)])), 9), float(np.mean([*map(words_of, rows)]))

    return sorted(names, key=place)


def in_second_stage(ranked: Sequence[str]) -> list[str]:
    """The three best, and the best teacher of advice if there is none among them."""
    three = [*ranked[:BEST]]
    return three if set(three) & set(ADVICE) else [*three, first_of(ADVICE, ranked)]


def first_of(names: Sequence[str], ranked: Sequence[str]) -> str:
    """The best of some teachers."""
    return min(names, key=ranked.index)


def verdicts(runs: Runs) -> list[str]:
    """The comparisons, by the rule above."""
    try:
        ranked = ranking(runs)
    except ValueError as error:
        return [f"Nothing is judged yet: {error}"]
    three, second = ranked[:BEST], of_stage(runs, 2)
    lines = [f"From the best to the worst in stage 1: {', '.join(ranked)}"]
    pairs = {pair: compared(second, *pair) for pair in combinations(three, 2)}
    whole = [found for found in pairs.values() if found is not None]
    corrected = iter(holm([p for _, p in whole]) if len(whole) == len(pairs) else [])
    for (one, other), found in pairs.items():
        adjusted = None if found is None else next(corrected, None)
        if found is None or adjusted is None:
            lines.append(f"{one} against {other}: not judged before all three have all seeds of stage 2")
        else:
            lines.append(f"{one} against {other}: {judged(found[0], adjusted)}, p = {adjusted:.3f} after Holm")
    rules, advice = first_of(RULES, ranked), first_of(ADVICE, ranked)
    why = "" if rules in three else "neither ruler nor two_bits is among the three best"
    lines.append(f"Primary hypothesis, {rules} against {advice}: {hypothesis(second, rules, advice, why)}")
    why = "" if {*ADVICE} <= {*three} else "they are not both among the three best"
    lines.append(f"Second hypothesis, mistake_correcting against early: {hypothesis(second, *ADVICE[::-1], why)}")
    return lines


def hypothesis(second: Runs, one: str, other: str, why_not: str) -> str:
    """What a test says of a hypothesis: one teacher teaches more than another."""
    found = compared(second, one, other)
    if why_not or found is None:
        return f"not judged, {why_not or 'not all seeds of stage 2 have ended'}"
    return f"{judged(*found)}, p = {found[1]:.3f}"


def judged(gain: float, p: float) -> str:
    """A difference of two teachers in words."""
    return f"{gain:+.2f}, {'nothing is shown' if p >= LEVEL else 'it teaches more' if gain > 0 else 'it teaches less'}"


def compared(second: Runs, one: str, other: str) -> tuple[float, float] | None:
    """The mean difference over the seeds of stage 2, and its two-sided p; None if some are missing."""
    seeds = STAGES[2]
    if not all(seed in second.get(name, {}) for name in (one, other) for seed in seeds):
        return None
    ours, theirs = ([alone(second[name][seed]) for seed in seeds] for name in (one, other))
    p = min(1.0, 2 * min(p_greater(ours, theirs), p_greater(theirs, ours)))
    return float(np.mean(np.subtract(ours, theirs))), p


def table(out: Path) -> list[str]:
    """The table and the verdicts, from the stored rows."""
    runs = taught_runs(out)
    if not runs:
        raise ValueError(f"{out} must have finished runs, got none; run it without --table first")
    heads = ["teacher", "seeds", "found alone", "words", "houses", "targets", "right", "no action", "steps", "tokens"]
    lines = [" | ".join([*heads, "CPU min"]), " | ".join("---" for _ in range(len(heads) + 1))]
    for stage in STAGES:
        for name, rows in of_stage(runs, stage).items():
            lines.append(" | ".join([f"stage {stage}: {name}, {TEACHERS[name].title}", *_cells([*rows.values()])]))
    return [*lines, *references(of_stage(runs, 2) or runs, FAMILY), "", *verdicts(runs)]


def _cells(runs: Sequence[list[dict[str, Any]]]) -> list[str]:
    every = [row for rows in runs for row in rows]
    houses = houses_of(every)
    updates = [row for row in every if row["kind"] == "update"]
    failed = [row["failure"] is not None for row in every if row["kind"] == "test" and row["last"]]
    return [
        f"{len(runs)}",
        interval_of([*map(alone, runs)]),
        *share_cells(houses, len(runs)),
        f"{np.mean(failed):.0%}",
        *(f"{sum(row[name] for row in updates) / len(runs):,.0f}" for name in ("steps", "tokens")),
        f"{sum(row['cpu'] for row in updates) / 60 / len(runs):,.1f}",
    ]


def share_cells(houses: Sequence[Mapping[str, Any]], runs: int = 1) -> list[str]:
    """Words, houses in which something was said, and targets, in the mean of the runs; the share of right targets."""
    right = [row["success"] for row in houses if row["target"]]
    said = sum(row["words"] for row in houses), sum(row["words"] > 0 for row in houses), len(right)
    return [*(f"{each / runs:.0f}" for each in said), f"{np.mean(right):.2f}" if right else "-"]


def words_alone(
    budgets: Sequence[int] = (100, 200, 400), houses: int = (UPDATES - START) * STEPS_OF_UPDATE
) -> list[str]:
    """What the words are worth without a model; `mistake_correcting` hears random answers."""
    lines = ["town | budget | teacher | words | houses | targets | right", " | ".join("---" for _ in range(7))]
    for seed in STAGES[1]:
        town = Town(FAMILY, seed)
        seeds, rng = town.seeds(0, houses), np.random.default_rng(seed)
        wrong = [not step.success for step in town.judge(seeds, [town.random_answer(rng) for _ in seeds])]
        for budget in budgets:
            for name in TEACHERS:
                teaching = TEACHERS[name]
                lesson = Lesson(town, teaching, math.inf if name == REFERENCE else budget)
                taught = lesson.teach(seeds, wrong if teaching.corrects else [True] * houses)
                cells = share_cells([house._asdict() for house in taught])
                lines.append(" | ".join([f"{seed}", f"{budget}", name, *cells]))
    return lines


def main(arguments: Sequence[str] | None = None) -> None:
    """Run what is asked for, and print the table."""
    options = _parser().parse_args(arguments)
    console = Console(soft_wrap=True, highlight=False, markup=False)
    try:
        if options.words_alone:
            lines = words_alone()
        elif options.pilot:
            lines = _work(options, console)
        else:
            if not options.table:
                _work(options, console)
            lines = table(options.out)
        for line in lines:
            console.print(line)
        if options.rows:
            pack(options.out, options.rows, [*TEACHERS])
        if options.plot:
            titles = {name: f"{name}: {teaching.title}" for name, teaching in TEACHERS.items()}
            runs = taught_runs(options.out)
            shown = of_stage(runs, 2) or runs
            draw_curves(shown, titles, levels(shown, FAMILY), "updates", options.plot)
    except (ValueError, FloatingPointError, OSError) as error:
        raise SystemExit(f"{error}") from None
    except KeyboardInterrupt:
        raise SystemExit("interrupted; the same command goes on from the last update") from None


def _work(options: argparse.Namespace, console: Console) -> list[str]:
    """Play a stage, or say how long it takes."""
    names = [*TEACHERS]
    if options.stage == 2:
        names = in_second_stage(ranking(taught_runs(options.out)))
    names = [name for name in names if name in options.teachers]
    from word_training import RATES, Learner

    options.out.mkdir(parents=True, exist_ok=True)
    settings = {
        name: getattr(options, name) for name in ("model", "dtype", "updates", "format", "steps", "worlds", "words")
    }
    settings |= {"family": FAMILY, "rates": {FORMAT: RATES["sft"] if options.rate is None else options.rate}}
    for path in options.out.glob("*-*/settings.json"):  # both stages need the same settings
        name, _, seed = path.parent.name.rpartition("-")
        Taught(options.out, name, int(seed), settings).check()
    learner = Learner(options.model, options.device, options.dtype, options.max_prompt)
    seeds = STAGES[options.stage]
    if options.pilot:
        return pilot(learner, options.out, names, len(seeds), settings, Taught)
    with Progress(console=console, disable=not console.is_terminal) as bars:
        for seed in seeds:
            for name in names:
                play(Taught(options.out, name, seed, settings), learner, f"{name} seed {seed}", bars)
    return []


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument(
        "--out", type=Path, required=True, help="folder of the rows and checkpoints, or a file of --rows"
    )
    parser.add_argument(
        "--rows", type=Path, metavar="FILE", help="write the rows that the table is made of into a file"
    )
    parser.add_argument("--stage", type=int, default=1, choices=[*STAGES], help="default: 1")
    parser.add_argument(
        "--teachers", nargs="+", default=[*TEACHERS], choices=[*TEACHERS], help="of the stage; default: all"
    )
    parser.add_argument("--words", type=int, default=WORDS, help=f"words of a teacher; default: {WORDS}")
    parser.add_argument("--updates", type=int, default=UPDATES, help=f"updates of a run; default: {UPDATES}")
    parser.add_argument("--format", type=int, default=START, help=f"updates of a run's start; default: {START}")
    parser.add_argument("--steps", type=int, default=STEPS_OF_UPDATE, help="environment steps of an update")
    parser.add_argument("--worlds", type=int, default=WORLDS, help="worlds of a test")
    parser.add_argument("--rate", type=float, help="learning rate; default: that of SFT in learn_from_words.py")
    add_model(parser)
    parser.add_argument("--plot", type=Path, metavar="FILE", help="draw the curves of the stored rows")
    what = parser.add_mutually_exclusive_group()
    what.add_argument("--table", action="store_true", help="print the table of the stored rows")
    what.add_argument("--pilot", action="store_true", help="measure, and say how long the stage takes")
    what.add_argument("--words-alone", action="store_true", help="print what the words are worth without a model")
    return parser


if __name__ == "__main__":
    main()
