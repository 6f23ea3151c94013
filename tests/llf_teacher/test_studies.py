"""Studies: files, the runner, the store, interruption."""

import numpy as np
import pytest
from studying import FILE, small

from llf_teacher.serialization import read_toml
from llf_teacher.studies.definition.study import Study, load_study, quickstart
from llf_teacher.studies.execution.episode import play
from llf_teacher.studies.execution.runner import manifest, play_missing
from llf_teacher.studies.store import Store, StoreError


def test_a_file(tmp_path):
    path = tmp_path / "study.toml"
    path.write_text(FILE)
    study = load_study(path)
    assert study.seeds == (0, 1, 2)
    assert study.instruction_types == ("b",)
    assert len(list(study.episodes())) == 18
    assert len({spec.key for spec in study.episodes()}) == 18


def test_specs_are_canonical():
    study = small()
    assert study.ids[0] == "llf-gridworld-v0"
    assert study.teachers == ("oracle", "mistake(eps=0.5)")
    assert Study(**study.as_dict()) == study


def test_the_quickstart_covers_what_it_promises():
    study = quickstart()
    assert len(study.teachers) >= 6
    assert len(study.seeds) == 10
    assert {"random", "obedient", "text_only", "oracle", "reward_only"} <= set(study.students)
    assert study.question == "Do late words cost a student more, or wrong ones?"
    assert study.compare == (("delayed(turns=2)", "mistake(eps=0.3)"),)
    assert all(set(study.compare[0]) <= set(study.grid(id).teachers) for id in study.ids)


def test_counts_of_numpy_are_pythons_own():
    """A key is JSON, which has no integers of NumPy."""
    study = small(max_turns=np.int64(3), samples=np.int64(2), bits=np.int64(8))
    assert study == small(max_turns=3, samples=2, bits=8)
    assert [each.key for each in study.episodes()] == [
        each.key for each in small(max_turns=3, samples=2, bits=8).episodes()
    ]


def test_any_sequence_is_a_list_and_kept_as_a_tuple():
    study = small(ids=("llf-gridworld-v0",), seeds=range(2, 4), fewer={"*": {"seeds": range(3, 4)}})
    assert (study.ids, study.seeds) == (("llf-gridworld-v0",), (2, 3))
    assert study.grid("llf-gridworld-v0").seeds == (3,)


