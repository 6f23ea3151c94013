"""Environments with state outside of their attributes: a teacher that plans never changes its student's world."""

import contextvars
import os
import sys
import warnings
from dataclasses import replace
from types import ModuleType

import gymnasium
import pytest

import llf_teacher
from pz_envs.lesson import SharedStateWarning
from teachers.planning import Exact, Expert, PlanningError
from teachers.planning.planner import RewardsOnlyWarning
from teachers.reward_oracle import RewardOracle
from worlds.wrapped.generators import parts
from worlds.wrapped.shared import SharedState

_ROW = """
import datetime, functools, itertools, os, random, sys, threading, time, types, weakref, contextvars, tempfile
from time import perf_counter
import gymnasium
import numpy as np

class Row(gymnasium.Env):
    observation_space, action_space = gymnasium.spaces.Discrete(6), gymnasium.spaces.Discrete(2)
    def __init__(self):
        self.first()
    def first(self):
        pass
    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.put(0)
        return self.get(), {}
    def step(self, action):
        self.put(min(max(self.get() + 2 * int(action) - 1, 0), 5))
        return self.get(), self.pay(), self.get() == 5, False, {}
    def pay(self):
        return float(self.get() == 5)
"""
_ATTRIBUTE = """
    def get(self): return self.at
    def put(self, at): self.at = at
"""
_OWN = "class Own(Row):" + _ATTRIBUTE

