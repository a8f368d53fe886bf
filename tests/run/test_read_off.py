"""What is read off a run whose time is up, of a log written by hand."""

import jax
import jax.numpy as jnp

import jaxbuffer as jb
from jaxbuffer.hybrid import Kind, Log, Result, Start, Status
from jaxbuffer.mechanisms.bar_drop import BAR_DROP
from jaxbuffer.run.request import request
from jaxbuffer.run.stepper import run_of

RATE = 2.0  # m/s, at which the ball's depth grows at the end


def test_an_end_by_time_stays():
    """The bar, and its ball with it, is lowered by 1 m a unit: its depth would be reached 1/`RATE` earlier."""
    asked = request(BAR_DROP, jb.BarDrop(), jb.BarDropScenario(), 0.1)
    system = asked.system
    row = system.first_evaluation()[0].state[None]
    contacts, observables = system.contact_count, len(system.observed)
    lower = jnp.zeros_like(row).at[0, 1].set(-1.0)

    @jax.jit
    def end(p):
        log = Log.empty(2, row, contacts, observables)
        event = (jnp.asarray(x) for x in (True, int(Kind.END), 0, 0.1))
        now = jnp.zeros(observables), jnp.asarray(RATE), jnp.zeros(contacts)
        log = log.append(*event, *now, row + p * lower, jnp.zeros_like(row), jnp.asarray(False))
        result = Result(
            jnp.asarray(int(Status.TIMEOUT)), Start(row[None], log.active[0]), log, None, jnp.asarray(1), jnp.asarray(1)
        )
        return run_of(asked, result).end_time

    assert jax.jvp(end, (0.0,), (1.0,)) == (0.1, 0.0)
