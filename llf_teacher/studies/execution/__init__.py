"""The execution of a study: runner, executors, limits, and the worker that plays an episode."""
