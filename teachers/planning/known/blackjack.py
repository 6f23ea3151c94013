"""Blackjack: transitions average over the dealer's hidden card and all later cards."""

from collections.abc import Iterator
from functools import cache
from typing import Any

import gymnasium

from teachers.planning.known import Known, State
from teachers.planning.transitions import Transition, Transitions

_State = tuple[int, int, int, bool]  # the player's sum, the dealer's open card, a usable ace, a natural
_CARDS = {card: (4 if card == 10 else 1) / 13 for card in range(1, 11)}  # drawn from an infinite deck
_STANDS = 17  # from this sum on the dealer draws no more


def _state(env: gymnasium.Env[Any, Any]) -> _State:
    """What the player sees; a natural is seen by the number of actions."""
    hand = env.unwrapped.player  # type: ignore[attr-defined]  # of Blackjack
    total, soft = sum(hand), 1 in hand and sum(hand) + 10 <= 21
    return int(total + 10 * soft), int(env.unwrapped.dealer[0]), int(soft), sorted(hand) == [1, 10]  # type: ignore[attr-defined]  # likewise


def _with(total: int, soft: bool, card: int) -> tuple[int, bool]:
    """The sum and whether an ace counts eleven, after one more card."""
    hard = total - 10 * soft + card
    ace = soft or card == 1
    return (hard + 10, True) if ace and hard + 10 <= 21 else (hard, False)


@cache
def _dealt(total: int, soft: bool) -> dict[int, float]:
    """The probabilities of the dealer's final sums; 0 stands for a sum above 21."""
    if total > 21:
        return {0: 1.0}
    if total >= _STANDS:
        return {total: 1.0}
    found: dict[int, float] = {}
    for card, chance in _CARDS.items():
        for last, share in _dealt(*_with(total, soft, card)).items():
            found[last] = found.get(last, 0.0) + chance * share
    return found


def _stick(state: _State, sab: bool, natural: bool) -> list[Transition]:
    """The transitions of sticking."""
    mine, dealer, _, lucky = state
    rewards: dict[float, float] = {}
    for hidden, chance in _CARDS.items():
        for last, share in _dealt(*_with(*_with(0, False, dealer), hidden)).items():
            reward = float(mine > last) - float(mine < last)
            if lucky and sab and {dealer, hidden} != {1, 10}:
                reward = 1.0
            elif lucky and natural and not sab and reward == 1:
                reward = 1.5
            rewards[reward] = rewards.get(reward, 0.0) + chance * share
    return [Transition(chance, None, reward) for reward, chance in rewards.items()]


def _hit(state: _State) -> list[Transition]:
    """The transitions of hitting."""
    total, dealer, soft, _ = state
    found = []
    for card, chance in _CARDS.items():
        after, ace = _with(total, bool(soft), card)
        found.append(
            Transition(chance, None, -1.0) if after > 21 else Transition(chance, (after, dealer, int(ace), False), 0.0)
        )
    return found


def _states() -> Iterator[_State]:
    for dealer in range(1, 11):
        yield from ((total, dealer, 0, False) for total in range(4, 22))
        yield from ((total, dealer, 1, False) for total in range(12, 22))
        yield 21, dealer, 1, True


def _table(env: gymnasium.Env[Any, Any]) -> tuple[Transitions, State, str]:
    rules: Any = env.unwrapped
    transitions: Transitions = {
        state: [_stick(state, bool(rules.sab), bool(rules.natural)), _hit(state)] for state in _states()
    }
    return transitions, _state, "a table by the rules of the game, over what the player sees"


def _describe(observation: tuple[int, int, int]) -> str:
    total, dealer, ace = map(int, observation)
    usable = ", with an ace that counts 11" if ace else ""
    return f"Your cards add up to {total}{usable}. The dealer shows {'an ace' if dealer == 1 else f'a {dealer}'}."


def _options(env: gymnasium.Env[Any, Any]) -> tuple[bool, bool]:
    rules: Any = env.unwrapped
    return bool(rules.natural), bool(rules.sab)


KNOWN = Known(action_words={"stick": 0, "hit": 1}, describe=_describe, table=_table, options=_options, hides=True)
