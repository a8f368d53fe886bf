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
from jaxbuffer.programs.identity import NO_SOURCE, Description, known, source_hash

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
            return source_hash(importlib.import_module(names[0]).Mine)

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
    first = description()
    assert description() == first
    for change in (("UNUSED = 14.0", "UNUSED = 15.0"), ("import functools, math", "import functools, math\n\n# moved")):
        assert description(change) == first


def test_code_without_source_is_known_in_this_process_alone():
    def typed():
        names = {}
        exec("class Mine:\n    def force(self, depth):\n        return 2.0 * depth", names)
        return names["Mine"]

    one, other = typed(), typed()
    assert source_hash(one) == source_hash(one) != source_hash(other)
    assert source_hash(one).startswith(NO_SOURCE) and not source_hash(test_values_are_told_apart).startswith(NO_SOURCE)


OF_A_PROCESS = """
import logging, threading, types
import numpy as np
from scipy.interpolate import PchipInterpolator
from jaxbuffer.programs.identity import source_hash

class Table:
    def __init__(self, factor):
        self.factor, self.lock, self.log = factor, threading.Lock(), logging.getLogger("mine")

    def __call__(self, x):
        return self.factor * x if x in {"a", "b", "c", "d"} else spline(x)

for last, factor in ((3.0, 2.0), (4.0, 2.0), (3.0, 2.5)):
    spline = PchipInterpolator([0.0, 1.0, 2.0], [0.0, 1.0, last])
    print(source_hash(Table(factor), {"b", "a", "c"}, object()))
"""


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
    assert [len(told) for told in first.split()] == [16] * 3 and len(set(first.split())) == 3


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
    one, same, other = (source_hash(WRAPPED[wrapper](rate)) for rate in (0.1, 0.1, 0.2))
    assert one == same != other


def test_optimizers_that_differ_in_a_schedule_far_ahead_are_told_apart():
    def optimizers(factor, rate=0.1):
        return (
            optax.adam(optax.piecewise_constant_schedule(rate, {1000: factor})),
            optax.chain(optax.clip(1.0), optax.sgd(lambda count: rate / (1.0 + factor * count))),
            optax.inject_hyperparams(optax.adam)(learning_rate=rate * factor),
        )

    every = [*optimizers(0.5), *optimizers(0.6), optax.adam(0.1), optax.adam(0.2), optax.lbfgs(0.1)]
    assert len({source_hash(it) for it in every}) == len(every)
    assert [source_hash(it) for it in optimizers(0.5)] == [source_hash(it) for it in optimizers(0.5)]


@pytest.mark.parametrize(
    ("one", "other"),
    [(1, 1.0), (True, 1), ("1", 1), ((1, 2), [1, 2]), (0.0, -0.0), (np.zeros(2), np.zeros(2, int)), (None, "None")],
)
def test_values_are_told_apart(one, other):
    """Python or NumPy find them alike."""
    assert source_hash(one) != source_hash(other)


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
