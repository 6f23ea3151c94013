"""A language model as the voice of a teacher, over a real client and a scripted endpoint."""

import pytest

import llf_teacher
from llf_teacher.models.settings import CACHE
from llf_teacher.models.testing import ScriptedEndpoint
from llf_teacher.speakers.rewriter import Rewriter


@pytest.fixture(autouse=True)
def clean(monkeypatch, tmp_path):
    for name in ("LLF_LLM_MODEL", "OPENAI_MODEL", "LLF_LLM_BASE_URL", "OPENAI_BASE_URL", "LLF_LLM_BUDGET"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv(CACHE, str(tmp_path / "cache.db"))


def test_a_model_words_what_the_teacher_says_and_its_slips_are_reported():
    def answer(request):
        return "Well, " + request["messages"][-1]["content"].replace("south", "down")

    with ScriptedEndpoint(answer) as server:
        voice = Rewriter("a pirate", model="m", base_url=server.url + "/")
        env = llf_teacher.make("llf-gridworld-v0", voice=voice, privileged_info=True)
        plain = llf_teacher.make("llf-gridworld-v0", privileged_info=True)
        changed = 0
        for seed in range(3):
            (said, info), (expected, truth) = env.reset(seed=seed), plain.reset(seed=seed)
            for action in (0, 1, 2, 3):
                assert [atom.claim for atom in info["atoms"]] == [atom.claim for atom in truth["atoms"]]
                assert all(atom.text.startswith("Well, ") for atom in info["atoms"] if atom.kind is not None)
                south = [atom.text for atom in truth["atoms"] if atom.kind is not None and "south" in atom.text]
                changes = info.get("changes", ())
                assert [change.before for change in changes] == south
                assert all(change.vanished == ("south",) for change in changes)
                changed += len(changes)
                (said, _, _, _, info), (expected, _, _, _, truth) = env.step(action), plain.step(action)
        assert changed > 3
        assert said["instruction"] == expected["instruction"]
        system = server.requests[0]["messages"][0]["content"]
        assert "as a pirate would" in system
        sentences = [request["messages"][1]["content"] for request in server.requests]
        assert len(sentences) == len(set(sentences))  # the cache knows the others


def test_without_privileges_the_student_does_not_hear_of_changes():
    env = llf_teacher.make("llf-gridworld-v0", voice=lambda sentence: "Hm.")
    assert "changes" not in env.reset(seed=0)[1]
    assert "changes" not in env.step(0)[4]
    assert env.teacher.changes


def test_a_model_is_needed():
    with pytest.raises(ValueError, match="model must be the name of a model, got ''; or set LLF_LLM_MODEL"):
        Rewriter()
