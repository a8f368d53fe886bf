"""What is said when a run can't be gone on with: what differs, and what to do."""

from pathlib import Path

import jax
import numpy as np
import pytest

import jaxbuffer as jb
from jaxbuffer.contact.laws import Hertz
from jaxbuffer.contact.laws.registry import _all
from jaxbuffer.mechanisms import registry
from jaxbuffer.tuning.problem.settings import Settings
from jaxbuffer.tuning.search.store import TuningStore
from jaxbuffer.tuning.tune import _identity, best_so_far

PAGE = Path(__file__).parents[2] / "docs" / "mechanisms.md"

REPEAT = "repeat the study and the options of the first run, or choose another --output"


def identity(high=2000.0, **settings):
    problem = jb.Problem(jb.table2(), [jb.Scenario()], [jb.Variable("buffer.k_A", 100.0, high)])
    return _identity(problem, Settings(**settings), None, None)


@pytest.mark.parametrize(
    ("asked", "parts"),
    [
        (
            {"seed": 2, "tolerance": 1e-3},
            ("settings: seed is 0 there, 2 here, tolerance is 0.0001 there, 0.001 here;",),
        ),
        ({"high": 3000.0}, ("settings: its study is another one (design, scenarios, [problem] or options);",)),
        ({"high": 3000.0, "starts": 8}, ("its study is another one", "starts is 32 there, 8 here")),
    ],
)
def test_another_tuning(tmp_path, asked, parts):
    with TuningStore(tmp_path, identity(), resume=False):
        pass
    with pytest.raises(jb.InputError) as caught:
        TuningStore(tmp_path, identity(**asked), resume=True)
    message = str(caught.value)
    assert message.endswith(REPEAT) and "Settings(" not in message
    assert all(part in message for part in parts)


def swept(speeds, folder, resume=False):
    return jb.sweep(jb.table2(), jb.Scenario(approach_speed=speeds), folder=folder, resume=resume)


def test_another_sweep(tmp_path, monkeypatch):
    monkeypatch.setattr("jaxbuffer.cluster.pool.Pool.completed", lambda *arguments: iter(()))
    swept([0.1, 0.2], tmp_path)
    with pytest.raises(jb.InputError, match=r"in scenarios; repeat the study, .* same --over .* another --output"):
        swept([0.1, 0.3], tmp_path, resume=True)


def pendulum(gravity, folder=None):
    """The mechanism of docs/mechanisms.md, its module run anew: from a file in a folder, or as if it were typed."""
    code = PAGE.read_text().split("```python")[1].split("```")[0].split("run = jb.simulate")[0]
    assert code.count("GRAVITY = 9.81") == 1
    code, names = code.replace("GRAVITY = 9.81", f"GRAVITY = {gravity}"), {"__name__": "mine"}
    if folder is not None:
        (folder / f"{gravity}.py").write_text(code)
    exec(compile(code, "<stdin>" if folder is None else folder / f"{gravity}.py", "exec"), names)
    return names["Pendulum"](), names["Release"]


@pytest.fixture
def registered():
    """What is registered meanwhile is forgotten."""
    kept = dict(registry._BY_DESIGN), dict(_all)
    yield
    for known, before in zip((registry._BY_DESIGN, _all), kept, strict=True):
        known.clear()
        known.update(before)


def test_a_mechanism_whose_code_has_changed_is_not_resumed(tmp_path, monkeypatch, registered):
    monkeypatch.setattr("jaxbuffer.cluster.pool.Pool.completed", lambda *arguments: iter(()))

    def sweep(gravity, folder, **options):
        design, release = pendulum(gravity, tmp_path)
        return jb.sweep(design, release(angle=[0.3, 0.4]), folder=tmp_path / folder, save=False, **options)

    def sample(gravity, folder, **options):
        design, release = pendulum(gravity, tmp_path)
        ranges = {"scenario.angle": (0.3, 0.4)}
        return jb.sample(design, release(), ranges, 2, folder=tmp_path / folder, save=False, **options)

    for make in (sweep, sample):
        make("9.81", make.__name__)
        make("9.81", make.__name__, resume=True)
        with pytest.raises(jb.InputError, match="differing in the code of your own that its runs use; repeat"):
            make("9.0", make.__name__, resume=True)


def test_a_tuning_of_a_mechanism_whose_code_has_changed_is_another_one(tmp_path, registered):
    def stated(gravity):
        design, release = pendulum(gravity, tmp_path)
        return jb.Problem(design, [release()], [jb.Variable("rod.mass", 0.1, 0.3)])

    with TuningStore(tmp_path, _identity(stated("9.81"), Settings(), None, None), resume=False):
        pass
    assert best_so_far(stated("9.81"), tmp_path) is None
    with pytest.raises(jb.InputError, match=": the code of its mechanism, laws or solver has changed; repeat"):
        best_so_far(stated("9.0"), tmp_path)


def test_code_that_was_typed_is_recognised_by_what_it_computes(tmp_path, registered):
    def stated(gravity):
        design, release = pendulum(gravity)
        return jb.Problem(design, [release()], [jb.Variable("rod.mass", 0.1, 0.3)])

    with TuningStore(tmp_path, _identity(stated("9.81"), Settings(), None, None), resume=False):
        pass
    assert best_so_far(stated("9.81"), tmp_path) is None
    with pytest.raises(jb.InputError, match="solver has changed; repeat"):
        best_so_far(stated("9.82"), tmp_path)


def test_laws_and_quantities_of_ones_own_whose_code_has_changed(tmp_path, monkeypatch, registered):
    monkeypatch.setattr("jaxbuffer.cluster.pool.Pool.completed", lambda *arguments: iter(()))

    def swept(factor, law, **options):
        class Mine(Hertz):
            def elastic(self, penetration):
                return factor * super().elastic(penetration)

        jb.register_law("mine", Mine)
        design = jb.replace(jb.table2(), {"contact.law": "mine"}) if law else jb.table2()
        over = {"scenario.approach_speed": [0.1, 0.2]} | ({} if law else {"contact.law": ["hertz", "mine"]})
        jb.sweep(design, jb.Scenario(), over=over, folder=tmp_path / str(law), save=False, **options)

    for law in (True, False):  # of the design, and among the values of a field
        swept(2.0, law)
        swept(2.0, law, resume=True)
        with pytest.raises(jb.InputError, match="differing in the code of your own"):
            swept(3.0, law, resume=True)

    def fingerprint(factor):
        table = np.array([factor, 1.0])
        share = jax.jit(lambda force: table[0] * force)
        own = {"share": jb.CustomQuantity(lambda peak_force: 2.0 * share(peak_force), "N")}
        variables = [jb.Variable("buffer.k_A", 100.0, 2000.0)]
        return jb.Problem(jb.table2(), [jb.Scenario()], variables, quantities=own).fingerprint()

    assert fingerprint(2.0) == fingerprint(2.0) != fingerprint(3.0)


def test_what_is_the_packages_own_has_no_code_in_its_identity(tmp_path, monkeypatch):
    monkeypatch.setattr("jaxbuffer.cluster.pool.Pool.completed", lambda *arguments: iter(()))
    assert "code" not in swept([0.1, 0.2], tmp_path).identity


def test_nothing_to_go_on_with(tmp_path):
    with pytest.raises(jb.InputError, match=r"log\.jsonl is missing; leave out --resume"):
        TuningStore(tmp_path, identity(), resume=True)
    with pytest.raises(jb.InputError, match=r"sweep\.zarr is missing; leave out --resume"):
        swept([0.1, 0.2], tmp_path, resume=True)