SHARED = {
    "a closure among attributes": """
class Own(Row):
    def first(self):
        box = [0]
        self.get, self.put = lambda: box[0], lambda at: box.__setitem__(0, at)
""",
    "a closure that rebinds": """
class Own(Row):
    def first(self):
        at = 0
        def put(new):
            nonlocal at
            at = new
        self.get, self.put = lambda: at, put
""",
    "a closure of the class": """
def make():
    at = 0
    class Own(Row):
        def get(self): return at
        def put(self, new):
            nonlocal at
            at = new
    return Own
Own = make()
""",
    "a decorated method": """
def counted(method):
    box = [0]
    @functools.wraps(method)
    def inner(self, *given):
        box[0] += 1
        return method(self, *given) + (box[0] > 30)
    return inner
class Own(Row):"""
    + _ATTRIBUTE
    + """
    @counted
    def pay(self): return float(self.at == 5)
""",
    "a global": """
at = 0
class Own(Row):
    def get(self): return at
    def put(self, new):
        global at
        at = new
""",
    "a global made by a step": """
class Own(Row):
    def get(self): return globals().get("late", 0)
    def put(self, new):
        global late
        late = new
""",
    "a global list": """
BOX = [0]
class Own(Row):
    def get(self): return BOX[0]
    def put(self, new): BOX[0] = new
""",
    "a global object": """
SIM = types.SimpleNamespace(at=0)
class Own(Row):
    def get(self): return SIM.at
    def put(self, new): SIM.at = new
""",
    "a global by identity": """
ALL = {}
class Own(Row):
    def get(self): return ALL.get(id(self), 0)
    def put(self, new): ALL[id(self)] = new
""",
    "a global that a helper names": """
BOX = [0]
def read(): return BOX[0]
def write(new): BOX[0] = new
class Own(Row):
    def get(self): return read()
    def put(self, new): write(new)
""",
    "a global that a held object names": """
BOX = [0]
class Sim:
    def read(self): return BOX[0]
    def write(self, new): BOX[0] = new
class Own(Row):
    def first(self): self.sim = Sim()
    def get(self): return self.sim.read()
    def put(self, new): self.sim.write(new)
""",
    "an attribute of another class": """
class Config: at = 0
class Own(Row):
    def get(self): return Config.at
    def put(self, new): Config.at = new
""",
    "an attribute of a module": """
class Own(Row):
    def get(self): return getattr(sys, "row_at", 0)
    def put(self, new): sys.row_at = new
""",
    "an attribute of a function": """
def helper(): pass
helper.at = 0
class Own(Row):
    def get(self): return helper.at
    def put(self, new): helper.at = new
""",
    "an attribute of a method": """
class Own(Row):
    def get(self): return Own.put.at
    def put(self, new): Own.put.at = new
Own.put.at = 0
""",
    "a mutable default": """
class Own(Row):
    def box(self, box=[0]): return box
    def get(self): return self.box()[0]
    def put(self, new): self.box()[0] = new
""",
    "a mutable default by keyword": """
class Own(Row):
    def box(self, *, box={"at": 0}): return box
    def get(self): return self.box()["at"]
    def put(self, new): self.box()["at"] = new
""",
    "a list of the class": """
class Own(Row):
    box = [0]
    def get(self): return self.box[0]
    def put(self, new): self.box[0] = new
""",
    "an array of the class": """
class Own(Row):
    box = np.zeros(1)
    def get(self): return int(self.box[0])
    def put(self, new): self.box[0] = new
""",
    "a number of the class": """
class Own(Row):
    at = 0
    def get(self): return type(self).at
    def put(self, new): type(self).at = new
""",
    "a number of a base": """
class Base(Row): at = 0
class Own(Base):
    def get(self): return Base.at
    def put(self, new): Base.at = new
""",
    "a simulator of the class": """
class Sim: at = 0
class Own(Row):
    sim = Sim()
    def get(self): return self.sim.at
    def put(self, new): self.sim.at = new
""",
    "metadata": """
class Own(Row):
    metadata = {"render_modes": []}
    def get(self): return self.metadata.get("at", 0)
    def put(self, new): self.metadata["at"] = new
""",
    "metadata of all": """
class Own(Row):
    def get(self): return self.metadata.get("row at", 0)
    def put(self, new): self.metadata["row at"] = new
""",
    "os.environ": """
class Own(Row):
    def get(self): return int(os.environ.get("ROW_AT", 0))
    def put(self, new): os.environ["ROW_AT"] = str(new)
""",
    "a context variable": """
AT = contextvars.ContextVar("at", default=0)
class Own(Row):
    def get(self): return AT.get()
    def put(self, new): AT.set(new)
""",
    "a variable of the thread": """
LOCAL = threading.local()
LOCAL.at = 0
class Own(Row):
    def get(self): return LOCAL.at
    def put(self, new): LOCAL.at = new
""",
    "a cached list": """
@functools.lru_cache
def box(): return [0]
class Own(Row):
    def get(self): return box()[0]
    def put(self, new): box()[0] = new
""",
    "a wall clock": _OWN
    + """
    def pay(self): return float(time.time_ns() // 1000 % 2)
""",
    "an imported clock": _OWN
    + """
    def pay(self): return float(int(perf_counter() * 1e6) % 2)
""",
    "a date": _OWN
    + """
    def pay(self): return float(datetime.datetime.now().microsecond % 2)
""",
    "a clock in a helper": """
def late(begun): return time.monotonic() - begun > 3600
class Own(Row):"""
    + _ATTRIBUTE
    + """
    def first(self): self.begun = 0.0
    def pay(self): return float(self.at == 5) * (1 + late(self.begun))
""",
    "an iterator of the class": _OWN
    + """
    turns = itertools.count()
    def pay(self): return float(next(self.turns) % 5 == 0)
""",
    "a global iterator": "TURNS = itertools.cycle([0, 0, 0, 1])"
    + _OWN.replace("class", "\nclass")
    + """
    def pay(self): return float(next(TURNS))
""",
    "a generator in a closure": """
def counting():
    n = 0
    while True:
        yield n
        n += 1
TURNS = counting()"""
    + "\n"
    + _OWN
    + """
    def pay(self): return float(next(TURNS) % 5 == 0)
""",
    "a global generator of random numbers": "LUCK = np.random.default_rng(0)\n"
    + _OWN
    + """
    def pay(self): return float(LUCK.random() < 0.5)
""",
    "the generator of all": _OWN
    + """
    def pay(self): return float(np.random.random() < 0.5)
""",
    "a copy that shares a part": """
class Own(Row):
    def first(self): self.box = [0]
    def get(self): return self.box[0]
    def put(self, new): self.box[0] = new
    def __deepcopy__(self, memo):
        other = type(self)()
        other.__dict__.update(self.__dict__)
        return other
""",
    "a part whose copy is itself": """
class Sim:
    at = 0
    def __deepcopy__(self, memo): return self
class Own(Row):
    def first(self): self.sim = Sim()
    def get(self): return self.sim.at
    def put(self, new): self.sim.at = new
""",
    "a copy that omits an attribute": """
class Own(Row):
    def first(self): self.bonus, self.at = 1.0, 0
    def get(self): return self.at
    def put(self, new): self.at = new
    def pay(self): return self.bonus * (self.at == 5)
    def __deepcopy__(self, memo):
        other = type(self).__new__(type(self))
        other.__dict__.update({name: each for name, each in self.__dict__.items() if name != "bonus"})
        return other
""",
    "a weak reference": """
class Own(Row):
    def first(self): self.me, self.at = weakref.ref(self), 0
    def get(self): return self.me().at
    def put(self, new): self.me().at = new
""",
    "a file": """
PATH = tempfile.mkstemp()[1]
class Own(Row):
    def get(self):
        with open(PATH) as file: return int(file.read() or 0)
    def put(self, new):
        with open(PATH, "w") as file: file.write(str(new))
""",
    "a count of all steps": "STEPS = [0]\n"
    + _OWN
    + """
    def pay(self):
        STEPS[0] += 1
        return float(self.at == 5) if STEPS[0] < 25 else -1.0
""",
    "a wrapper's class": _OWN
    + """
class Counts(gymnasium.Wrapper):
    steps = 0
    def step(self, action):
        Counts.steps += 1
        seen, reward, *more = self.env.step(action)
        return seen, reward + (Counts.steps > 20), *more
Inner = Own
def Own(): return Counts(Inner())
""",
}
"""Sources of environments `Own` that share state with their copies, or do not repeat."""

