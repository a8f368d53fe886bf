"""A docking in space through diffrax: the smooth law's terms, event and observables, beside the independent program."""

import diffrax
import jax
import jax.numpy as jnp
import pytest

import jaxbuffer as jb
from docking3d.reference import CASES

RTOL = 1e-6


@pytest.mark.long
def test_diffeqsolve_ends_where_the_independent_program_captures():
    """The smooth law is off by its bias, in the plane's cases up to 5e-4 of a force: of time and stroke far less."""
    case = CASES["two planes"]
    problem = jb.as_diffrax(case.design, case.scenario)

    @jax.jit
    def solve():
        return diffrax.diffeqsolve(
            problem.term,
            diffrax.Tsit5(),
            0.0,
            case.duration,
            problem.dt0,
            problem.y0,
            args=problem.args,
            event=problem.event,
            stepsize_controller=diffrax.PIDController(RTOL, RTOL * problem.scales, pcoeff=0.3, icoeff=0.4),
            saveat=diffrax.SaveAt(subs=[diffrax.SubSaveAt(t1=True), diffrax.SubSaveAt(steps=True, fn=problem.observe)]),
            max_steps=2**14,
        )

    solution = solve()
    assert problem.ended_by(solution.ys[0][0], problem.args) == 0  # captured
    assert float(solution.ts[0][0]) == pytest.approx(case.values["end_time"], rel=1e-4)
    for name in ("stroke", "hinge_angle"):
        history = solution.ys[1][name]
        highest = float(jnp.max(history, where=jnp.isfinite(history), initial=0.0))
        assert highest == pytest.approx(case.values[name], rel=1e-3), name
