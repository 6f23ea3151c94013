"""Students that learn from evaluation, on problems of their papers that are small enough to be solved."""

import itertools

import numpy as np
import pytest

import llf_teacher
from llf_teacher.students.evaluated import softmax
from llf_teacher.students.parsing import parse_student

ACTIONS, GAMMA = 4, 0.9
SMALL, LARGE, WALK = 0.3, 1.0, 3
"""A chain of three states. In the first, action 0 ends the episode and pays a little, action 1 goes on, and the others
end it and pay nothing; then every action goes on, and the last one pays more. So to go on is best if and only if a
reward two turns later counts more than 0.3 of one at once."""


def seat(student):
    env = llf_teacher.make("llf-gridworld-v0")  # for its four actions
    policy = parse_student(student).seat(env.family, env.session.world)
    policy.reset(np.random.default_rng(0))
    return policy


def paid(state, action):
    """The reward of an action, and whether the episode is over."""
    if state:
        return (LARGE if state == WALK - 1 else 0.0), state == WALK - 1
    return (SMALL if action == 0 else 0.0), action != 1


def experience(policy, played, late=0):
    """Turns of an episode: states, actions and labels, each heard as many turns late."""
    for turn, (state, action, _) in enumerate(played, 1):
        policy.steps.append(((state,), action))
        for due in range(1, turn):
            if late and due + late == turn and played[due - 1][2]:
                policy.hear(due, played[due - 1][2])
        policy.hear(turn, 0.0 if late else played[turn - 1][2])
    for due in range(max(1, len(played) + 1 - late), len(played) + 1):
        if late and played[due - 1][2]:
            policy.hear(due, played[due - 1][2])
    policy.end()


def trajectories():
    """All ways through the chain: states, actions and rewards."""
    for first in range(ACTIONS):
        for rest in itertools.product(range(ACTIONS), repeat=WALK - 1) if first == 1 else [()]:
            yield [(state, action, paid(state, action)[0]) for state, action in enumerate((first, *rest))]


def worth(preferences):
    """The expected discounted reward of a policy, by going through all trajectories."""
    total = 0.0
    for played in trajectories():
        chance = np.prod([softmax(preferences[state])[action] for state, action, _ in played])
        total += chance * sum(GAMMA**turn * reward for turn, (*_, reward) in enumerate(played))
    return total


@pytest.mark.parametrize("late", [0, 1, 2])
def test_the_mean_step_of_e_coach_is_the_gradient_of_the_return(late):
    """As its proof of convergence has it for feedback by rewards, whenever that comes; all trajectories are tried."""
    start = np.random.default_rng(0).normal(size=(WALK, ACTIONS))
    mean = np.zeros_like(start)
    for played in trajectories():
        policy = seat(f"coach(episodic=True, alpha=1.0, gamma={GAMMA})")
        for state in range(WALK):
            policy._preference.add((state,), start[state])
        experience(policy, played, late)
        chance = np.prod([softmax(start[state])[action] for state, action, _ in played])
        mean += chance * (np.array([policy._preference((state,)) for state in range(WALK)]) - start)
    slopes, tiny = np.zeros_like(start), 1e-6
    for at in np.ndindex(start.shape):
        step = np.zeros_like(start)
        step[at] = tiny
        slopes[at] = (worth(start + step) - worth(start - step)) / (2 * tiny)
    assert np.abs(slopes).max() > 0.05
    assert mean == pytest.approx(slopes, abs=1e-8)


def trained(student, label, episodes=3000):
    """The probability of each action by state, after episodes in the chain with labels."""
    policy = seat(student)
    rng = np.random.default_rng(1)
    for _ in range(episodes):
        policy.reset(rng)
        state, over = 0, False
        while not over:
            action = policy.choose((state,))
            policy.steps.append(((state,), action))
            _, over = paid(state, action)
            chances = np.array([softmax(policy._preference((each,))) for each in range(WALK)])
            policy.hear(len(policy.steps), label(chances, state, action))
            state += 1
        policy.end()
    return np.array([softmax(policy._preference((each,))) for each in range(WALK)])


def reward(chances, state, action):
    return paid(state, action)[0]


def advantage(chances, state, action):
    """How much more the action is worth than the policy."""
    value, q = 0.0, {}
    for at in reversed(range(state, WALK)):
        found = [paid(at, each) for each in range(ACTIONS)]
        q[at] = np.array([gain + (0.0 if over else GAMMA * value) for gain, over in found])
        value = float(chances[at] @ q[at])
    return float(q[state][action] - value)


def right(chances, state, action):
    return 1.0 if state or action == 1 else -1.0


@pytest.mark.parametrize("label", [reward, advantage, right])
def test_e_coach_finds_the_best_way_from_rewards_advantages_and_verdicts(label):
    """As proved by Shah et al. (2021)."""
    assert trained(f"coach(episodic=True, forget=False, gamma={GAMMA})", label)[0, 1] > 0.9


def test_coach_finds_the_best_way_from_advantages():
    """As MacGlashan et al. (2017) show, where the label is the advantage of the action."""
    assert trained("coach(forget=False, trace=0.0, alpha=1.0)", advantage)[0, 1] > 0.9


def test_from_rewards_the_trace_of_coach_is_its_discount():
    """It goes on if the reward two turns later, which the trace discounts, counts more: 0.9 ** 2 but not 0.3 ** 2."""
    assert trained("coach(forget=False, trace=0.9)", reward)[0, 1] > 0.9
    assert trained("coach(forget=False, trace=0.3)", reward)[0, 0] > 0.9


