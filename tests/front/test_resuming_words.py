"""What is said when a run can't be gone on with: what differs, and what to do."""

import pytest

import jaxbuffer as jb
from jaxbuffer.tuning.problem import Settings
from jaxbuffer.tuning.store import Store

REPEAT = "repeat the study and the options of the first run, or choose another --output"


def fingerprint(high=2000.0, **settings):
    problem = jb.Problem(jb.table2(), [jb.Scenario()], [jb.Variable("buffer.k_A", 100.0, high)])
    return f"{problem.fingerprint()}-{Settings(**settings)}"


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
    with Store(tmp_path, fingerprint(), resume=False):
        pass
    with pytest.raises(jb.InputError) as caught:
        Store(tmp_path, fingerprint(**asked), resume=True)
    message = str(caught.value)
    assert message.endswith(REPEAT) and "Settings(" not in message
    assert all(part in message for part in parts)


def swept(speeds, folder, resume=False):
    return jb.sweep(jb.table2(), jb.Scenario(approach_speed=speeds), folder=folder, resume=resume)


def test_another_sweep(tmp_path, monkeypatch):
    monkeypatch.setattr("jaxbuffer.sweeps.sweep.completed", lambda *arguments: iter(()))
    swept([0.1, 0.2], tmp_path)
    with pytest.raises(jb.InputError, match=r"in scenarios; repeat the study, .* same --over .* another --output"):
        swept([0.1, 0.3], tmp_path, resume=True)


def test_nothing_to_go_on_with(tmp_path):
    with pytest.raises(jb.InputError, match=r"log\.jsonl is missing; leave out --resume"):
        Store(tmp_path, fingerprint(), resume=True)
    with pytest.raises(jb.InputError, match=r"sweep\.zarr is missing; leave out --resume"):
        swept([0.1, 0.2], tmp_path, resume=True)
