"""Laws of one's own: one way to register them, and never an older law's numbers."""

import json
import pickle
import re
import subprocess
import sys
import textwrap
from pathlib import Path

import equinox as eqx
import jax
import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import quad

import jaxbuffer as jb
from jaxbuffer.contact import LAWS, ContactLaw
from jaxbuffer.contact.laws import ChosenLaw, Hertz, HuntCrossley
from jaxbuffer.contact.laws.base import power, root
from jaxbuffer.contact.laws.registry import _all
from jaxbuffer.mechanisms.probe_cone import comparison
from jaxbuffer.mechanisms.probe_cone.assembly import tip_on_flanks
from jaxbuffer.mechanisms.probe_cone.comparison import compare_laws
from jaxbuffer.programs.identity import skeleton


def law(factor):
    """A Hertz contact stiffer by ``factor``."""

    class Stiffer(ContactLaw):
        stiffness: float

        def elastic(self, penetration):
            return factor * self.stiffness * power(penetration, 1.5)

        def energy(self, penetration):
            return 0.4 * self.elastic(penetration) * penetration

        def depth(self, force):
            return root(force / (factor * self.stiffness), 1.5)

        def force(self, penetration, approach_speed, touchdown_speed):
            return self.elastic(penetration)

        def time_scale(self, mass, speed):
            return (mass**2 / (speed * (factor * self.stiffness) ** 2)) ** 0.2

    return Stiffer


@pytest.fixture
def register():
    """`register_law`, undone afterwards."""
    before = dict(_all)
    yield jb.register_law
    _all.clear()
    _all.update(before)


DURATION = 2e-4  # s, some way into the first impact


def force(design, **options):
    """The contact force's largest value [N] within `DURATION`, the first impact's peak."""
    return float(jb.simulate(design, duration=DURATION, **({"solver": "explicit"} | options)).peak_force)


def as_stiff_as(factor):
    """The same by the built-in law."""
    stiffness = factor * float(jb.table2().contact_stiffness)
    return force(jb.replace(jb.table2(), {"contact.law": "hertz", "contact.stiffness": stiffness}))


@pytest.mark.long
def test_a_design_has_the_law_that_its_name_stood_for(register):
    with pytest.raises(jb.InputError, match=r"contact\.law = 'mine' is unknown"):
        jb.replace(jb.table2(), {"contact.law": "mine"})
    register("mine", law(1.0))
    before = jb.replace(jb.table2(), {"contact.law": "mine"})
    assert_allclose(force(before), as_stiff_as(1.0), rtol=1e-6)
    register("mine", law(4.0))
    design = jb.replace(jb.table2(), {"contact.law": "mine"})
    for one, factor in ((design, 4.0), (before, 1.0)):
        assert_allclose(force(one), as_stiff_as(factor), rtol=1e-6)
        found = jb.sweep(one, jb.Scenario(), DURATION, solver="explicit")
        assert_allclose(found.peak_force, as_stiff_as(factor), rtol=1e-6)


class Unnamed(Hertz):
    """A law in a module, which a pickle finds there."""


def test_a_design_takes_a_law_without_a_name(register):
    design = jb.replace(jb.table2(), {"contact.law": Unnamed})
    assert design.contact.law == "Unnamed" and isinstance(tip_on_flanks(design).law, Unnamed)
    assert pickle.loads(pickle.dumps(design)).contact.law is design.contact.law
    register("mine", Unnamed)
    assert repr(jb.replace(jb.table2(), {"contact.law": Unnamed}).contact.law) == "'mine'"


def test_laws_of_one_name_are_two_keys(register):
    register("mine", law(1.0))
    one = jb.replace(jb.table2(), {"contact.law": "mine"})
    register("mine", law(1.0))
    other = jb.replace(one, {"contact.law": "mine"})
    assert jax.tree.structure(one) != jax.tree.structure(other)
    assert jb.replace(one, {"contact.friction": 0.1}).contact.law is one.contact.law
    for design in (one, other):
        assert design.contact.law == "mine" and json.dumps(design.contact.law) == '"mine"'
    again = pickle.loads(pickle.dumps(one)).contact.law
    assert again is other.contact.law, "a law made in a function goes to another process by its name"