@pytest.mark.parametrize(
    ("changes", "match"),
    [
        ({"ids": ["llf-gridwold-v0"]}, "ids: unknown environment .*did you mean llf-gridworld-v0"),
        ({"ids": []}, "ids must be a list of 1 to 1000000 values, got"),
        ({"ids": "llf-gridworld-v0"}, "ids must be a list of"),
        ({"teachers": ["orakle"]}, "teachers: unknown personality 'orakle'"),
        ({"teachers": [3]}, "teachers: bad teacher spec 3"),
        ({"students": ["nobody"]}, "students: unknown student"),
        ({"feedback_types": ["q"]}, "feedback_types: feedback type 'q'"),
        (
            {"ids": ["llf-gridworld-v0", "llf-poem-Haiku-v0"], "teachers": ["noisy"]},
            "^teachers: llf-poem-Haiku-v0 cannot have 'noisy': the oracle lacks what it needs",
        ),
        (
            {"ids": ["llf-poem-Tanka-v0", "llf-poem-Haiku-v0"], "teachers": ["noisy"]},
            "^teachers: llf-poem-Tanka-v0, llf-poem-Haiku-v0 cannot have 'noisy'[^;]*;[^;]*$",
        ),
        ({"instruction_types": ["z"]}, "instruction_types: llf-gridworld-v0, .* cannot have 'z'; allowed: b, p, c$"),
        ({"instruction_types": [3]}, "instruction_types: an instruction type must be a string, got 3"),
        ({"ids": [["x"]]}, "ids: an id must be a string"),
        ({"students": ["nobody"] * 5}, "^students: unknown student 'nobody'[^;]*;[^;]*$"),
        ({"seeds": "two"}, "seeds must be a list of 1 to 1000000 values, or a number from 1 to 1000000, got 'two'"),
        ({"seeds": 0}, "seeds must be a list of"),
        ({"seeds": b"7"}, "seeds must be a list of"),
        ({"seeds": 2_000_000_000}, "seeds must be a list of 1 to 1000000 values, or .* got 2000000000"),
        ({"seeds": range(2_000_000_000)}, "seeds must be a list of 1 to 1000000 values, or .* got range"),
        ({"seeds": 10**30}, "seeds must be a list of"),
        ({"fewer": {"llf-*": {"seeds": 2_000_000_000}}}, "seeds must be a list of"),
        (
            {"seeds": [2**63 - 1, 2**63]},
            "a seed must be an integer from 0 to 9223372036854775807, got 9223372036854775808",
        ),
        ({"seeds": 1_000_000, "samples": 1_000_000}, "at most 100000000 episodes, got .*; give fewer seeds or samples"),
        ({"samples": 10**20}, "samples must be an integer from 1 to 1000000, got 1"),
        ({"max_turns": 10**20}, "max_turns must be an integer from 1 to 1000000, got 1"),
        ({"bits": 10**9}, "a number of worlds, 1 to 100000, got 1"),
        ({"seeds": [-1]}, "a seed must be an integer from 0 to 9223372036854775807, got -1"),
        ({"seeds": True}, "seeds must be"),
        ({"max_turns": 0}, "max_turns must be an integer from 1"),
        ({"max_turns": True}, "max_turns must be an integer from 1 to 1000000, got True"),
        ({"fewer": ["llf-*"]}, "fewer must be a table of tables"),
        ({"fewer": {"llf-poem-*": {}}}, r'fewer\."llf-poem-\*" matches none of the ids'),
        ({"fewer": {"*": {"turns": 3}}}, r'fewer\."\*": unknown key \'turns\''),
        ({"fewer": {"*": {"seeds": [0, 99]}}}, r"seeds must be among the study's, got \[99\]"),
        ({"fewer": {"*": {"teachers": ["orakle"]}}}, "teachers: unknown personality 'orakle'"),
    ],
)
def test_a_bad_study_is_refused(changes, match):
    with pytest.raises(ValueError, match=match):
        small(**changes)


def test_fewer_episodes_where_a_pattern_fits():
    study = small(fewer={"llf-grid*": {"teachers": ["oracle"], "seeds": 1}})
    slow = [spec for spec in study.episodes() if spec.id == "llf-gridworld-v0"]
    assert {(spec.teacher, spec.seed) for spec in slow} == {("oracle", 0)}
    assert {spec.student for spec in slow} == set(study.students)
    rest = [spec for spec in small().episodes() if spec.id != "llf-gridworld-v0"]
    assert [spec for spec in study.episodes() if spec.id != "llf-gridworld-v0"] == rest
    assert Study(**study.as_dict()) == study


def test_one_error_lists_everything():
    with pytest.raises(ValueError, match=r"teachers: .*students: "):
        small(teachers=["x"], students=["y"])


@pytest.mark.parametrize(
    ("text", "match"),
    [
        ("ids = [", "study.toml: "),
        ("nonsense = 1", "unknown key 'nonsense'.*ids is missing; teachers is missing"),
        (FILE + "sedes = 3", "unknown key 'sedes'; did you mean seeds"),
        (FILE.replace("silent", "silend"), "study.toml: teachers: unknown personality 'silend'; did you mean silent"),
    ],
)
def test_a_bad_file_is_refused(tmp_path, text, match):
    path = tmp_path / "study.toml"
    path.write_text(text)
    with pytest.raises(ValueError, match=match):
        load_study(path)


OTHER_BYTES = {
    "utf-16": (FILE.encode("utf-16"), "line 1 has bytes that are not UTF-8; save the file as UTF-8"),
    "latin-1": (f"{FILE}\n# Schüler".encode("latin-1"), "line 8 has bytes that are not UTF-8; save the file as UTF-8"),
    "a key twice": (
        f"{FILE}seeds = 3".encode(),
        r"Cannot overwrite a value \(at .*; give each key once, and each table",
    ),
    "a table twice": (
        f"{FILE}\n[names]\n[names]".encode(),
        r"Cannot declare \('names',\) twice \(at line 9,.*; give each",
    ),
    "brackets": (
        b"seeds = " + b"[" * 100_000,
        "too many lists or tables in each other; write lists and tables less deep",
    ),
    "digits": (b"seeds = " + b"9" * 5_000, "Exceeds the limit"),
}


