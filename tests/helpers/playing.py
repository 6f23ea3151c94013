"""Playing on, whether an episode lasts or not."""


def steps(env, actions):
    """What the actions give, in as many episodes as it takes: where one ends, the next one begins."""
    for action in actions:
        outcome = env.step(action)
        yield outcome
        if outcome[2] or outcome[3]:
            env.reset()


class Counting:
    """A teacher who counts the turns."""

    def reset(self, rng):
        self.turns = 0

    def act(self, observation, info):
        self.turns += 1
        return f"That makes {self.turns}."
