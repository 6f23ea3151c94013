"""Data sets of Minari, from a study's store, loaded by Minari."""

import os

import numpy as np
import pytest

import llf_teacher
from llf_teacher.studies import Study, run
from llf_teacher.studies.export import write_export

minari = pytest.importorskip("minari", reason="Minari is not installed; it comes with the extra `data`")

STUDY = Study(
    ids=["llf-gridworld-v0", "llf-optimization-Booth-v0", "llf-poem-Haiku-v0"],
    teachers=["oracle"],
    students=["text_only", "random"],
    seeds=2,
    max_turns=4,
)
NAMES = {
    "llf-gridworld-v0": "llf/gridworld-oracle-b-a-4-{}-v0",
    "llf-optimization-Booth-v0": "llf/optimization_Booth-oracle-b-a-4-{}-v0",
    "llf-poem-Haiku-v0": "llf/poem_Haiku-oracle-b-a-4-{}-v0",
}


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    return run(STUDY, tmp_path_factory.mktemp("minari") / "s.db", workers=1)


@pytest.mark.parametrize("form", ["native", "text"])
def test_minari_loads_what_was_played(found, tmp_path, monkeypatch, form):
    assert write_export(found, tmp_path / "sets", f"minari(text={form == 'text'})") == 3
    monkeypatch.setenv("MINARI_DATASETS_PATH", f"{tmp_path / 'sets'}")
    assert set(minari.list_local_datasets()) == {name.format(form) for name in NAMES.values()}
    for id, name in NAMES.items():
        data = minari.load_dataset(name.format(form))
        played = [row for row in found.rows() if row["id"] == id]
        assert data.total_episodes == len(played) == 4
        assert data.total_steps == sum(row["turns"] for row in played)
        env = data.recover_environment()
        assert env.spec.id == id
        for episode, row in zip(data.iterate_episodes(), played, strict=True):
            turns = found.turns(row["key"])
            np.testing.assert_allclose(episode.rewards, [turn["reward"] for turn in turns[1:]])
            assert list(episode.observations["feedback"]) == [turn["feedback"] for turn in turns]
            assert episode.observations["instruction"][0] == turns[0]["instruction"]
            assert episode.terminations[-1] or episode.truncations[-1]
            first, _ = env.reset(seed=row["seed"])
            assert first["feedback"] == turns[0]["feedback"]
            for action, reward in zip(episode.actions, episode.rewards, strict=True):
                assert env.step(action)[1] == pytest.approx(reward)


def test_options_are_those_of_the_study(tmp_path, monkeypatch):
    """Of teachers only those who can be named are played again."""
    study = Study(
        ids=["llf-gridworld-v0"],
        teachers=["oracle", "oracle | voice(tone='curt')"],
        students=["random"],
        options={"llf-*": {"num_rooms": 6, "visual": True}},
        seeds=1,
        max_turns=2,
    )
    played = run(study, tmp_path / "s.db", workers=1)
    assert write_export(played, tmp_path / "sets", "minari") == 1
    monkeypatch.setenv("MINARI_DATASETS_PATH", f"{tmp_path / 'sets'}")
    (name,) = minari.list_local_datasets()
    assert name == "llf/gridworld-oracle-b-a-2-num_rooms_6_visual_true-native-v0"
    assert minari.load_dataset(name).recover_environment().unwrapped.session.world.options["num_rooms"] == 6


def test_an_episode_that_plays_otherwise_is_refused(found, tmp_path):
    class Dearer(type(found)):
        def turns(self, key):
            first, second, *rest = super().turns(key)
            return [first, {**second, "reward": second["reward"] - 1}, *rest]

    with pytest.raises(ValueError, match=r"the stored reward -1 in turn 1, got .* use the release that played it"):
        write_export(Dearer(found.path), tmp_path / "sets", "minari")
    assert "MINARI_DATASETS_PATH" not in os.environ


def test_a_data_set_is_played_with_its_teacher(found, tmp_path, monkeypatch):
    write_export(found, tmp_path / "sets", "minari(author='us')")
    monkeypatch.setenv("MINARI_DATASETS_PATH", f"{tmp_path / 'sets'}")
    data = minari.load_dataset(NAMES["llf-gridworld-v0"].format("native"))
    env = data.recover_environment().unwrapped
    made = llf_teacher.make("llf-gridworld-v0", max_turns=4).unwrapped
    assert (repr(env.teacher), env.session.max_turns) == (repr(made.teacher), 4)
    assert data.storage.metadata["author"] == {"us"} or data.storage.metadata["author"] == "us"
    assert data.storage.metadata["algorithm_name"] == "random, text_only"
