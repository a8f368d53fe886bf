"""Whose code a program is made from, and the hash of the user's source."""

import importlib
import itertools
import os
import subprocess
import sys
import textwrap

import diffrax
import equinox as eqx
import jax
import numpy as np
import optax
import pytest

import jaxbuffer as jb
from jaxbuffer.contact.laws import LAWS
from jaxbuffer.hybrid import DiagonallyImplicit, Options
from jaxbuffer.programs.identity import Description, code_hash, known, skeleton, user_code

SOURCE = """
    import functools, math
    import equinox as eqx
    import jax
    import jax.numpy as jnp
    import numpy as np
    import helpers_of_mine

    FACTOR = 2.0
    TABLE = np.array([1.0, 2.0])
    SETTINGS = {"scale": 3.0, "names": ("a", "b")}

    def helper(x):
        return x + 1.0

    def made(closed):
        def inner(x, y=4.0, *, z=5.0):
            return [x * closed * y * z for _ in range(2)]
        return inner

    closure = made(6.0)

    @jax.custom_jvp
    def ruled(x):
        return x

    @ruled.defjvp
    def _(primals, tangents):
        return primals[0], 7.0 * tangents[0]

    class Base(eqx.Module):
        size: float = 8.0
        kind: str = eqx.field(static=True, default="nine")

        def above(self, x):
            return jnp.sin(x) * FACTOR

    class Mine(Base):
        ATTRIBUTE = 10.0

        @property
        def doubled(self):
            return 2.0 * self.size

        @staticmethod
        def still(x):
            return x - 11.0

        def all(self, x):
            x = helper(x) + TABLE[0] + SETTINGS["scale"] + closure(x)[0] + ruled(x) + math.sin(x)
            return super().above(x) + functools.partial(helper)(x) + helpers_of_mine.CONSTANT

        def later(self):
            from helpers_of_mine import OTHER
            return OTHER
"""
HELPERS = "CONSTANT = 12.0\nOTHER = 13.0\nUNUSED = 14.0"


@pytest.fixture
def description(tmp_path, monkeypatch):
    """The hash of the class Mine in a file, imported anew, with a module of helpers; both with replacements."""
    number = itertools.count()

    def described(*replacements):
        texts = [textwrap.dedent(SOURCE), HELPERS]
        for old, new in replacements:
            assert sum(text.count(old) for text in texts) == 1
            texts = [text.replace(old, new) for text in texts]
        folder = tmp_path / str(next(number))
        folder.mkdir()
        names = ("law_of_mine", "helpers_of_mine")
        for name, text in zip(names, texts, strict=True):
            (folder / f"{name}.py").write_text(text)
            monkeypatch.delitem(sys.modules, name, raising=False)
        with monkeypatch.context() as patched:
            patched.syspath_prepend(folder)
            return code_hash(importlib.import_module(names[0]).Mine)

    return described


CHANGES = [
    ("FACTOR = 2.0", "FACTOR = 2.5"),
    ("[1.0, 2.0]", "[1.0, 2.5]"),
    ('"scale": 3.0', '"scale": 3'),
    ("return x + 1.0", "return x + 1"),
    ("y=4.0", "y=4.5"),
    ("z=5.0", "z=5.5"),
    ("made(6.0)", "made(6.5)"),
    ("7.0 * tangents", "7.5 * tangents"),
    ("size: float = 8.0", "size: float = 8.5"),
    ('default="nine"', 'default="ten"'),
    ("kind: str = eqx.field(static=True, default", "kind: str = eqx.field(default"),
    ("jnp.sin(x)", "jnp.cos(x)"),
    ("ATTRIBUTE = 10.0", "ATTRIBUTE = -10.0"),
    ("2.0 * self.size", "2.0 / self.size"),
    ("x - 11.0", "11.0 - x"),
    ("@staticmethod\n", "@classmethod\n"),
    ("range(2)", "range(3)"),
    ("CONSTANT = 12.0", "CONSTANT = 12.5"),
    ("OTHER = 13.0", "OTHER = 13.5"),
    ("class Mine(Base):", "class Mine(Base, strict=False):\n    other: float = 1.0\n"),
    ("class Base(eqx.Module):", "class Base(eqx.Module):\n    def __check_init__(self):\n        pass\n"),
]


