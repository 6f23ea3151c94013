"""The deep student of the shelf: it learns from rewards, takes advice, and draws from its own stream alone."""

import numpy as np
import pytest
import torch
from learning import ARMS, GRID, HOUSE

import llf_teacher
from llf_teacher.students.parsing import parse_student


def lives(student, episodes, advice, seed=3):
    """Moves wasted in each episode in a house, with advice in each turn or none."""
    env = llf_teacher.TeacherEnv(
        GRID,
        student=student,
        episodes=episodes,
        max_turns=40,
        feedback_type="fp",
        teacher_reward="student_progress",
        cost=0.0,
        **HOUSE,
    )
    env.reset(seed=seed)
    wasted, done = [0.0], False
    while not done:
        _, reward, terminated, truncated, info = env.step(0b01000 if advice else 0)
        done = terminated or truncated
        wasted[-1] -= reward
        if info["moment"].turn == 0 and not done:
            wasted.append(0.0)
    return wasted


def test_it_learns_houses_from_rewards():
    learned, chance = (
        np.mean([lives(student, 60, advice=False, seed=seed)[-20:] for seed in range(4)])
        for student in ("dqn(forget=False, alpha=0.003, sync=50)", "random")
    )
    assert learned < 0.2 * chance


def test_it_does_what_it_is_advised_to():
    assert not any(lives("dqn(forget=False, trust=1.0)", 3, advice=True))
    assert any(lives("dqn(forget=False)", 3, advice=True))


def test_a_seed_is_a_lifetime_and_no_stream_is_shared():
    before = torch.get_rng_state(), np.random.get_state()[1].tolist()  # noqa: NPY002 (to see that nobody draws from it)
    first, again, other = (lives("dqn(forget=False)", 5, advice=False, seed=seed) for seed in (3, 3, 4))
    assert first == again != other
    after = torch.get_rng_state(), np.random.get_state()[1].tolist()  # noqa: NPY002 (as above)
    assert torch.equal(before[0], after[0])
    assert before[1] == after[1]


def test_its_values_become_what_is_paid():
    """Of arms that pay 0 or 1 by chance, without a future; of an arm that was pulled often enough."""
    env = llf_teacher.make(ARMS, teacher="silent", max_turns=600)
    policy = parse_student("dqn(forget=False, gamma=0.0, epsilon=1.0, alpha=0.003)").seat(env.family, env.session.world)
    env.reset(seed=1)
    policy.reset(np.random.default_rng(0))
    paid = [[] for _ in range(10)]
    for _ in range(600):
        action = policy.act(env.student_view.observe(), env.student_view.info_for(policy))
        _, reward, *_ = env.step(action)
        paid[action].append(reward)
    assert np.abs(np.array(policy.worth()) - [np.mean(each) for each in paid]).max() < 0.35


@pytest.mark.parametrize("id", ["llf-optimization-Booth-v0", "llf-poem-Haiku-v0"])
def test_it_refuses_what_is_no_choice(id):
    env = llf_teacher.make(id)
    with pytest.raises(ValueError, match="needs discrete actions"):
        parse_student("dqn").seat(env.family, env.session.world)
