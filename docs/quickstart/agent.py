# ---
# jupytext:
#   text_representation:
#     format_name: percent
# ---

# %% [markdown]
# # An agent that is taught
#
# An agent is a function from messages to text, such as a call of a language model. Here it is a short function of Python, so that
# this page runs without a model and without a key: it guesses, and does what it is told if it finds a direction in what the
# teacher said last.
#
# Run it with `python docs/quickstart/agent.py`, or open it as a notebook, after
# `pip install -e ".[all,notebook]" -c constraints.txt`. It takes a few seconds.

# %%
import os
import random
import re
import tempfile
from pathlib import Path

import gymnasium

import llf_teacher
from llf_teacher.studies import Study, run

SEEDS = int(os.environ.get("LLF_QUICKSTART_SEEDS", "30"))  # the tests play fewer
DIRECTIONS = ("north", "east", "south", "west")


def agent(messages: list[dict[str, str]]) -> str:
    """Answers the last message, which has the teacher's words; put your model's call here."""
    last = messages[-1]["content"].lower()
    sentences = [each for each in re.split(r"[.!]\s", last) if " not " not in each]
    advised = re.findall(
        rf"(?:go|head|next move should be|take the way) ({'|'.join(DIRECTIONS)})",
        ". ".join(sentences),
    )
    guess = random.Random(last).choice(DIRECTIONS)
    return f"Thought: {'I was told.' if advised else 'I guess.'}\nResponse: {advised[-1] if advised else guess}"


# %% [markdown]
# ## One episode
#
# `text=True` makes an environment text in, text out. A `Conversation` keeps the instruction and the history, in the form that
# chat models take. Text that is no action costs a turn, is answered, and is never executed.

# %%
env = llf_teacher.make("llf-gridworld-v0", teacher="oracle", feedback_type="a", text=True)
talk = llf_teacher.Conversation(env)
observation, info = env.reset(seed=7)
print(observation["instruction"], "\n")
for turn in range(1, 6):
    answer = agent(talk.ask(observation))
    observation, reward, terminated, truncated, info = env.step(talk.answer(answer))
    print(f"{turn}. {answer.splitlines()[-1]}\n   {observation['feedback']}")
    if info["success"]:
        print("The treasure is found.")
        break

# %% [markdown]
# `feedback_type="a"` lets the teacher say all five kinds of feedback: the reward (`r`), praise and blame (`hp`, `hn`), advice and
# a warning (`fp`, `fn`). `"blame"` or `"hn"` would be blame alone, and `"n"` nothing.
#
# ## What is it worth to be told, and which words?
#
# `chat_student` makes a student of the function, and a study plays it beside a student that acts at random.

# %%
study = Study(
    ids=["llf-gridworld-v0"],
    teachers=["oracle", "mistake(eps=0.5)", "silent"],
    students=[llf_teacher.chat_student(agent), "random"],
    feedback_types=["fp", "hp+hn"],  # advice, or verdicts alone
    seeds=SEEDS,
)
results = run(study, Path(tempfile.mkdtemp()) / "study.db", workers=1)
episodes = results.episodes
found = episodes.assign(found=episodes.first_success.notna())
table = found.pivot_table(
    index=["student", "teacher"], columns="feedback_type", values="found"
).round(2)
print(table)

# %% [markdown]
# The table has the share of houses in which the treasure was found. The agent gains by advice, less by advice that is wrong every other
# time, and nothing by verdicts, since it does not look for them. A model may: that is what this is for.
#
# ## A teacher for your own environment
#
# `teach(env, oracle="auto")` gives any environment whose states can be enumerated a teacher that plans: FrozenLake, Taxi,
# CliffWalking, Blackjack, MiniGrid.

# %%
lake = llf_teacher.teach(
    gymnasium.make("FrozenLake-v1", is_slippery=False), oracle="auto", text=True
)
observation, info = lake.reset(seed=7)
for action in ("right", "down"):
    print("teacher:", observation["feedback"])
    print("agent:  ", action)
    observation, reward, terminated, truncated, info = lake.step(action)
print("teacher:", observation["feedback"])

# %% [markdown]
# ## With a language model
#
# Put the call of your model into `agent`, or name an OpenAI-compatible endpoint as the student
# `llm(model='...', base_url='...')`, with a cache, a spending limit and the cost in the report: [Language
# models](../language-models.md). Your own environment: [it gets a teacher by one line](../teach-your-own-environment.md).
# No result of a real language model is published here yet.
