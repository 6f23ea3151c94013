"""Bandits as LLF-Bench has them: the instruction begins with the problem's name and known facts."""

from types import MappingProxyType

from llf_teacher.compat.env import LLFEnv

_KNOWN = MappingProxyType(
    {
        "TenArmedGaussian": "10 arms that always pay, around means drawn from N(0, 1), with a standard deviation of 1",
        "TenArmedRandomFixed": "10 arms that pay 1 or nothing, each with a chance drawn at random",
        "TenArmedRandomRandom": "10 arms, each with a chance to pay and a payout drawn at random",
        "TenArmedUniformDistributedReward": "10 arms that always pay, each a payout drawn uniformly from 0 to 1",
        "TwoArmedDeterministicFixed": "2 arms, of which one always pays and the other never does",
        "TwoArmedHighHighFixed": "2 arms that pay 1 or nothing, with chances of 0.8 and 0.9 in an unknown order",
        "TwoArmedHighLowFixed": "2 arms that pay 1 or nothing, with chances of 0.8 and 0.2 in an unknown order",
        "TwoArmedLowLowFixed": "2 arms that pay 1 or nothing, with chances of 0.1 and 0.2 in an unknown order",
    }
)


class Surface(LLFEnv):
    """The instruction names the problem."""

    def _instruct(self, instruction: str) -> str:
        problem = self._world.options["problem"]
        return f"Bandit{problem}: {_KNOWN[problem]}.\n{instruction}"