KEPT = {
    "an attribute": _OWN,
    "a list": """
class Own(Row):
    def first(self): self.box = [0]
    def get(self): return self.box[0]
    def put(self, new): self.box[0] = new
""",
    "constants": """
PAID = {5: 1.0}
class Own(Row):
    moves, metadata = [-1, 1], {"render_modes": ["ansi"], "fps": 4}
    def get(self): return self.at
    def put(self, at): self.at = at
    def pay(self, bonus=(0.0,)): return PAID.get(self.at, 0.0) + bonus[0]
""",
    "a decorated method": """
def logged(method):
    @functools.wraps(method)
    def inner(self, *given): return method(self, *given)
    return inner
class Own(Row):"""
    + _ATTRIBUTE
    + """
    @logged
    def pay(self): return float(self.at == 5)
""",
    "a held object": """
class Sim:
    at = 0
class Own(Row):
    def first(self): self.sim = Sim()
    def get(self): return self.sim.at
    def put(self, new): self.sim.at = new
""",
    "a clock that only draws": _OWN
    + """
    def render(self): return time.time()
""",
}
"""Sources of environments that keep their state in attributes."""


@pytest.fixture(autouse=True)
def _no_rows():
    yield
    sys.modules.pop("rows", None)


def built(source):
    """The environment of a source, in a module of its own, so that nothing is left of other tests."""
    module = sys.modules["rows"] = ModuleType("rows")
    exec(_ROW + source, vars(module))
    return module.Own


def play(env, seeds=(0, 1, 2)):
    """What a student sees and is paid."""
    trace = []
    for seed in seeds:
        trace.append(int(env.reset(seed=seed)[0]["observation"]))
        for action in (1, 0, 0, 1, 1, 1, 0, 1, 1, 1, 1):
            seen, reward, terminated, truncated, _ = env.step(action)
            trace.append((int(seen["observation"]), reward, terminated))
            if terminated or truncated:
                break
    return trace


CHANCE = (
    "clock",
    "date",
    "generator",
    "iterator",
)  # of these two plays differ by themselves, or there is none to begin


@pytest.mark.parametrize("given", ["environment", "function"])
@pytest.mark.parametrize("name", SHARED)
def test_a_teacher_that_plans_leaves_its_students_world_alone(name, given, monkeypatch):
    """It states rewards only, for a reason, and all happens as without it."""
    monkeypatch.setattr(gymnasium.Env, "metadata", {"render_modes": []})
    monkeypatch.setattr(os, "environ", os.environ.copy())
    traces = []
    for oracle in (None, "auto", Expert(lambda seen, info: 1)):
        make = built(SHARED[name])
        env = make() if given == "environment" else make
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", RewardsOnlyWarning)
                seat = llf_teacher.teach(env, oracle=oracle, max_turns=12)
        except PlanningError:
            assert isinstance(oracle, Expert)
            continue
        if oracle == "auto":
            assert seat.family.planned.tier == "rewards", seat.family.planned
        elif oracle and (name, given) != ("a copy that omits an attribute", "function"):  # which needs no copies
            pytest.fail(f"an expert is followed: {seat.family.planned.why}")
        traces.append(play(seat))
    assert traces[0] == traces[1] or any(word in name for word in CHANCE)


