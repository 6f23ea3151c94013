"""Playing an episode to its end, or on into the next one."""


def episode(env, act, seed=0):
    """What each step of an episode gives; `act` is the action, or makes it of observation and info."""
    observation, info = env.reset(seed=seed)
    over = False
    while not over:
        outcome = env.step(act(observation, info) if callable(act) else act)
        yield outcome
        observation, _, terminated, truncated, info = outcome
        over = terminated or truncated


def agents(env, act, seed=0):
    """Each agent of a PettingZoo environment as its turn comes, whether it is over for it, and what `last` gives.

    Then it acts: by what `act` makes of agent and observation, or by None if it is over.
    """
    env.reset(seed=seed)
    for agent in env.agent_iter():
        observation, reward, terminated, truncated, info = env.last()
        over = terminated or truncated
        yield agent, over, observation, reward, info
        env.step(None if over else act(agent, observation))


def earned(env, act, seed=0):
    """The sum of the rewards of an episode."""
    return sum(reward for _, reward, *_ in episode(env, act, seed))


def steps(env, actions):
    """What the actions give, in as many episodes as it takes: where one ends, the next one begins."""
    for action in actions:
        outcome = env.step(action)
        yield outcome
        if outcome[2] or outcome[3]:
            env.reset()


class Fixed:
    """A policy that always does, or says, the same."""

    def __init__(self, action):
        self.action = action

    def reset(self, rng):
        """Nothing to forget."""

    def act(self, observation, info):
        return self.action


class Counting:
    """A teacher who counts the turns."""

    def reset(self, rng):
        self.turns = 0

    def act(self, observation, info):
        self.turns += 1
        return f"That makes {self.turns}."
