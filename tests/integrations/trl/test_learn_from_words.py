"""A tiny model of random weights learns from words by TRL, is killed in an update, and goes on with the same result."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
import torch

ROOT = Path(__file__).parents[3]
sys.path.insert(0, f"{ROOT / 'examples'}")
import learn_from_words as program  # noqa: E402
from word_signals import Rows, Town  # noqa: E402
from word_training import Learner  # noqa: E402

from llf_teacher.studies.store.store_lock import lock_store  # noqa: E402

SMALL = ("--updates", "2", "--format", "1", "--steps", "16", "--worlds", "4", "--elsewhere", "0", "--seeds", "1")


def command(out, model, *more):
    return [sys.executable, f"{ROOT / 'examples/learn_from_words.py'}", "--out", f"{out}", "--model", f"{model}", *more]


def run(out, model, *more):
    """What the program prints."""
    done = subprocess.run(command(out, model, *more), cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


def rows_of(out, name):
    """The rows of a run without what depends on the machine's speed."""
    rows = Rows(out / name / "rows.jsonl").read()
    return [{key: value for key, value in row.items() if key not in ("seconds", "cpu")} for row in rows]


def test_every_signal_trains_and_the_table_is_of_the_stored_rows(tmp_path, folder):
    out = tmp_path / "out"
    printed = run(out, folder, *SMALL, "--signals", *"abcdefg")
    assert "7 runs: about" in printed
    table = [line for line in printed.splitlines() if " | " in line]
    assert [line.split(" | ")[0][:3] for line in table[2:10]] == ["bef", *(f"({name})" for name in "abcdefg")]
    assert run(out, folder, "--table").splitlines()[-1] == printed.splitlines()[-1]
    assert [line for line in run(out, folder, "--table").splitlines() if " | " in line] == table
    updates = {name: [row for row in rows_of(out, f"{name}-0") if row["kind"] == "update"] for name in "abcdefg"}
    assert all([row["steps"] for row in rows] == [16, 16] for rows in updates.values()), "equal environment steps"
    assert all(row["loss"] > 0 and row["examples"] == 16 for name in "bef" for row in updates[name])
    assert (out / "curve.png").stat().st_size > 5_000


def test_what_is_imitated_is_learned(folder):
    """By the weights alone: the answers of words to new houses become those that were shown."""
    learner = Learner(f"{folder}")
    learner.begin(0)
    learner.set_rate(1e-2)
    town = Town("gridworld", 0)
    looks = town.judge(town.seeds(0, 32), ["Response: west"] * 32)
    shown = [{"prompt": look.prompt, "completion": [{"role": "assistant", "content": look.answer}]} for look in looks]
    losses = [learner.learn("sft", shown, number).loss for number in range(8)]
    assert losses[-1] < losses[0] / 3
    new = town.judge(town.seeds(1000, 4), [""] * 4)
    assert [each.split() for each in learner.answer([look.prompt for look in new], 4, sample=False)] == [
        ["Response", ":", "west"]
    ] * 4


@pytest.mark.parametrize("letter", ["a", "b"])
def test_killed_in_an_update_it_goes_on_with_the_same_result(tmp_path, folder, letter):
    whole, cut = tmp_path / "whole", tmp_path / "cut"
    small = (*SMALL, "--updates", "4", "--signals", letter)
    run(whole, folder, *small)
    begun = subprocess.Popen(command(cut, folder, *small), cwd=ROOT, stdout=subprocess.DEVNULL)
    while not [*cut.glob(f"{letter}-0/checkpoint-0000[1-3]")]:
        assert begun.poll() is None, "it ended before it could be killed"
        time.sleep(0.01)
    os.kill(begun.pid, signal.SIGKILL)
    begun.wait()
    assert rows_of(cut, f"{letter}-0")[-1]["kind"] != "end"
    run(cut, folder, *small)
    assert rows_of(cut, f"{letter}-0") == rows_of(whole, f"{letter}-0")
    ended = [torch.load(out / f"{letter}-0/checkpoint-00004/adapter.pt") for out in (cut, whole)]
    assert all(torch.equal(value, ended[1][name]) for name, value in ended[0].items())


def test_a_run_of_another_command_is_left_to_it(tmp_path, folder):
    small = (*SMALL, "--signals", "b", "f")
    with lock_store(tmp_path / "b-0"):
        assert "(b) seed 0 is being run by another command" in run(tmp_path, folder, *small)
    assert not (tmp_path / "b-0").exists()
    assert "(b) imitate the advised action | 1" in run(tmp_path, folder, *small)


def test_bad_input_ends_with_one_message_and_keeps_the_checkpoint(tmp_path, folder, monkeypatch):
    base = (*SMALL, "--signals", "b")

    def refused(*more):
        done = subprocess.run(command(*more), cwd=ROOT, capture_output=True, text=True, check=False)
        assert done.returncode == 1
        return done.stderr.strip().splitlines()

    (message,) = refused(tmp_path / "long", folder, *base, "--max-prompt", "20")
    assert "a prompt must have at most 20 tokens, got" in message
    bare = tmp_path / "bare"
    bare.mkdir()
    for path in folder.iterdir():
        if path.name != "chat_template.jinja":
            (bare / path.name).write_bytes(path.read_bytes())
    settings = json.loads((bare / "tokenizer_config.json").read_text())
    settings.pop("chat_template", None)
    (bare / "tokenizer_config.json").write_text(json.dumps(settings))
    (message,) = refused(tmp_path / "no", bare, *base)
    assert "must have a chat template" in message
    (message,) = refused(tmp_path / "none", "no-such-model", *base)
    assert "no-such-model" in message


def small_run(out, folder):
    settings = {"family": "gridworld", "updates": 2, "format": 0, "steps": 16, "worlds": 4, "elsewhere": 0}
    return program.Run(out, "b", 0, {**settings, "rates": {"b": 1e-3}}), Learner(f"{folder}")


def test_a_loss_that_is_not_finite_keeps_the_last_checkpoint(tmp_path, folder, monkeypatch):
    run, learner = small_run(tmp_path, folder)
    learn, calls = learner.learn, []

    def spoil(*given):
        calls.append(given)
        if len(calls) == 2:
            for name, value in learner.model.named_parameters():
                if value.requires_grad and "lora_B" in name:
                    value.data.fill_(float("nan"))
        return learn(*given)

    monkeypatch.setattr(learner, "learn", spoil)
    with pytest.raises((FloatingPointError, RuntimeError), match="finite"):
        run.go(learner)
    assert [path.name for path in run.folder.glob("checkpoint-*")] == ["checkpoint-00001"]
    monkeypatch.undo()
    run.go(learner)
    assert run.done


def test_a_full_disk_keeps_the_last_checkpoint(tmp_path, folder, monkeypatch):
    run, learner = small_run(tmp_path, folder)
    save, saved = torch.save, []

    def full(value, path):
        saved.append(path)
        if len(saved) > 2:
            raise OSError(28, "No space left on device", f"{path}")
        save(value, path)

    monkeypatch.setattr(torch, "save", full)
    with pytest.raises(OSError, match="No space left"):
        run.go(learner)
    assert [path.name for path in run.folder.glob("checkpoint-*")] == ["checkpoint-00001"]
    monkeypatch.undo()
    run.go(learner)
    assert run.done
    assert sorted(path.name for path in run.folder.iterdir()) == ["checkpoint-00002", "rows.jsonl", "settings.json"]
