"""What is said in lessons that a small model learns from: which kinds, in how many words (Xi et al. 2024)."""

from collections.abc import Sequence
from itertools import chain
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from llf_teacher.gym import StudentEnv, make
from llf_teacher.reproductions.drawing import bars
from llf_teacher.reproductions.household import Sentences, blundering, play
from llf_teacher.reproductions.row import Reading, Row, Values, describe
from llf_teacher.studies.analysis.statistics import Estimate, mean_interval, paired_difference

if TYPE_CHECKING:
    from matplotlib.figure import Figure

KINDS = {"nothing": "n", "hindsight": "hp+hn", "foresight": "fp", "both": "hp+hn+fp"}
VOICES = {"one": ("plain",), "many": ("plain", "socratic")}
TEST_VOICE = "warm"
KNOWN = (
    "pick_and_place_simple",
    "look_at_obj_in_light",
    "pick_clean_then_place_in_recep",
    "pick_cool_then_place_in_recep",
)
NEW = ("pick_heat_then_place_in_recep", "pick_two_obj_and_place")
TASKS = {"known tasks": KNOWN, "new tasks": NEW}
TEACHERS = {"always": "oracle", "half": "inconsistent(likelihood=0.5, consistency=1)", "silent": "silent"}
"""By how often the teacher of the test speaks."""
EPISODES, EPOCHS, MISTAKES, TURNS, TESTS = 320, 3, 0.5, 30, 16
"""Lessons, how often each is learned from, how often the student of the lessons errs; turns of an episode; episodes of
a test, of each of the four that there are."""
CELLS = (("known tasks", "always"), *(("new tasks", speaks) for speaks in TEACHERS))
SPOKEN = [cell for cell, (_, speaks) in enumerate(CELLS) if speaks != "silent"]
NEWS = CELLS.index(("new tasks", "always"))


def house(kinds: str, voice: str, wording: Sentences, teacher: str = "oracle", **options: Any) -> StudentEnv:
    """Houses that are made by seed, with a teacher who makes claims of these kinds; `n` for none."""
    options |= {"feedback_type": kinds, "voice": voice, "paraphrase": wording, "teacher": teacher}
    return make("llf-alfworld-v0", games="generated", **options)


def measure(kinds: str, words: str, seed: int) -> Sequence[float]:
    """Train a model and test it: by tasks and how often the teacher speaks, the mean score."""
    import torch

    from llf_teacher.reproductions.sequence import SequenceModel

    torch.set_num_threads(1)  # measurements run side by side
    voices = VOICES[words]
    draws, errs, learns, says = (np.random.default_rng([seed, stream]) for stream in range(4))
    wording = Sentences(False, draws if words == "many" else None)
    envs = [
        house(kinds, voice, wording, task=task, split="train", max_turns=TURNS) for voice in voices for task in KNOWN
    ]
    lessons = []
    for i in range(EPISODES):
        env = envs[i % len(envs)]
        lessons += play([(env, 1000 * seed + i)], blundering(env, MISTAKES, errs))
    model = SequenceModel(learns)
    model.learn(lessons, EPOCHS)
    tests = []
    for tasks, speaks in CELLS:
        for i in range(TESTS):
            task = TASKS[tasks][i % len(TASKS[tasks])]
            options = {"task": task, "split": "valid_unseen", "max_turns": TURNS}
            env = house(kinds, TEST_VOICE, Sentences(True, says), TEACHERS[speaks], **options)
            tests.append((env, 1000 * seed + i))
    scores = [errand.score for errand in play(tests, model.player())]
    return [float(each) for each in np.reshape(scores, (len(CELLS), TESTS)).mean(axis=1)]


SETTINGS = (
    {"kinds": KINDS["nothing"], "words": "one"},
    *({"kinds": kinds, "words": words} for kinds in KINDS.values() if kinds != "n" for words in VOICES),
)


def _column(values: Values, kinds: str, words: str, cell: int) -> NDArray[np.float64]:
    """The scores of what learned from these kinds in so many sentences; from nothing, sentences are no matter."""
    return values(kinds=KINDS[kinds], words="one" if kinds == "nothing" else words)[:, cell]