@pytest.mark.parametrize("name", KEPT)
def test_state_in_attributes_is_planned_for(name):
    for given in (built(KEPT[name]), built(KEPT[name])()):
        seat = llf_teacher.teach(given, oracle=Exact(state=lambda env: env.unwrapped.get()), max_turns=12)
        assert play(seat) == play(llf_teacher.teach(built(KEPT[name]), max_turns=12))


SEEN = Exact(state=lambda env: env.unwrapped.at)


class Counts(gymnasium.Env):
    """Counts what is done to it, and to its action space."""

    observation_space = gymnasium.spaces.Discrete(6)

    def __init__(self):
        self.done = {"reset": 0, "step": 0}
        self.action_space = gymnasium.spaces.Discrete(2, seed=7)

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.done["reset"] += 1
        self.at = 0
        return 0, {}

    def step(self, action):
        self.done["step"] += 1
        self.at = min(max(self.at + 2 * int(action) - 1, 0), 5)
        return self.at, float(self.at == 5), self.at == 5, False, {}


@pytest.mark.parametrize("snapshot", ["copy", "replay"])
@pytest.mark.parametrize("oracle", [None, SEEN, replace(SEEN, gamma=0.9), Expert(lambda seen, info: 1)])
def test_the_teacher_never_steps_resets_or_seeds_the_environment_of_its_student(oracle, snapshot):
    made = []

    def make():
        made.append(Counts())
        return made[-1]

    for given in (Counts(), make):
        state = str(Counts().action_space.np_random.bit_generator.state)
        seat = llf_teacher.teach(given, oracle=oracle, max_turns=9, snapshot=snapshot)
        env = seat.session.world.env
        done = dict.fromkeys(env.done, 0)
        assert env.done == done
        for seed in range(3):
            seat.reset(seed=seed)
            done["reset"] += 1
            over = False
            while not over:
                *_, terminated, truncated, _ = seat.step(int(env.np_random.integers(2)))
                over = terminated or truncated
                done["step"] += 1
                assert env.done == done
        assert str(env.action_space.np_random.bit_generator.state) == state


def test_a_function_that_makes_no_new_environment_is_refused():
    env = Counts()
    with pytest.raises(ValueError, match=r"the function must make a new environment each time, got <Counts.* twice"):
        llf_teacher.teach(lambda: env, oracle="auto")
    assert env.done == {"reset": 0, "step": 0}


def test_environments_of_one_function_that_share_a_part_are_found_out():
    source = """
class Own(Row):
    def __init__(self, box): self.box = box
    def get(self): return self.box[0]
    def put(self, new): self.box[0] = new
"""
    cls, box = built(source), [0]
    with pytest.raises(PlanningError, match="a step changes an object of class list, which copies"):
        llf_teacher.teach(lambda: cls(box), oracle="exact")
    assert box == [0]


def test_what_was_changed_is_set_back():
    source = """
BOX = {"at": [0]}
class Own(Row):
    total, luck = 0, np.random.default_rng(3)
    def get(self): return BOX["at"][0]
    def put(self, new):
        BOX["at"][0] = new
        Own.total += 1
        Own.luck.random()
        os.environ["ROW_SET_BACK"] = "1"
"""
    env = built(source)()
    shared = SharedState(env)
    assert not shared.changed()
    before = str(type(env).luck.bit_generator.state)
    env.reset(seed=0)
    env.step(1)
    assert shared.changed()
    shared.restore()
    assert not shared.changed()
    assert (env.get(), type(env).total, str(type(env).luck.bit_generator.state)) == (0, 0, before)
    assert "ROW_SET_BACK" not in os.environ


class Restores(RewardOracle):
    """An oracle of a user's own, which may step copies."""

    needs_truth = True


def test_a_users_own_oracle_in_a_shared_world_is_warned_of():
    made = built(TURNED + COUNTED["a callable object of the class"])
    with pytest.warns(SharedStateWarning, match="a step changes the class attribute Own.count.*needs_truth = False"):
        llf_teacher.teach(made(), Restores)
    assert made.count() == 1, "what was tried is set back"
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        llf_teacher.teach(built(_OWN)(), Restores)
        llf_teacher.teach(made())