def test_a_law_is_read_by_its_name_in_a_stored_program():
    structure = jax.tree.structure(jb.replace(jb.table2(), {"contact.law": "hertz"}))
    assert jax.tree.structure(pickle.loads(pickle.dumps(skeleton(structure)))) == structure
    assert ChosenLaw("hertz") is ChosenLaw("hertz", Hertz)


@pytest.mark.slow
def test_the_comparison_has_registered_laws(register, monkeypatch):
    for name in ("ASKED", "CURVE"):
        monkeypatch.setattr(comparison, name, (0.9,))
    register("mine", law(4.0))
    found = {compared.name: compared.impact for compared in compare_laws(jb.table2(), mass=1.0, speed=0.1).laws}
    assert list(found) == list(LAWS) and "mine" in found
    assert_allclose(found["mine"].peak_force / found["hertz"].peak_force, 4.0**0.4, rtol=1e-5)  # F ∝ K^{2/5}


class NoDefault(Hertz):
    looseness: float


class NoForce(ContactLaw):
    stiffness: float


class Unrelated(eqx.Module):
    pass


@pytest.mark.parametrize(
    ("name", "given", "message"),
    [
        ("hertz", HuntCrossley, "law name 'hertz' is a built-in law's; choose another"),
        ("a law", Hertz, "law name 'a law': use letters, digits, - and _"),
        ("", Hertz, "law name '': use letters"),
        (3, Hertz, "law name 3: use letters"),
        ("mine", Unrelated, "law 'mine': .*Unrelated.* is not a subclass of jaxbuffer.contact.ContactLaw"),
        ("mine", "hertz", "law 'mine': 'hertz' is not a subclass"),
        ("mine", NoForce, "law 'mine': NoForce lacks elastic, energy, force, time_scale"),
        ("mine", NoDefault, "law 'mine': field looseness of NoDefault has no default and is none of .*restitution"),
    ],
)
def test_what_is_no_law_is_refused(register, name, given, message):
    with pytest.raises(jb.InputError, match=message):
        register(name, given)
    assert "mine" not in LAWS


def test_laws_are_not_registered_by_assignment():
    with pytest.raises(TypeError):
        LAWS["mine"] = Hertz


PROGRAM = """
    import jaxbuffer as jb
    jb.configure(cache={cache!r})
    from jaxbuffer.contact.laws import Hertz
    from jaxbuffer.contact.laws.base import power

    FACTOR = {factor}
    class Mine(Hertz):
        def elastic(self, penetration):
            return FACTOR * self.stiffness * power(penetration, 1.5)

    jb.register_law("mine", Mine)
    from jaxbuffer.programs.cache import watched
    compiled = []
    with watched(compiled.append):
        design = jb.replace(jb.table2(), {{"contact.law": "mine"}})
        print(float(jb.simulate(design, duration=2e-4, solver="explicit").peak_force))
    print(any(compiled))
"""


@pytest.mark.long
def test_a_law_redefined_in_another_process_is_another_program(tmp_path):
    """A program of a law of the user's is kept by no process for another."""

    def run(factor):
        program = textwrap.dedent(PROGRAM.format(cache=str(tmp_path / "cache"), factor=factor))
        done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True, timeout=300)
        force, compiled = done.stdout.split()
        return float(force), compiled

    assert_allclose(run(1.0)[0], as_stiff_as(1.0), rtol=1e-6)
    force, compiled = run(4.0)
    assert compiled == "True"
    assert_allclose(force, as_stiff_as(4.0), rtol=1e-6)
    assert np.isfinite(force) and not list((tmp_path / "cache").glob("*.program"))


def test_the_law_in_the_documentation_stores_what_it_exerts(register):
    text = (Path(__file__).parents[2] / "docs" / "laws.md").read_text()
    code = re.search(r"```python\n(.*)\nprint\(.*?```", text, re.DOTALL)[1]
    exec(code, {})
    law = LAWS["square"](stiffness=1e9)
    for depth in (1e-6, 1e-4, 1e-2):
        assert_allclose(law.energy(depth), quad(law.elastic, 0.0, depth, epsabs=0.0)[0], rtol=1e-7)
        assert_allclose(law.depth(law.elastic(depth)), depth, rtol=1e-12)
    assert float(law.elastic(-1e-6)) == float(law.energy(-1e-6)) == 0.0
