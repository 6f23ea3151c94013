"""A model of 512 numbers learns what a teacher's words mean; `docs/train-a-model.md` has the code, too.

`python examples/train_a_model.py --plot docs/train-a-model.png` draws the curve of its page.
"""

import re
import zlib

import numpy as np

from llf_teacher import rollout

WAYS, UPDATES, BATCH = ("north", "east", "south", "west"), 20, 32
rng, weights, curve = np.random.default_rng(0), np.zeros(512), []


def read(messages: list[dict[str, str]]) -> tuple[np.ndarray, np.ndarray]:
    """Counts of the words beside each way, by their hashes, and how likely each way is."""
    words = re.findall(r"\w+", messages[-1]["content"].lower())
    beside = np.zeros((len(WAYS), len(weights)))
    for before, word, after in zip(words, words[1:], words[2:], strict=False):
        if word in WAYS:
            beside[WAYS.index(word), [zlib.crc32(each.encode()) % len(weights) for each in (before, after)]] += 1
    scores = np.exp(beside @ weights)
    return beside, scores / scores.sum()


def policy(conversations: list[list[dict[str, str]]]) -> list[str]:
    """An answer to each conversation."""
    return [str(rng.choice(WAYS, p=read(messages)[1])) for messages in conversations]


for update in range(UPDATES):
    seeds = range(BATCH * update, BATCH * (update + 1))
    played = rollout(policy, "llf-gridworld-v0", seeds, feedback_type="fp", max_turns=8)
    turns = [turn for conversation in played for turn in conversation.turns]
    lost = [turn.regret for turn in turns]
    for turn, regret in zip(turns, lost, strict=True):
        beside, likely = read(turn.prompt)
        weights += 0.01 * (np.mean(lost) - regret) * (beside[WAYS.index(turn.answer)] - likely @ beside)
    curve.append(sum(conversation.success for conversation in played) / BATCH)

print("success:", " ".join(f"{share:.2f}" for share in curve))
if __name__ == "__main__":
    import argparse

    import matplotlib.pyplot as plt

    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--plot", help="file for the curve")
    if plot := parser.parse_args().plot:
        figure, axes = plt.subplots(figsize=(6, 3), layout="constrained")
        axes.plot(range(1, UPDATES + 1), curve, marker=".")
        axes.set(xlabel=f"updates, each by {BATCH} conversations", ylabel="reward (treasure found)", ylim=(0, 1.02))
        axes.locator_params(axis="x", integer=True)
        figure.savefig(plot, dpi=100)
