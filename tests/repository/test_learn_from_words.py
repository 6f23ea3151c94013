"""Learning from words, as far as it needs no model: worlds, labels, rows and table."""

import json
import sys
from pathlib import Path

import numpy as np
import pytest

from worlds.gridworld import kind_of

sys.path.insert(0, f"{Path(__file__).parents[2] / 'examples'}")
import learn_from_words as program
from word_signals import (
    HELD_OUT,
    HELD_OUT_PHRASE,
    HELD_OUT_VOICE,
    SIGNALS,
    TRAINING_PHRASES,
    Rows,
    Town,
    advice_in,
    bare,
    examples,
    imitated,
    response,
)

WAYS = ("north", "east", "west", "south")


@pytest.fixture(scope="module")
def town():
    return Town("gridworld", 0)


def random_answers(rng):
    return lambda conversations: [response(str(rng.choice(WAYS))) for _ in conversations]


def lawful(law):
    """Answers by the law of a town, from what the prompt says alone."""

    def answer(conversations):
        answers = []
        for messages in conversations:
            line = next(each for each in messages[-1]["content"].splitlines() if each.startswith("Doors: "))
            doors = dict(door.split(": ") for door in line.removeprefix("Doors: ").split(", "))
            answers.append(response(next(way for way, room in doors.items() if kind_of(room) == law)))
        return answers

    return answer


def test_the_worlds_are_those_in_which_the_right_move_can_be_seen(town):
    seeds = town.seeds(0, 20)
    assert seeds == sorted({*seeds})
    for seed in seeds:
        town.world.reset(seed=seed)
        room, _, layout = town.world.truth
        doors = [behind for behind in layout.doors[room] if behind >= 0]
        assert len(doors) >= 3
        assert layout.treasure in doors
    assert len({Town("gridworld", seed).world.law for seed in range(5)}) == 5, "each training seed has another law"
    assert Town("gridworld", program.TUNING_TOWN).world.law not in {
        Town("gridworld", seed).world.law for seed in range(5)
    }


def test_the_references_are_what_such_players_get(town):
    seeds = town.seeds(HELD_OUT, 200)
    computed = town.references(seeds)
    assert computed["random"] == 0.25
    assert computed["random"] < computed["possible"] < computed["law"] < 1
    rng = np.random.default_rng(0)
    for name, policy in (("random", random_answers(rng)), ("law", lawful(town.world.law))):
        found = np.mean([step.success for step in town.play(policy, seeds, hears=True, feedback="n")])
        assert found == pytest.approx(computed[name], abs=0.09), name  # three standard errors at most
    for name, count in (("bandits", 50), ("movies", 50), ("alfworld", 5)):
        other = Town(name, 0)
        found = other.references(other.seeds(HELD_OUT, count))
        assert 0 < found["random"] <= found["possible"] < found["law"] <= 1, name


def test_prompts_of_tests_have_no_feedback_and_no_phrase_of_training(town):
    seeds = town.seeds(HELD_OUT, 12)
    seen = []

    def answer(conversations):
        seen.extend(conversations)
        return ["Response: north"] * len(conversations)

    tested = town.play(answer, seeds, hears=True, feedback="n", voice=HELD_OUT_VOICE, phrases=(HELD_OUT_PHRASE,))
    assert not any("Teacher: " in message["content"] for messages in seen for message in messages)
    assert not any(step.advice for step in tested)
    trained = town.play(random_answers(np.random.default_rng(0)), town.seeds(0, 30), hears=False)
    systems = [{step.prompt[0]["content"] for step in steps} for steps in (trained, tested)]
    assert len(systems[0]) == len(TRAINING_PHRASES)
    assert not systems[0] & systems[1]
    advised = town.play(answer, seeds, hears=True, feedback="fp", voice=HELD_OUT_VOICE, phrases=(HELD_OUT_PHRASE,))
    words = [{step.advice.rsplit(" ", 1)[0] for step in steps} for steps in (trained, advised)]
    assert all(words)
    assert not words[0] & words[1]


