"""How a study is played: runner, executors, limits, and what plays an episode in a worker."""
