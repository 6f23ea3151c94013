"""Meta-World: a robot's hand over a table, with 50 tasks."""

from pz_envs.family import Family
from pz_envs.learning import Smooth

_TASKS = """
    assembly basketball bin-picking box-close button-press button-press-topdown button-press-topdown-wall
    button-press-wall coffee-button coffee-pull coffee-push dial-turn disassemble door-close door-lock door-open
    door-unlock drawer-close drawer-open faucet-close faucet-open hammer hand-insert handle-press handle-press-side
    handle-pull handle-pull-side lever-pull peg-insert-side peg-unplug-side pick-out-of-hole pick-place pick-place-wall
    plate-slide plate-slide-back plate-slide-back-side plate-slide-side push push-back push-wall reach reach-wall
    shelf-place soccer stick-pull stick-push sweep sweep-into window-close window-open
"""

FAMILY = Family(
    name="metaworld",
    summary="move a robot's hand by target poses",
    world="MetaWorld",
    oracle="MetaWorldOracle",
    picture="MetaWorldPicture",
    environments={f"metaworld-{task}-v3": {"task": f"{task}-v3"} for task in _TASKS.split()},
    showcase=("metaworld-reach-v3", "metaworld-drawer-open-v3", "metaworld-pick-place-v3"),
    visual=True,
    aliases={f"metaworld-{task}-v2": f"metaworld-{task}-v3" for task in _TASKS.split()},
    alias_warning="the tasks are those of Meta-World v3, whose rewards differ from v2's",
    max_turns=30,
    python_below=(3, 14),  # metaworld pins mujoco 3.3.0
    slow=True,
    sampled=tuple(f"metaworld-{task}-v3" for task in ("door-lock", "drawer-open", "pick-place", "reach", "stick-push")),
    rules=2,
    regret_unit="metres off the advised target",
    learning=Smooth(size=0.03),
)
env, raw_env, parallel_env = FAMILY.env, FAMILY.raw_env, FAMILY.parallel_env
