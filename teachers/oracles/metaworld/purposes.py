"""The purposes of Meta-World's tasks, in words."""

PURPOSES = {
    "assembly-v3": "pick up the wrench and put its ring over the peg",
    "basketball-v3": "put the ball into the basket",
    "bin-picking-v3": "take the block out of its bin and put it into the other bin",
    "box-close-v3": "pick up the lid and put it on the box",
    "button-press-topdown-v3": "press the button down from above",
    "button-press-topdown-wall-v3": "press the button down from above, past the wall",
    "button-press-v3": "push the button in from the front",
    "button-press-wall-v3": "push the button in from the front, past the wall",
    "coffee-button-v3": "push the button of the coffee machine",
    "coffee-pull-v3": "pull the mug away from the coffee machine to the goal",
    "coffee-push-v3": "push the mug under the coffee machine, to the goal",
    "dial-turn-v3": "turn the dial",
    "disassemble-v3": "lift the wrench off the peg",
    "door-close-v3": "close the door",
    "door-lock-v3": "lock the door by turning its bolt",
    "door-open-v3": "open the door",
    "door-unlock-v3": "unlock the door by turning its bolt",
    "drawer-close-v3": "push the drawer shut",
    "drawer-open-v3": "pull the drawer open",
    "faucet-close-v3": "turn the faucet's handle so that it closes",
    "faucet-open-v3": "turn the faucet's handle so that it opens",
    "hammer-v3": "pick up the hammer and drive the nail into the board",
    "hand-insert-v3": "put the block into the hole, hand and all",
    "handle-press-side-v3": "press the handle down, from its side",
    "handle-press-v3": "press the handle down",
    "handle-pull-side-v3": "pull the handle up, from its side",
    "handle-pull-v3": "pull the handle up",
    "lever-pull-v3": "pull the lever up",
    "peg-insert-side-v3": "pick up the peg and put it into the hole from the side",
    "peg-unplug-side-v3": "pull the peg out of the hole, sideways",
    "pick-out-of-hole-v3": "take the puck out of the hole and bring it to the goal",
    "pick-place-v3": "pick up the puck and bring it to the goal",
    "pick-place-wall-v3": "pick up the puck and bring it over the wall to the goal",
    "plate-slide-back-side-v3": "slide the plate out of the cabinet, sideways, to the goal",
    "plate-slide-back-v3": "slide the plate back out of the cabinet, to the goal",
    "plate-slide-side-v3": "slide the plate sideways into the cabinet",
    "plate-slide-v3": "slide the plate into the cabinet",
    "push-back-v3": "pull the puck back to the goal",
    "push-v3": "push the puck to the goal",
    "push-wall-v3": "push the puck around the wall to the goal",
    "reach-v3": "bring the hand to the goal",
    "reach-wall-v3": "bring the hand to the goal, past the wall",
    "shelf-place-v3": "pick up the block and put it on the shelf",
    "soccer-v3": "push the ball into the goal",
    "stick-pull-v3": "pick up the stick and pull the box to the goal with it",
    "stick-push-v3": "pick up the stick and push the box to the goal with it",
    "sweep-into-v3": "sweep the block into the hole in the table",
    "sweep-v3": "sweep the block off the table",
    "window-close-v3": "slide the window shut",
    "window-open-v3": "slide the window open",
}
"""The purpose of each task, to complete "your task is to ..."."""

USES = {
    "hold": "open the gripper until the hand is where it is to take hold, and close it there",
    "shut": "keep the gripper closed from the start on",
}
"""Uses of the gripper, as advice."""


def _tasks(names: str) -> frozenset[str]:
    return frozenset(f"{name}-v3" for name in names.split())


HOLDING = _tasks(
    "assembly basketball bin-picking box-close coffee-pull coffee-push disassemble hammer hand-insert "
    "handle-pull-side peg-insert-side pick-place pick-place-wall push push-back push-wall shelf-place "
    "stick-pull stick-push sweep"
)
"""Tasks where the gripper closes on the way."""
SHUT = _tasks(
    "button-press-topdown button-press-wall dial-turn door-close door-open door-unlock drawer-close "
    "faucet-close faucet-open handle-press-side handle-pull lever-pull plate-slide-back-side "
    "plate-slide-side soccer window-close window-open"
)
"""Tasks where the gripper is closed from the start."""
OPEN = _tasks(
    "button-press button-press-topdown-wall coffee-button door-lock drawer-open handle-press "
    "peg-unplug-side pick-out-of-hole plate-slide plate-slide-back reach reach-wall"
)
"""Tasks where the gripper never closes."""
