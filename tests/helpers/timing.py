"""How time grows, by ratios within one run."""

import time

TRIES = 5
SHORT, LONG = 8_000, 64_000
_LEAST = 0.002  # seconds; below it, clocks and collections of garbage are all that is measured


def grows_linearly(call):
    """Whether what is called with 64,000 takes about eight times as long as with 8,000; 64 times would be quadratic.

    Something else may interrupt a process, so that one of some tries is enough.
    """

    def seconds(size):
        before = time.process_time()
        call(size)
        return time.process_time() - before

    return any(seconds(LONG) < 24 * max(seconds(SHORT), _LEAST) for _ in range(TRIES))