def test_training_sees_no_world_of_a_test():
    settings = {"family": "gridworld", "updates": program.UPDATES, "steps": program.STEPS_OF_UPDATE, "rates": {}}
    last = program.Run(Path(), "b", 4, settings)
    assert last.town.seeds(last.first(program.UPDATES - 1), program.STEPS_OF_UPDATE)[-1] < HELD_OUT
    firsts = [
        program.Run(Path(), "b", seed, settings).first(update) for seed in range(3) for update in range(program.UPDATES)
    ]
    assert np.diff(firsts).min() > 2 * program.STEPS_OF_UPDATE / 0.13, (
        "or an update would repeat worlds of the one before"
    )


def test_only_a_policy_that_hears_gets_the_advice(town):
    seeds = town.seeds(0, 6)
    for hears in (False, True):
        seen = []

        def answer(conversations, seen=seen):
            seen.extend(conversations)
            return ["west"] * len(conversations)

        steps = town.play(answer, seeds, hears=hears)
        assert [bool(advice_in(each)) for each in seen] == [hears] * 6
        assert all(step.advice == advice_in(step.heard) != "" for step in steps)
        assert all(bare(step.heard) == step.prompt for step in steps)


def test_what_is_imitated_is_what_the_words_say(town):
    steps = town.play(random_answers(np.random.default_rng(1)), town.seeds(0, 30), hears=False)
    made = examples("b", town, steps, np.random.default_rng(0))
    assert len(made) == 30
    for step, row in zip(steps, made, strict=True):
        ((said,), prompt) = row["completion"], row["prompt"]
        way = said["content"].removeprefix("Response: ")
        assert way in step.advice
        assert prompt == step.prompt
        assert town.judge([step.seed], [said["content"]])[0].success, "the oracle's advice finds the treasure"
    no_word = steps[0]._replace(advice="Somebody is at the door to the north.")
    assert town.advised(no_word.advice) is None
    assert examples("b", town, [no_word], np.random.default_rng(0)) == []
    assert town.advised("You should have gone west. Go north next.") == "Response: north"


def test_words_about_other_houses_are_right_by_chance(town):
    seeds = town.seeds(0, 120)
    steps = town.play(random_answers(np.random.default_rng(1)), seeds, hears=False, teacher=SIGNALS["e"].teacher)
    made = examples("e", town, steps, np.random.default_rng(0))
    assert len(made) > 100
    named = [town.advised(step.advice) for step in steps]
    kept = [(seed, answer) for seed, answer in zip(seeds, named, strict=True) if answer]
    found = [step.success for step in town.judge([seed for seed, _ in kept], [answer for _, answer in kept])]
    assert 0.1 < np.mean(found) < 0.45


