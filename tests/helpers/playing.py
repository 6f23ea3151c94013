"""Playing on, whether an episode lasts or not."""


def steps(env, actions):
    """What the actions give, in as many episodes as it takes: where one ends, the next one begins."""
    for action in actions:
        outcome = env.step(action)
        yield outcome
        if outcome[2] or outcome[3]:
            env.reset()