@pytest.mark.parametrize(
    "student", ["tamer", "advise", "sabl", "sabl(infers=True)", "coach", "coach(trace=0.0)", "coach(episodic=True)"]
)
@pytest.mark.parametrize("late", [1, 2])
def test_a_late_label_counts_as_one_in_time(student, late):
    """For its turn, and for what came before it, once; each state is seen once, so that nothing is learned between."""
    played = [("a", 0, 1.0), ("b", 1, -1.0), ("c", 2, 0.0), ("d", 3, 1.0), ("e", 0, -1.0)]
    known = []
    for delay in (0, late):
        policy = seat(student)
        experience(policy, played, delay)
        table = (
            getattr(policy, "_human", None) or getattr(policy, "_balance", None) or getattr(policy, "_preference", None)
        )
        known.append(np.array([table((state,)) if table else policy._heard[state] for state in "abcde"]))
    assert np.abs(known[0]).max() > 0.1
    assert known[1] == pytest.approx(known[0])


def test_a_trace_has_each_turn_once():
    """In an environment with a teacher that is two turns late, over a whole episode."""
    env = llf_teacher.make("llf-gridworld-v0", teacher="only(kinds='hp+hn') | delayed(turns=2)", max_turns=20)
    policy = parse_student("coach").seat(env.family, env.session.world)
    policy.reset(np.random.default_rng(0))
    _, info = env.reset(seed=3)
    over, heard = False, []
    hear = policy.hear
    policy.hear = lambda turn, label: (heard.append((turn, label)), hear(turn, label))
    while not over:
        *_, terminated, truncated, info = env.step(policy.act(env.student_view.observe(), info))
        over = terminated or truncated
    policy.act(env.student_view.observe(), info)
    turns = len(policy._gradients)
    assert turns == 20
    assert [turn for turn, label in heard if not label] == list(range(1, turns + 1))
    assert [turn for turn, label in heard if label] == list(range(1, turns - 1))


def test_tamer_predicts_the_mean_label():
    """A bandit whose trainer praises each action with a probability of its own."""
    praised = np.array([0.2, 0.9, 0.6, 0.4])
    policy, rng = seat("tamer(alpha=0.02)"), np.random.default_rng(0)
    for turn in range(1, 8001):
        action = int(rng.integers(ACTIONS))
        policy.steps.append((("here",), action))
        policy.hear(turn, 1.0 if rng.random() < praised[action] else -1.0)
    assert policy._human(("here",)) == pytest.approx(2 * praised - 1, abs=0.25)
    assert policy.choose(("here",)) == 1


def test_sabl_takes_the_action_that_is_most_probably_the_best():
    """A bandit: the posterior of the best action for a known strategy, by Bayes' rule over all four."""
    error, plus, minus = 0.1, 0.1, 0.8
    policy = seat(f"sabl(error={error}, plus={plus}, minus={minus})")
    heard = [(0, 0.0), (1, 0.0), (1, -1.0), (2, 0.0), (3, 1.0), (3, -1.0), (0, -1.0)]
    experience(policy, [("here", action, label) for action, label in heard])

    def chance(label, best):
        good = 1 - error if best else error  # that the trainer finds the action right
        if label > 0:
            return good * (1 - plus)
        return (1 - good) * (1 - minus) if label < 0 else good * plus + (1 - good) * minus

    posterior = np.array(
        [np.prod([chance(label, best == action) for action, label in heard]) for best in range(ACTIONS)]
    )
    posterior /= posterior.sum()
    row = policy._heard["here"][:, 0]
    assert softmax(row) == pytest.approx(posterior)
    assert policy.choose(("here",)) == np.argmax(posterior)


def test_i_sabl_infers_the_strategy_of_its_trainer():
    """A bandit of many states, each with its best action, and a trainer that is silent on most right actions."""
    policy, rng = seat("sabl(infers=True, error=0.01)"), np.random.default_rng(0)
    for turn in range(1, 1601):
        state, action = turn % 20, int(rng.integers(ACTIONS))
        good = action == state % ACTIONS
        silent = rng.random() < (0.85 if good else 0.15)
        policy.steps.append(((state,), action))
        policy.hear(turn, 0.0 if silent else 1.0 if good else -1.0)
    weights = policy.weights()
    assert [weights @ share for share in policy.strategies()] == pytest.approx([0.85, 0.15], abs=0.05)
    assert [policy.choose((state,)) for state in range(20)] == [state % ACTIONS for state in range(20)]


def test_advise_learns_the_values_of_a_chain():
    """Those that value iteration finds; without labels its policy is their softmax."""
    policy = seat(f"advise(gamma={GAMMA}, temperature=0.5)")
    for _, (state, action) in itertools.product(range(60), itertools.product(range(WALK), range(ACTIONS))):
        gain, over = paid(state, action)
        policy.steps = [((state,), action)]
        policy.learn({"reward": gain}, (state + 1,), over)
    solved = [[SMALL, GAMMA**2 * LARGE, 0.0, 0.0], [GAMMA * LARGE] * ACTIONS, [LARGE] * ACTIONS]
    assert np.array([policy._values((state,)) for state in range(WALK)]) == pytest.approx(np.array(solved), abs=1e-6)
    assert softmax(policy._scores((0,))) == pytest.approx(softmax(np.array(solved[0]) / 0.5), abs=1e-6)