@pytest.mark.parametrize("change", CHANGES, ids=lambda change: change[1][:24])
def test_a_change_that_can_be_seen_is_seen(description, change):
    assert description(change) != description()


def test_what_changes_nothing_changes_no_hash(description):
    """So that a script in which ``resume=True`` is added below a law goes on with what it has begun."""
    first = description()
    assert description() == first
    moved = ("import functools, math", "import functools, math\n\n# moved")
    added = ("        return OTHER\n", "        return OTHER\n\nprint('resume=True')\n")
    for change in (("UNUSED = 14.0", "UNUSED = 15.0"), moved, added):
        assert description(change) == first


TYPED = """
rate = {rate}
class Mine:
    def force(self, depth):
        return {factor} * depth + rate

    def __call__(self, depth):
        return self.force(depth) {sign} {factor}
"""


def typed(rate=1.0, factor=2.0, sign="+"):
    """A class as at a prompt, of which there is no file."""
    names = {"__name__": "__main__"}
    exec(TYPED.format(rate=rate, factor=factor, sign=sign), names)
    return names["Mine"]


def test_code_without_a_file_is_known_by_what_it_computes():
    assert code_hash(typed()) == code_hash(typed())
    every = [typed(), typed(rate=1.5), typed(factor=2.5), typed(factor=2), typed(sign="-")]
    assert len({code_hash(it) for it in every}) == len(every)


def test_functions_of_one_line_are_told_apart():
    pair = lambda factor: (lambda x: 2.0 * x, lambda x: 3.0 * x, lambda x: factor * x, lambda y: 2.0 * y)  # noqa: E731
    assert len({code_hash(it) for it in (*pair(1.0), pair(4.0)[2])}) == 5
    assert [code_hash(it) for it in pair(1.0)] == [code_hash(it) for it in pair(1.0)]


def test_a_global_that_is_set_anew_changes_the_functions_that_read_it():
    names = {"factor": 2.0}
    exec("def double(x): return factor * x\ndef plain(x): return x", names)
    before = code_hash(names["double"]), code_hash(names["plain"])
    names["factor"] = 3.0
    assert code_hash(names["double"]) != before[0] and code_hash(names["plain"]) == before[1]


def test_the_code_of_a_user_is_that_of_the_classes_in_a_tree_and_not_its_numbers():
    class Mine(eqx.Module):
        size: jax.Array | float
        kind: str = eqx.field(static=True, default="even")

    assert user_code(jb.table2(), {"a": 1.0}) == "" != user_code(Mine(1.0))
    assert user_code(jb.table2(), Mine(1.0)) == user_code(Mine(2.0))
    structure = jax.tree.structure([Mine(1.0), {"a": 2.0}, None])
    assert jax.tree.structure(skeleton(structure)) == structure


OF_A_PROCESS = """
import logging, threading, types
import equinox as eqx
import numpy as np
from scipy.interpolate import PchipInterpolator
from jaxbuffer.programs.identity import code_hash, user_code

class Part(eqx.Module):
    size: float
    names: frozenset = eqx.field(static=True, default=frozenset({"a", "b", "c"}))

    def __call__(self, x):
        return self.size * spline(x)

class Table:
    def __init__(self, factor):
        self.factor, self.lock, self.log = factor, threading.Lock(), logging.getLogger("mine")

    def __call__(self, x):
        return self.factor * x if x in {"a", "b", "c", "d"} else spline(x)

for last, factor in ((3.0, 2.0), (4.0, 2.0), (3.0, 2.5)):
    spline = PchipInterpolator([0.0, 1.0, 2.0], [0.0, 1.0, last])
    print(code_hash(Table(factor), {"b", "a", "c"}, object()))
print(user_code(Part(1.0)))
"""