COUNTED = {  # where a counter of all steps may be, which reset leaves as it is; `first` sets it to 0
    "a name of the class that is computed": """
    def count(self):
        setattr(type(self), "now", vars(type(self)).get("now", 0) + 1)
        return type(self).now
""",
    "an attribute of the metaclass": """
    def count(self):
        meta = type(type(self))
        meta.now = getattr(meta, "now", 0) + 1
        return meta.now
""",
    "a name of the module that is computed": """
    def count(self):
        space = globals()
        space["now"] = space.get("now", 0) + 1
        return space["now"]
""",
    "a callable object of the class": """
    class Call:
        now = 0
        def __call__(self):
            self.now += 1
            return self.now
    count = Call()
""",
    "a descriptor": """
    class Field:
        now = 0
        def __get__(self, env, cls=None):
            self.now += 1
            return self.now
    field = Field()
    def count(self): return self.field
""",
    "slots of an object that copies itself as itself": """
    class Box:
        __slots__ = ("now",)
        def __deepcopy__(self, memo): return self
    def first(self):
        self.box = self.Box()
        self.box.now = 0
    def count(self):
        self.box.now += 1
        return self.box.now
""",
    "a number of C": """
    total = ctypes.c_int(0)
    def count(self):
        self.total.value += 1
        return self.total.value
""",
    "an array of Python": """
    total = array.array("i", [0])
    def count(self):
        self.total[0] += 1
        return self.total[0]
""",
    "a file of NumPy": """
    def count(self):
        now = int(np.load("now.npy")) + 1 if os.path.exists("now.npy") else 1
        np.save("now.npy", now)
        return now
""",
    "the number of files in a folder": """
    def count(self):
        now = len(os.listdir("."))
        os.mkdir(str(now))
        return now
""",
}
TURNED = """
class Meta(type(gymnasium.Env)):
    pass
class Own(Row, metaclass=Meta):
    def get(self): return self.at
    def put(self, at): self.at = at
    def step(self, action):
        return super().step(int(action) ^ (self.count() % 3 == 0))
"""


@pytest.mark.parametrize("name", COUNTED)
def test_counters_that_copies_share_are_set_back(name, monkeypatch, tmp_path):
    """The world, whose action is turned round at each third step of all environments, is as without a teacher."""
    traces = []
    for oracle in (None, "auto"):
        (folder := tmp_path / f"{oracle}").mkdir()
        monkeypatch.chdir(folder)
        env = built("import array, ctypes" + TURNED + COUNTED[name])()
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RewardsOnlyWarning)
            seat = llf_teacher.teach(env, oracle=oracle, max_turns=12)
        assert oracle is None or seat.family.planned.tier == "rewards"
        traces.append(play(seat))
    assert traces[0] == traces[1]


FLIPS = """
BOX = {"flipped": False}
class Own(Row):
    def get(self): return self.at
    def put(self, at): self.at = at
    def step(self, action):
        return super().step(int(action) ^ globals()["BOX"]["flipped"])
"""
"""Its code names a global in a way that is not found out."""


@pytest.mark.parametrize("text", [False, True])
@pytest.mark.parametrize("oracle", ["exact", "exact(gamma=0.9)", Expert(lambda seen, info: 1)])
def test_a_proof_against_the_plan_ends_it(oracle, text):
    """In the middle of an episode left and right are exchanged: from then on the teacher states rewards only."""
    cls = built(FLIPS)
    seat = llf_teacher.teach(cls, oracle=oracle, max_turns=12, text=text, snapshot="replay")
    said = [atom.claim for atom in seat.reset(seed=0)[1]["atoms"]]
    assert any(hasattr(claim, "action") for claim in said)
    seat.step("1" if text else 1)
    cls.get.__globals__["BOX"]["flipped"] = True
    with pytest.warns(
        UserWarning, match=r"no values any more: action 1 in turn 2|nor any later: the episode cannot be"
    ):
        *_, info = seat.step("1" if text else 1)
    assert [type(atom.claim).__name__ for atom in info["atoms"]] == ["Reward"]
    for seed in (0, 1):
        said = [*seat.reset(seed=seed)[1]["atoms"], *seat.step("1" if text else 1)[-1]["atoms"]]
        assert not any(hasattr(atom.claim, "action") for atom in said), said


class Slotted:
    __slots__ = ("slot",)


class Shadowing(Slotted):
    """Like some classes of asynchronous frameworks: the slot of its base is empty, and an attribute has its name."""

    slot = 3


def test_an_empty_slot_behind_an_attribute_of_its_name_holds_nothing():
    assert 3 not in [*parts(Shadowing())]
    context = contextvars.ContextVar("context")
    context.set(Shadowing())
    env = gymnasium.make("FrozenLake-v1", is_slippery=False)
    assert not SharedState(env, []).changed()
