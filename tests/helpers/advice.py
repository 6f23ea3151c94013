"""Scripted models for what improves prompts: a student that does as it is advised, and who advises it from feedback."""

import re

BANDIT = "llf-bandits-BanditTwoArmedHighLowFixed-v0"
"""The arms' order is drawn at reset, so that one seed is one problem."""


def advised(advice):
    """The answer of a student that pulls the arm that its advice names, else arm 1."""
    named = re.findall(r"pull arm (\d)", advice)
    return f"Response: {named[-1] if named else 1}"


def advice_from(reflected):
    """Advice of who reads which rewards were told: the arm that was named and not pulled, or else one that paid."""
    turns = re.findall(r"Student: (\d)\. Reward: (\S+)\. ", reflected)
    good = [arm for arm, reward in turns if float(reward) > 0.5]
    told = set(re.findall(r"(?i)arm (\d)", " ".join(re.findall(r"Teacher: (.*)", reflected))))
    other = sorted(told - {arm for arm, _ in turns})
    return f"pull arm {(other or good)[0]}"