@pytest.mark.slow
def test_every_process_has_the_same_hash_of_code_and_of_the_objects_that_it_reads(tmp_path):
    file = tmp_path / "process.py"
    file.write_text(OF_A_PROCESS)

    def printed(seed):
        environment = {**os.environ, "PYTHONHASHSEED": seed, "PYTHONPATH": os.pathsep.join(sys.path)}
        return subprocess.run(
            [sys.executable, str(file)], capture_output=True, text=True, check=True, env=environment
        ).stdout

    first = printed("1")
    assert first == printed("2")
    assert [len(told) for told in first.split()] == [16] * 4 and len(set(first.split())) == 4


WRAPPED = {
    "MultiSteps": lambda rate: optax.MultiSteps(optax.adam(rate), 4),
    "its transformation": lambda rate: optax.MultiSteps(optax.adam(rate), 4).gradient_transformation(),
    "of a schedule": lambda rate: optax.MultiSteps(optax.adam(optax.cosine_decay_schedule(rate, 10)), lambda step: 3),
    "number of steps": lambda rate: optax.MultiSteps(optax.adam(0.1), int(100 * rate)),
    "masked": lambda rate: optax.masked(optax.adam(rate), [True, False]),
    "hyperparameters": lambda rate: optax.inject_hyperparams(optax.adam)(learning_rate=rate),
    "partition": lambda rate: optax.partition({"a": optax.adam(rate), "b": optax.sgd(0.1)}, ["a", "b"]),
}


@pytest.mark.parametrize("wrapper", WRAPPED)
def test_a_rate_inside_a_wrapper_tells_optimizers_apart(wrapper):
    one, same, other = (code_hash(WRAPPED[wrapper](rate)) for rate in (0.1, 0.1, 0.2))
    assert one == same != other


def test_optimizers_that_differ_in_a_schedule_far_ahead_are_told_apart():
    def optimizers(factor, rate=0.1):
        return (
            optax.adam(optax.piecewise_constant_schedule(rate, {1000: factor})),
            optax.chain(optax.clip(1.0), optax.sgd(lambda count: rate / (1.0 + factor * count))),
            optax.inject_hyperparams(optax.adam)(learning_rate=rate * factor),
        )

    every = [*optimizers(0.5), *optimizers(0.6), optax.adam(0.1), optax.adam(0.2), optax.lbfgs(0.1)]
    assert len({code_hash(it) for it in every}) == len(every)
    assert [code_hash(it) for it in optimizers(0.5)] == [code_hash(it) for it in optimizers(0.5)]


@pytest.mark.parametrize(
    ("one", "other"),
    [(1, 1.0), (True, 1), ("1", 1), ((1, 2), [1, 2]), (0.0, -0.0), (np.zeros(2), np.zeros(2, int)), (None, "None")],
)
def test_values_are_told_apart(one, other):
    """Python or NumPy find them alike."""
    assert code_hash(one) != code_hash(other)


def test_the_packages_own_code_is_known_by_name_and_anything_else_is_not():
    assert all(map(known, (*LAWS.values(), jax.jit, np.sin, diffrax.Tsit5, eqx.Module, int, jb.simulate)))
    assert not known(type("Hertz", (), {"__module__": "jaxbuffer.contact.laws.hertzian"}))
    assert not known(test_values_are_told_apart)


def test_the_default_and_other_published_methods_are_the_packages():
    for options in (Options(), DiagonallyImplicit(diffrax.Kvaerno5()), jb.table2()):
        described = Description(options)
        assert not described.of_user and described.parts == Description(options).parts != Description(None).parts


@pytest.mark.parametrize("thing", [lambda: None, object(), type("Mine", (), {}), (1, [print, lambda: None])])
def test_code_of_the_users_is_told_from_that_of_packages(thing):
    assert Description(thing).of_user and not Description(object, print).of_user