def test_pairs_are_of_a_praised_and_a_blamed_answer_to_the_same_prompt(town):
    seeds = [seed for seed in town.seeds(0, 8) for _ in WAYS]
    steps = town.judge(seeds, [*map(response, WAYS[:3]), "I cannot say."] * 8)
    verdicts = [town.praised(step) for step in steps]
    assert verdicts == [step.success for step in steps]
    made = examples("c", town, steps, np.random.default_rng(0))
    groups = [group for group in np.array(verdicts).reshape(8, 4) if group.any()]
    assert len(made) == min(3 * len(groups), len(steps) // 2) > 0
    right = {step.prompt[-1]["content"]: step.answer for step in steps if step.success}
    for row in made:
        asked = row["prompt"][-1]["content"]
        assert row["chosen"][0]["content"] == right[asked] != row["rejected"][0]["content"]


def test_what_was_praised_is_learned_with_the_advice_and_without(town):
    steps = town.judge(town.seeds(0, 20), ["Response: north"] * 20)
    made = examples("d", town, steps, np.random.default_rng(0))
    praised = [step for step in steps if step.success]
    assert len(made) == 2 * min(len(praised), len(steps) // 2) > 0
    assert [bool(advice_in(row["prompt"])) for row in made] == [True, False] * len(praised)


def test_format_alone_is_an_action_by_chance(town):
    steps = town.judge(town.seeds(0, 200), [""] * 200)
    made = examples("f", town, steps, np.random.default_rng(0))
    counts = {way: sum(row["completion"][0]["content"] == response(way) for row in made) for way in WAYS}
    assert sum(counts.values()) == 200
    assert min(counts.values()) > 30
    with pytest.raises(ValueError, match="signal must be one of b, c, d, e, f, g, got 'a'"):
        examples("a", town, steps, np.random.default_rng(0))


def test_rewarded_answers_are_imitated_without_a_word_of_the_teacher(town):
    steps = town.judge(town.seeds(0, 40), ["Response: north"] * 40)
    made = examples("g", town, [step._replace(verdict="", advice="") for step in steps], np.random.default_rng(0))
    assert made == [imitated(step.prompt, step.answer) for step in steps if step.success]
    assert 0 < len(made) < 40
    for reward, kept in ((0.0, 0), (1.0, 40)):  # where nothing or everything is rewarded
        equal = [step._replace(reward=reward) for step in steps]
        assert len(examples("g", town, equal, np.random.default_rng(0))) == kept


@pytest.mark.parametrize("name", ["bandits", "movies", "alfworld"])
def test_advice_is_read_and_followed_in_the_other_families(name):
    town = Town(name, 0)
    seeds = town.seeds(HELD_OUT, 3)
    test = {"hears": True, "feedback": "fp", "voice": HELD_OUT_VOICE, "phrases": (HELD_OUT_PHRASE,)}
    followed = town.play(lambda some: [town.advised(advice_in(each)) for each in some], seeds, **test)
    assert all(map(town.follows, followed))
    assert not any(map(town.follows, town.play(lambda some: ["nothing"] * len(some), seeds, **test)))


def test_rows_behind_a_checkpoint_are_cut_and_a_torn_line_is_not_read(tmp_path):
    rows = Rows(tmp_path / "run/rows.jsonl")
    assert rows.read() == []
    rows.add([{"a": 1}, {"a": 2}])
    end = rows.end
    rows.add([{"a": 3}])
    with rows.path.open("a") as file:
        file.write('{"a": 4')
    assert [row["a"] for row in rows.read()] == [1, 2, 3]
    rows.cut(end)
    assert [row["a"] for row in rows.read()] == [1, 2]
    with pytest.raises(ValueError, match="must have at least 1000 bytes"):
        rows.cut(1000)


def store(out, policies, seeds=3, worlds=40):
    """Finished runs whose tests were really played, by these policies."""
    for letter, policy in policies.items():
        for seed in range(seeds):
            town = Town("gridworld", seed)
            run = program.Run(
                out, letter, seed, {"family": "gridworld", "updates": 1, "format": 1, "steps": 32, "worlds": worlds}
            )
            run.check()
            played = town.play(policy(town), town.seeds(HELD_OUT, worlds), hears=True, feedback="n")
            more = {"test": "alone", "family": "gridworld", "last": True}
            tests = [program.row_of(step, "test", 2) | more | {"prompt": ["", "?"]} for step in played]
            update = {"kind": "update", "update": 0, "steps": 32, "tokens": 100, "cpu": 60.0}
            updates = [] if letter == program.BASE else [update]
            run.rows.add([*updates, *tests, {"kind": "end"}])


def test_the_table_is_computed_from_the_rows_alone(tmp_path):
    rng = np.random.default_rng(0)

    def by_chance(town):
        return random_answers(rng)

    store(tmp_path, {"base": by_chance, "a": by_chance, "f": by_chance, "b": lambda town: lawful(town.world.law)})
    lines = program.table(tmp_path)
    cells = {line.split(" | ")[0]: line.split(" | ") for line in lines if " | " in line}
    law = cells["by the law: best without a teacher"][2]
    assert abs(float(cells["(b) imitate the advised action"][2].split()[0]) - float(law)) < 0.12
    assert float(cells["(f) format alone"][2].split()[0]) < 0.45
    assert cells["(b) imitate the advised action"][-3:] == ["32", "100", "1.0"]
    assert any(line.startswith("(b) imitate the advised action: beats (a) and (f), p = 0.0") for line in lines)
    program.draw(tmp_path, tmp_path / "curve.png")
    assert (tmp_path / "curve.png").stat().st_size > 5_000
    assert len([line for line in program.transcripts(tmp_path) if line.startswith("after: 'Response: ")]) == 30
    packed = tmp_path / "rows.jsonl"
    program.pack(tmp_path, packed)
    assert program.table(packed) == lines
    assert program.transcripts(packed) == program.transcripts(tmp_path)
    program.main(["--out", f"{packed}", "--table", "--plot", f"{tmp_path / 'again.png'}"])
    assert (tmp_path / "again.png").read_bytes() == (tmp_path / "curve.png").read_bytes()
    # A run that has not ended is not in the table.
    rows = Rows(tmp_path / "b-2/rows.jsonl")
    rows.cut(rows.end - len('{"kind": "end"}\n'))
    assert any("(b) against (a): not judged, 2 common seeds of at least 3" in line for line in program.table(tmp_path))


def doubled(rows):
    return [*rows[:-1], rows[-2], rows[-1]]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (doubled, "must have each test once, got one twice"),
        (lambda rows: [*rows[:-2], rows[-1]], "must have 20 last tests, got 19"),
        (lambda rows: rows[:-1], "must begin with its settings and have an end"),
        (
            lambda rows: [row for row in rows if row["kind"] != "update"],
            r"must have updates 0 to 0, each once, got \[\]",
        ),
        (lambda rows: [*rows[:-2], rows[-2] | {"success": 50}, rows[-1]], "must say of each test whether it succeeded"),
        (
            lambda rows: [*rows[:-2], {"run": "b-1", "kind": "test"}, rows[-1]],
            "must have rows of these runs, got one without 'update'",
        ),
        (lambda rows: [{**row, "tokens": float("nan")} for row in rows], "must have finite steps, tokens and CPU"),
        (
            lambda rows: [rows[0] | {"updates": 1, "steps": 64}, *rows[1:]],
            "must have the settings but for learning rates",
        ),
        (lambda rows: [*rows[:-2], rows[-2] | {"seed": 1}, rows[-1]], "must have the worlds of the tests of"),
    ],
)
def test_rows_that_would_change_a_verdict_are_refused(tmp_path, change, message):
    store(tmp_path, dict.fromkeys("ab", lambda town: lawful(town.world.law)), seeds=2, worlds=20)
    packed = tmp_path / "rows.jsonl"
    program.pack(tmp_path, packed)
    rows = Rows(packed).read()
    of_b = [row for row in rows if row["run"] == "b-1"]
    changed = [row for row in rows if row["run"] != "b-1"] + change(of_b)
    packed.write_text("".join(json.dumps(row) + "\n" for row in changed), "utf-8")
    with pytest.raises(ValueError, match=f"b-1 in .*rows.jsonl {message}"):
        program.table(packed)
    packed.write_text('{"kind": "test"}\n', "utf-8")
    with pytest.raises(ValueError, match="must have rows that --rows wrote, each with the name of its run, got "):
        program.table(packed)