@pytest.mark.parametrize(("data", "match"), OTHER_BYTES.values(), ids=OTHER_BYTES)
@pytest.mark.parametrize("read", [load_study, read_toml])
def test_a_file_that_cannot_be_read_is_named_with_line_and_remedy(tmp_path, data, match, read):
    path = tmp_path / "study.toml"
    path.write_bytes(data)
    with pytest.raises(ValueError, match=rf"study\.toml: {match}"):
        read(path)


def test_a_file_may_begin_with_a_byte_order_mark(tmp_path):
    path = tmp_path / "study.toml"
    path.write_bytes(FILE.encode("utf-8-sig"))
    assert load_study(path).ids


@pytest.mark.parametrize("workers", [0, -1, 5000, True])
def test_a_number_of_workers_that_cannot_be_is_refused(tmp_path, workers):
    with (
        Store(tmp_path / "s.db") as store,
        pytest.raises(ValueError, match="workers must be an integer from 1 to 4096"),
    ):
        play_missing(small(), store, workers)


def test_what_a_store_cannot_hold_is_refused_and_the_rest_stays(tmp_path):
    record = play(next(small().episodes()))
    with Store(tmp_path / "s.db") as store:
        store.add(record)
        with pytest.raises(StoreError, match=r"s\.db holds integers below 2\*\*63, got a greater one"):
            store.add(record._replace(spec=record.spec._replace(seed=2**63)))
        assert store.count == 1
        assert not list(store.damage())


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(ValueError, match=r"none\.toml: .*No such file"):
        load_study(tmp_path / "none.toml")


def test_what_is_stored_is_what_was_played(tmp_path):
    study = small()
    with Store(tmp_path / "s.db") as store:
        seen = []
        assert play_missing(study, store, workers=2, progress=lambda done, total: seen.append((done, total))) == 16
        assert seen[0] == (0, 16)
        assert seen[-1] == (16, 16)
        assert play_missing(study, store) == 0
        for spec in study.episodes():
            record = play(spec)
            (row,) = store.episodes({spec.key})
            assert tuple(row)[1:] == (*spec, *record.episode, 1)
            turns = list(store.turns(spec.key))
            assert [turn["turn"] for turn in turns] == list(range(record.episode.turns + 1))
            assert [turn["feedback"] for turn in turns] == [turn.feedback for turn in record.turns]
            assert store.regrets(spec.key) == [turn.regret for turn in record.turns[1:]]
        assert store.manifest()["study"] == study.as_dict()
        assert "numpy" in manifest(study)["versions"]


def test_claims_are_checked(tmp_path):
    with Store(tmp_path / "s.db") as store:
        play_missing(small(teachers=["oracle", "mistake(eps=1)", "silent"], seeds=3), store, workers=1)
        held = {}
        for row in store.episodes():
            said, true = held.get(row["teacher"], (0, 0))
            held[row["teacher"]] = said + row["claims"], true + row["claims_held"]
    assert held["oracle"][0] == held["oracle"][1] > 0
    assert held["mistake(eps=1)"][0] > 0 == held["mistake(eps=1)"][1]
    assert held["silent"] == (0, 0)


def test_a_larger_study_goes_on_in_the_same_store(tmp_path):
    with Store(tmp_path / "s.db") as store:
        assert play_missing(small(seeds=1), store, workers=1) == 8
        assert play_missing(small(seeds=2), store, workers=1) == 8


def test_a_failing_episode_says_which(tmp_path, monkeypatch):
    spec = next(small().episodes())._replace(teacher="nobody")
    monkeypatch.setattr(Study, "episodes", lambda self: iter([spec]))
    with (
        Store(tmp_path / "s.db") as store,
        pytest.raises(RuntimeError, match=r"'teacher': 'nobody'.*unknown personality"),
    ):
        play_missing(small(), store, workers=1)