def read(values: Values) -> Reading:
    """Scores, and what kinds and sentences are worth while the teacher of the test speaks."""
    names = {kinds: name for name, kinds in KINDS.items()}
    table = [["said in the lessons", "sentences", *(f"{tasks}, {speaks}" for tasks, speaks in CELLS)]]
    for setting in SETTINGS:
        sentences = setting["words"] if setting["kinds"] != "n" else "none"
        table.append(
            [
                names[setting["kinds"]],
                sentences,
                *(describe(mean_interval(each)) for each in values(**setting).T),
            ]
        )

    def worth(more: tuple[str, str], less: tuple[str, str]) -> list[Estimate]:
        """How much higher the score is with such kinds and words than with others, by cells in which it is spoken."""
        pairs = [(_column(values, *more, cell), _column(values, *less, cell)) for cell in SPOKEN]
        return [paired_difference(*pair).estimate for pair in pairs]

    kinds = {name: worth(("both", "many"), (name, "many")) for name in KINDS if name != "both"}
    words = {name: worth((name, "many"), (name, "one")) for name in KINDS if name != "nothing"}
    every = list(chain.from_iterable(words.values()))
    best = mean_interval(_column(values, "both", "many", NEWS))
    at = SPOKEN.index(NEWS)
    more = ", ".join(f"{describe(gains[at])} beside {name}" for name, gains in kinds.items())
    many = ", ".join(f"{describe(gains[at])} with {name}" for name, gains in words.items())
    ours = (
        "On new tasks, taught in words that are new, what learned from both kinds in many sentences scores "
        f"{describe(best)}, a difference of {more}. Many sentences instead of one are worth {many}; they are surely "
        f"better in {sum(each.low > 0 for each in every)} of {len(every)} cells and surely worse in "
        f"{sum(each.high < 0 for each in every)}."
    )
    informative = [gains[at].low > 0 for gains in kinds.values()]
    diverse = words["both"][at].low > 0
    agrees = "yes" if all(informative) and diverse else "in part" if informative[0] or diverse else "no"
    return Reading(agrees, ours, WHY if agrees == "in part" else "", table)


def draw(values: Values, figure: "Figure") -> None:
    """Scores by kinds and sentences, a panel for tasks of the lessons and one for others."""
    panels = figure.subplots(1, len(TASKS), sharey=True)
    for axes, tasks in zip(panels, TASKS, strict=True):
        cell = CELLS.index((tasks, "always"))
        series = {
            f"{words} sentence{'s' * (words == 'many')}": [
                mean_interval(_column(values, kinds, words, cell)) for kinds in KINDS
            ]
            for words in VOICES
        }
        bars(axes, tuple(KINDS), series)
        axes.set(title=f"{tasks}, the teacher always speaks", xlabel="said in the lessons and in the test")
    panels[0].set_ylabel("least commands / commands")
    panels[0].legend()


WHY = (
    "The teacher names the very command to give, so that advice leaves little to add. A verdict names the last "
    "command, and a model that hears both has to learn which of the two is meant; whether it would with more lessons "
    "was not tried. Verdicts alone, as nothing at all, do not say where things lie, which the student of the lessons "
    "knew. New sentences may puzzle little because in each of ours the command stands between the same signs. The "
    "paper's models begin with sentences embedded by a model that was trained on much text; ours has met no word "
    "before."
)
ROW = Row(
    claim="Lessons that say more, of the past and of the future, and in many ways, teach a model more",
    source="Xi et al. 2024 (arXiv 2410.24218)",
    protocol=(
        f"{EPISODES} lessons in ALFWorld's houses on four of its six types of tasks, by a student who in half of the "
        "turns does anything, and else what is best. The teacher gives hindsight (hp and hn), foresight (fp), both or "
        "nothing, each claim in one sentence or in many (those of the voices `plain` and `socratic`). A small model "
        "learns from it: a convolution over the words of the teacher, of which it knows nothing before, and a "
        "recurrent layer over turns. It is told the return, as a decision transformer is, and imitates. Its tests "
        "have the same kinds in sentences and a voice (`warm`) that it does not know, in floor plans that it does not "
        f"know, on tasks of the four types and of the two others, {TESTS} episodes of at most {TURNS} turns for each "
        "of four cells: the teacher says each claim always, with probability a half, or never. The score is the least "
        "number of commands as a share of those given, 0 if the task is not done. Each of six seeds is a training "
        "with lessons and tests of its own. The paper has a decision transformer, sentences that language models "
        "paraphrase and embed, and four benchmarks, of which ALFWorld is one."
    ),
    settings=SETTINGS,
    seeds=6,
    measure=measure,
    measures=tuple(f"score on {tasks} ({speaks})" for tasks, speaks in CELLS),
    read=read,
    draw=draw,
    needs="torch",
)