def test_chance_does_not_win(tmp_path):
    rng = np.random.default_rng(1)
    store(tmp_path, dict.fromkeys("afbd", lambda town: random_answers(rng)))
    assert program.table(tmp_path)[-1] == "No signal from words beats both (a) and (f)."


def test_p_of_a_comparison():
    assert program.p_greater([0.9, 0.8, 0.85], [0.3, 0.25, 0.3]) < 0.01
    assert program.p_greater([0.3, 0.25, 0.3], [0.9, 0.8, 0.85]) > 0.99
    assert program.p_greater([0.5, 0.6, 0.7], [0.4, 0.5, 0.6]) == 0.125
    assert program.p_greater([0.5, 0.6, 0.7], [0.5, 0.6, 0.7]) == 1


def test_other_settings_and_an_empty_folder_are_refused(tmp_path):
    program.Run(tmp_path, "b", 0, {"family": "gridworld", "updates": 4}).check()
    with pytest.raises(ValueError, match="was begun with updates=4, got 5; give the same settings or another --out"):
        program.Run(tmp_path, "b", 0, {"family": "gridworld", "updates": 5}).check()
    with pytest.raises(SystemExit, match="must have finished runs, got none"):
        program.main(["--out", f"{tmp_path}", "--table"])
    with pytest.raises(SystemExit) as error:
        program.main(["--out", f"{tmp_path}", "--signals", "z"])
    assert error.value.code == 2
