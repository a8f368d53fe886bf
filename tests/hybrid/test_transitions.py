"""The loop's transitions, each from a state and a trial step made by hand: outcome, next phase, what is recorded."""

import functools
import re
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from hybrid.ball import (
    CONTACT,
    DURATION,
    END,
    IMPACT_STEP,
    JUMP,
    LENGTH,
    PEAK,
    RATE_PEAK,
    Ball,
    BallByState,
    guards,
    initial,
    running,
    task,
    trial,
)
from jaxbuffer.hybrid import Kind, Status
from jaxbuffer.hybrid.events.bracketing import MAX_TRIES, MAX_TRIES_MAXIMUM, Bracket
from jaxbuffer.hybrid.loop import loop
from jaxbuffer.hybrid.loop.decision import decide
from jaxbuffer.hybrid.loop.phase import LOOKING_BACK, TRANSITIONS, Phase, StepOutcome
from jaxbuffer.hybrid.loop.task import Task
from jaxbuffer.hybrid.rungekutta.controller import StepSizes

PAGE = Path(__file__).parents[2] / "docs" / "loop.md"
START = 0.5  # s
STATE_ALONE, WITH_TANGENTS, JUMPING = task(), task(tangents=2), task(jumps=True)
BY_STATE = task(ball=BallByState)
FALLING = guards(contact=(1e-3, -1.0, 0.0))
TOUCHING = guards(contact=(0.0, -1.0, 0.0))


def pressed(force, rate):
    """Guards of a contact that stays closed, with its force and the force's rate."""
    return guards(contact=(-1e-3, 0.0, 0.0), force=(force, rate))


RISING, HIGHEST, FALLEN = pressed(1.0, 100.0), pressed(1.05, 0.0), pressed(1.0, -100.0)


def program(case):
    """Outcome and next state of one iteration with a given trial step, compiled."""

    def iterate(state, trial):
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(loop, "take_trial", lambda task, state: trial)
            return decide(case, state, trial).outcome, loop._iterate(case, state)

    return jax.jit(iterate)


PROGRAMS = {id(case): program(case) for case in (STATE_ALONE, WITH_TANGENTS, JUMPING, BY_STATE)}


def iterated(case, state, trial):
    outcome, following = PROGRAMS[id(case)](*jax.tree.map(np.asarray, (state, trial)))  # of like types: compiled once
    return StepOutcome(int(outcome)), following


def bracket(guard, low_value, high_value, **others):
    """Of an event halfway through a step that ends at twice the trial's length."""
    zero = jnp.zeros(())
    return Bracket.none()._replace(
        guard=jnp.asarray(guard),
        step=jnp.asarray(LENGTH),
        low=zero,
        high=jnp.asarray(2.0 * LENGTH),
        low_value=jnp.asarray(low_value),
        high_value=jnp.asarray(high_value),
        **{name: jnp.asarray(value) for name, value in others.items()},
    )


TOWARD_CONTACT = bracket(CONTACT, -1e-3, 1e-3)
TOWARD_MAXIMUM = bracket(PEAK, -100.0, 100.0)


def located(case, phase, **changes):
    """A run about to end a step on the touchdown, or on the force's maximum."""
    if phase in LOOKING_BACK:
        return running(case, phase, RISING, closed=True, bracket=TOWARD_MAXIMUM._replace(**changes))
    return running(case, phase, FALLING, bracket=TOWARD_CONTACT._replace(**changes))


def thrown_over_the_end(state, step):
    """The same, but in the step the ball rises a micrometre above the mark of the run's end and falls again."""
    apex, speed = 1e-6, 5.0 * LENGTH

    def at(rows, end_rate):
        there, rate = np.zeros((2, *rows.shape))
        there[0], rate[0] = (2.0 + apex - 0.1 * speed**2 / 2.0, end_rate, 0.0), (end_rate, -10.0, 0.0)
        return there, rate

    def on(guards, end_rate):
        return guards._replace(terminal=np.array([apex - 0.1 * speed**2 / 2.0]), terminal_rate=np.array([end_rate]))

    (rows, rate), (end, end_rate) = at(state.point.rows, speed), at(step.step.end, -speed)
    point = state.point._replace(rows=rows, rate=rate, guards=on(state.point.guards, speed))
    taken = step.step._replace(end=end, rate=end_rate)
    return state._replace(point=point), step._replace(step=taken, guards=on(step.guards, -speed))


def step_cases(phase, case):
    """What a step taken to go on may show."""
    start, rising = running(case, phase, FALLING), running(case, phase, RISING, closed=True)
    inside = guards(contact=(-1e-3, -1.0, 0.0))
    return [
        (phase, "nothing", start, trial(case, FALLING), StepOutcome.ACCEPT, Phase.STEP),
        (phase, "error too large", start, trial(case, FALLING, norm=6.0), StepOutcome.REJECT, Phase.STEP),
        (phase, "not finite", start, trial(case, inside, norm=jnp.nan, finite=False), StepOutcome.REJECT, Phase.STEP),
        (phase, "a touchdown", start, trial(case, inside), StepOutcome.LOCATE, Phase.LOCATE),
        (phase, "a touchdown, overshot", start, trial(case, inside, norm=4.0), StepOutcome.LOCATE, Phase.LOCATE),
        (phase, "a touchdown, far off", start, trial(case, inside, norm=6.0), StepOutcome.REJECT, Phase.STEP),
        (
            phase,
            "the end within it",
            *thrown_over_the_end(start, trial(case, FALLING)),
            StepOutcome.SHORTEN,
            Phase.STEP,
        ),
        (phase, "a maximum alone", rising, trial(case, FALLEN), StepOutcome.LOOK_BACK, Phase.LOOK_BACK),
        (phase, "a maximum, error too large", rising, trial(case, FALLEN, norm=2.0), StepOutcome.REJECT, Phase.STEP),
        (
            phase,
            "a maximum and the end",
            rising,
            trial(case, FALLEN._replace(terminal=jnp.ones(1))),
            StepOutcome.LOCATE,
            Phase.LOCATE,
        ),
    ]


def location_cases(phase, case):
    """What a step may show that is to end on an event."""
    back = phase in LOOKING_BACK
    there, beside = (HIGHEST, pressed(1.0, 50.0)) if back else (TOUCHING, guards(contact=(5e-4, -1.0, 0.0)))
    end = there._replace(terminal=jnp.ones(1))
    start, unlucky = located(case, phase), located(case, phase, tries=jnp.asarray(MAX_TRIES))
    goes_on = Phase.LOOK_BACK if back else Phase.LOCATE
    limit = located(case, phase, tries=jnp.asarray(MAX_TRIES_MAXIMUM))
    return [
        (phase, "the event", start, trial(case, there), StepOutcome.ACCEPT, Phase.STEP),
        (phase, "the event, and another before it", start, trial(case, end), StepOutcome.LOCATE, Phase.LOCATE),
        (phase, "the same after many tries", unlucky, trial(case, end), StepOutcome.ACCEPT, Phase.STEP),
        (
            phase,
            "the event, and the end within it",
            *thrown_over_the_end(start, trial(case, there)),
            StepOutcome.SHORTEN,
            Phase.STEP,
        ),
        (phase, "no event yet", start, trial(case, beside), StepOutcome.REFINE, goes_on),
        (phase, "no event yet, error too large", start, trial(case, beside, norm=6.0), StepOutcome.REFINE, goes_on),
        (
            phase,
            "no event yet, solved wrongly",
            start,
            trial(case, beside, norm=6.0, implicit=True),
            StepOutcome.ABANDON,
            Phase.STEP,
        ),
        (
            phase,
            "no event yet after twelve tries",
            limit,
            trial(case, beside),
            StepOutcome.ACCEPT if back else StepOutcome.REFINE,
            Phase.STEP if back else goes_on,
        ),
        (phase, "the event, error too large", start, trial(case, there, norm=2.0), StepOutcome.ABANDON, Phase.STEP),
        (phase, "not finite", start, trial(case, beside, norm=jnp.nan, finite=False), StepOutcome.ABANDON, Phase.STEP),
    ]


def retake_cases():
    """What succeeds with the state alone, where tangents are wanted."""
    case, start = WITH_TANGENTS, running(WITH_TANGENTS, Phase.STEP, FALLING)
    alone = functools.partial(trial, case, with_tangents=False)
    contact, maximum = located(case, Phase.LOCATE), located(case, Phase.LOOK_BACK)
    rising = running(case, Phase.STEP, RISING, closed=True)
    return [
        (Phase.STEP, "nothing", start, alone(FALLING), StepOutcome.RETAKE, Phase.RETAKE_STEP),
        (
            Phase.STEP,
            "a maximum alone",
            rising,
            alone(FALLEN),
            StepOutcome.RETAKE,
            Phase.RETAKE_STEP,
        ),
        (Phase.LOCATE, "the event", contact, alone(TOUCHING), StepOutcome.RETAKE, Phase.RETAKE_LOCATE),
        (Phase.LOOK_BACK, "the event", maximum, alone(HIGHEST), StepOutcome.RETAKE, Phase.RETAKE_LOOK_BACK),
    ]


def reevaluate_cases(case):
    """Of a step of length zero."""
    start = running(case, Phase.REEVALUATE, FALLING)
    beyond = guards(contact=(-1e-3, -1.0, 0.0))
    nan = trial(case, FALLING, norm=jnp.nan, length=0.0, finite=False)
    return [
        (Phase.REEVALUATE, "nothing", start, trial(case, FALLING, length=0.0), StepOutcome.ACCEPT, Phase.STEP),
        (Phase.REEVALUATE, "a jump", start, trial(case, beyond, length=0.0), StepOutcome.ACCEPT, Phase.STEP),
        (Phase.REEVALUATE, "not finite", start, nan, StepOutcome.REJECT, Phase.STEP),
    ]


CASES = [
    (case, *row)
    for case, rows in (
        (STATE_ALONE, step_cases(Phase.STEP, STATE_ALONE)),
        (STATE_ALONE, location_cases(Phase.LOCATE, STATE_ALONE)),
        (STATE_ALONE, location_cases(Phase.LOOK_BACK, STATE_ALONE)),
        (STATE_ALONE, reevaluate_cases(STATE_ALONE)),
        (WITH_TANGENTS, step_cases(Phase.RETAKE_STEP, WITH_TANGENTS)),
        (WITH_TANGENTS, location_cases(Phase.RETAKE_LOCATE, WITH_TANGENTS)),
        (WITH_TANGENTS, location_cases(Phase.RETAKE_LOOK_BACK, WITH_TANGENTS)),
        (WITH_TANGENTS, retake_cases()),
    )
    for row in rows
]
NAMES = [f"{phase.name}-{shown}" for _, phase, shown, *_ in CASES]


@pytest.mark.parametrize(("case", "phase", "shown", "state", "step", "outcome", "following"), CASES, ids=NAMES)
def test_transition(case, phase, shown, state, step, outcome, following):
    """Outcome and next phase; a run moves, counts a step and forgets the event only where the step is accepted."""
    found, after = iterated(case, state, step)
    assert (found, Phase(int(after.phase))) == (outcome, following)
    assert int(after.attempts) == 1
    accepted = outcome is StepOutcome.ACCEPT
    assert int(after.steps.count) == int(accepted)
    assert bool(after.locating) == (following not in (Phase.STEP, Phase.RETAKE_STEP, Phase.REEVALUATE))
    assert (int(after.bracket.guard) >= 0) == bool(after.locating)
    if not accepted:
        for before, now in zip(jax.tree.leaves(state.point), jax.tree.leaves(after.point), strict=True):
            np.testing.assert_array_equal(before, now)
        assert int(after.log.count) == 0


def test_a_step_that_an_event_may_hide_in_is_cut_to_end_where_it_shows():
    """While the ball is above the mark, by five times the square of the time to or from its highest place."""
    sizes = StepSizes.of(jnp.asarray(LENGTH), 2)
    start = running(STATE_ALONE, Phase.STEP, FALLING, step_sizes=sizes)
    state, step = thrown_over_the_end(start, trial(STATE_ALONE, FALLING))
    outcome, after = iterated(STATE_ALONE, state, step)
    assert outcome is StepOutcome.SHORTEN
    assert np.all(np.abs(np.asarray(after.step_sizes.steps) - 0.5 * LENGTH) < np.sqrt(1e-6 / 5.0))


def test_every_transition_is_tested():
    assert {(phase, outcome) for _, phase, *_, outcome, _ in CASES} == {
        (phase, outcome) for phase in Phase for outcome in TRANSITIONS[phase]
    }


def test_the_page_has_the_same_table():
    table_rows = re.findall(r"^\| .*", PAGE.read_text().partition("## Transitions")[2], flags=re.MULTILINE)[:8]
    cells = [re.findall(r"`([A-Z_]+)`|–", row) for row in table_rows]
    table = {(row[0], outcome): then for row in cells[1:] for outcome, then in zip(cells[0], row[1:], strict=True)}
    assert {(Phase[phase], StepOutcome[outcome]): Phase[then] for (phase, outcome), then in table.items() if then} == {
        (phase, outcome): following for phase in Phase for outcome, following in TRANSITIONS[phase].items()
    }


def test_the_first_step_is_that_of_the_state_and_of_no_tangent():
    """A fifth of the height, which is 1 m and does not depend on the floor's stiffness."""

    class Sized(Ball):
        def impact_step(self, state):
            return 0.2 * state[0]

    case = Task.of(Sized, WITH_TANGENTS.tangents, jnp.asarray(DURATION), WITH_TANGENTS.options)
    state = initial(case)
    share = case.options.tolerance.first_step(2)
    assert 0.0 < float(share) < 5.0
    np.testing.assert_allclose(float(state.contact_step), 0.2 * float(share), rtol=1e-15)


def test_a_touchdown_is_recorded():
    """The log's entry, the jump of the state, and steps as short as an impact needs."""
    state = located(STATE_ALONE, Phase.LOCATE)
    _, after = iterated(STATE_ALONE, state, trial(STATE_ALONE, TOUCHING))
    log = after.log
    assert (int(log.count), int(log.kind[0]), int(log.which[0])) == (1, Kind.TOUCHDOWN, 0)
    assert float(log.time[0]) == float(after.last_touchdown) == START + LENGTH
    np.testing.assert_array_equal(log.rows[0], [[1.0, 1.0, JUMP]])
    np.testing.assert_array_equal(after.point.rows, [[1.0, 1.0, JUMP]])
    np.testing.assert_array_equal(after.active, [1.0])
    np.testing.assert_allclose(after.step_sizes.steps, IMPACT_STEP, rtol=0.7)  # times what rtol 1e-7 allows
    assert np.all(np.asarray(after.step_sizes.steps) == float(after.contact_step))
    np.testing.assert_array_equal(after.step_sizes_before_contact.steps, state.step_sizes.steps)


def test_an_event_beside_the_step_is_recorded_at_its_own_time():
    """The step ends 5e-10 s before it: time and state are moved there in the log, and the run goes on from the step."""
    close = guards(contact=(5e-10, -1.0, 0.0))
    _, after = iterated(STATE_ALONE, located(STATE_ALONE, Phase.LOCATE), trial(STATE_ALONE, close))
    assert float(after.log.time[0]) - (START + LENGTH) == pytest.approx(5e-10, rel=1e-6)
    assert float(after.log.rows[0, 0, 0]) - 1.0 == pytest.approx(2.0 * 5e-10, rel=1e-6)
    assert float(after.point.time) == START + LENGTH
    assert float(after.point.rows[0, 0]) == 1.0


@pytest.mark.parametrize(
    ("case", "phase", "following"),
    [
        (BY_STATE, Phase.LOCATE, Phase.STEP),
        (STATE_ALONE, Phase.LOCATE, Phase.REEVALUATE),
        (WITH_TANGENTS, Phase.RETAKE_LOCATE, Phase.REEVALUATE),
    ],
    ids=["alone", "an observable of the rate", "tangents"],
)
def test_a_release(case, phase, following):
    """Steps go on as before the contact; with tangents, or where an observable depends on it, the derivative is
    evaluated anew."""
    before = StepSizes(jnp.array([3e-3, 4e-3]), jnp.array([0.1, 0.2]))
    at = guards(contact=(-1e-3, 1.0, 0.0))
    state = running(case, phase, at, closed=True, bracket=TOWARD_CONTACT, step_sizes_before_contact=before)
    outcome, after = iterated(case, state, trial(case, guards(contact=(0.0, 1.0, 0.0))))
    assert (outcome, Phase(int(after.phase))) == (StepOutcome.ACCEPT, following)
    assert (int(after.log.count), int(after.log.kind[0])) == (1, Kind.RELEASE)
    np.testing.assert_array_equal(after.active, [0.0])
    np.testing.assert_array_equal(after.step_sizes.steps, before.steps)


def test_a_derivative_that_jumps_is_evaluated_anew():
    """After a touchdown whose force jumps; its log entry holds the observables just after it, once they are known, and
    later ones do not change it."""
    outcome, state = iterated(JUMPING, located(JUMPING, Phase.LOCATE), trial(JUMPING, TOUCHING))
    assert (outcome, Phase(int(state.phase))) == (StepOutcome.ACCEPT, Phase.REEVALUATE)
    state = state._replace(logged=jnp.full(2, 2.0), attempts=jnp.asarray(3))
    outcome, state = iterated(JUMPING, state, trial(JUMPING, pressed(3.0, 100.0)))
    assert (outcome, Phase(int(state.phase))) == (StepOutcome.ACCEPT, Phase.STEP)
    values = pressed(3.0, 100.0).value
    np.testing.assert_array_equal(state.log.values[0], values)
    np.testing.assert_array_equal(state.logged, np.maximum(values, 2.0))
    _, state = iterated(JUMPING, state, trial(JUMPING, pressed(4.0, 100.0)))
    assert int(state.log.count) == 1
    np.testing.assert_array_equal(state.log.values[0], values)


def test_a_touchdown_that_could_not_be_brought_to_the_surface():
    """Given up beyond it after many tries: the force acts at once, so the derivative is evaluated anew."""
    state = located(STATE_ALONE, Phase.LOCATE, tries=jnp.asarray(MAX_TRIES))
    outcome, after = iterated(STATE_ALONE, state, trial(STATE_ALONE, guards(contact=(-1e-4, 1e-6, 0.0))))
    assert (outcome, Phase(int(after.phase))) == (StepOutcome.ACCEPT, Phase.REEVALUATE)
    np.testing.assert_array_equal(after.active, [1.0])


def test_a_near_release_is_located_at_once():
    """Predicted in 1e-5 s, shorter than a first step of an impact: it is bracketed up to four times that."""
    at = guards(contact=(-1e-5, 1.0, 0.0))
    state = running(STATE_ALONE, Phase.STEP, guards(contact=(-1e-3, 1.0, 0.0)), closed=True)
    outcome, after = iterated(STATE_ALONE, state, trial(STATE_ALONE, at))
    assert (outcome, Phase(int(after.phase)), int(after.bracket.guard)) == (StepOutcome.ACCEPT, Phase.LOCATE, CONTACT)
    np.testing.assert_allclose([after.bracket.step, after.bracket.high], [1e-5, 4e-5], rtol=1e-12)
    np.testing.assert_allclose([after.bracket.low_value, after.bracket.high_value], [-1e-5, 3e-5], rtol=1e-12)


def test_looking_back_returns_to_the_end_of_the_step():
    """A maximum inside a step that stands is recorded; the run then goes on from the step's end."""
    case = STATE_ALONE
    turned = trial(case, FALLEN, length=2.0 * LENGTH)
    _, looking = iterated(case, running(case, Phase.STEP, RISING, closed=True), turned)
    assert float(looking.step_end.time) == START + 2.0 * LENGTH
    assert float(looking.point.time) == START
    assert not np.array_equal(looking.step_sizes.steps, StepSizes.of(looking.contact_step, 2).steps), "it has learnt"
    outcome, after = iterated(case, looking, trial(case, HIGHEST))
    assert (outcome, Phase(int(after.phase))) == (StepOutcome.ACCEPT, Phase.STEP)
    assert (int(after.log.count), int(after.log.kind[0]), int(after.log.which[0])) == (1, Kind.PEAK, 0)
    assert float(after.log.time[0]) == START + LENGTH
    assert float(after.log.values[0, 0]) == float(after.extremes.largest[0]) == pytest.approx(1.05)
    for end, now in zip(jax.tree.leaves(looking.step_end), jax.tree.leaves(after.point), strict=True):
        np.testing.assert_array_equal(end, now)
    assert not np.any(after.located)
    np.testing.assert_array_equal(after.step_sizes.steps, looking.step_sizes.steps)


def test_a_maximum_that_a_run_goes_on_from_is_not_found_again():
    """It is marked as located, whatever the sign of the rate that is left; the next step then finds none."""
    case = STATE_ALONE
    state = running(case, Phase.LOCATE, RISING, closed=True, bracket=TOWARD_MAXIMUM)
    _, after = iterated(case, state, trial(case, pressed(1.05, 1e-9)))
    assert (int(after.log.count), int(after.log.kind[0])) == (1, Kind.PEAK)
    np.testing.assert_array_equal(after.located, [True, False])
    falling = trial(case, FALLEN)
    assert iterated(case, after, falling)[0] is StepOutcome.ACCEPT
    assert iterated(case, after._replace(located=jnp.zeros(2, bool)), falling)[0] is StepOutcome.LOOK_BACK


@pytest.mark.parametrize("rate", [1e-9, 50.0])
def test_a_maximum_that_leads_nowhere_is_not_looked_for_again(rate):
    """Located, or given up after its tries, hardly beyond the start: the next step is not searched for it, though it
    rises in between, and neither is the one after a second maximum there; a step that gets away ends that."""
    case, near = STATE_ALONE, 1e-9
    tries = jnp.asarray(MAX_TRIES_MAXIMUM)
    state = running(case, Phase.LOCATE, RISING, closed=True, bracket=TOWARD_MAXIMUM._replace(tries=tries))
    _, after = iterated(case, state, trial(case, pressed(1.05, rate), length=near))
    np.testing.assert_array_equal(after.given_up, [True, False])
    higher = trial(case, pressed(1.2, -1.0))
    outcome, away = iterated(case, after, higher)
    assert outcome is StepOutcome.ACCEPT
    assert not np.any(away.given_up)
    assert iterated(case, after._replace(given_up=jnp.zeros(2, bool)), higher)[0] is StepOutcome.LOOK_BACK
    other = after._replace(
        phase=jnp.asarray(int(Phase.LOCATE)), bracket=TOWARD_MAXIMUM._replace(guard=jnp.asarray(RATE_PEAK), tries=tries)
    )
    _, both = iterated(case, other, trial(case, pressed(1.05, rate), length=near))
    np.testing.assert_array_equal(both.given_up, [True, True])


def test_a_maximum_that_is_sought_in_vain_is_not_looked_for_again():
    """Its tries spent where it falls already, far from the start: what rises later is noise, or another one."""
    case, tries = STATE_ALONE, jnp.asarray(MAX_TRIES_MAXIMUM)
    state = running(case, Phase.LOCATE, RISING, closed=True, bracket=TOWARD_MAXIMUM._replace(tries=tries))
    _, after = iterated(case, state, trial(case, pressed(1.05, -50.0)))
    np.testing.assert_array_equal(after.given_up, [True, False])
    assert iterated(case, after, trial(case, pressed(1.2, -1.0)))[0] is StepOutcome.ACCEPT
    _, found = iterated(case, state, trial(case, HIGHEST))
    assert not np.any(found.given_up)


def test_a_maximum_that_is_not_there_is_not_recorded():
    """Given up after its tries below it: the run goes on from the last try's end, inside the step."""
    state = located(STATE_ALONE, Phase.LOOK_BACK, tries=jnp.asarray(MAX_TRIES_MAXIMUM))
    outcome, after = iterated(STATE_ALONE, state, trial(STATE_ALONE, pressed(1.0, 50.0)))
    assert outcome is StepOutcome.ACCEPT
    assert int(after.log.count) == 0
    assert float(after.point.time) == START + LENGTH


def test_step_sizes_after_each_outcome():
    """The controller learns from steps whose length it chose; a location given up cuts both methods' steps."""
    case = STATE_ALONE
    sizes = StepSizes(jnp.array([LENGTH, 5.0 * LENGTH]), jnp.ones(2))
    wide = running(case, Phase.STEP, FALLING, step_sizes=sizes)

    def steps(state, trial):
        return np.asarray(iterated(case, state, trial)[1].step_sizes.steps) / LENGTH

    on_event = located(case, Phase.LOCATE)._replace(step_sizes=sizes)
    growth = 0.9 * 0.5 ** (-0.7 / 8.0)
    np.testing.assert_allclose(steps(wide, trial(case, FALLING)), [growth, 5.5])
    np.testing.assert_allclose(steps(wide, trial(case, FALLING, norm=256.0)), [0.45, 5.0])
    np.testing.assert_allclose(steps(wide, trial(case, guards(contact=(-1e-3, -1.0, 0.0)))), [1.0, 5.0])
    np.testing.assert_allclose(steps(on_event, trial(case, guards(contact=(5e-4, -1.0, 0.0)))), [1.0, 5.0])
    np.testing.assert_allclose(steps(on_event, trial(case, TOUCHING, norm=256.0)), [0.45, 0.45])


def test_a_retake_keeps_what_was_tried():
    """Bracket and step sizes stay; that the event was met is remembered."""
    state = located(WITH_TANGENTS, Phase.LOCATE)
    _, after = iterated(WITH_TANGENTS, state, trial(WITH_TANGENTS, TOUCHING, with_tangents=False))
    assert bool(after.bracket.converged)
    same = after.bracket._replace(converged=state.bracket.converged)
    for before, now in zip(state.bracket, same, strict=True):
        np.testing.assert_array_equal(before, now)
    np.testing.assert_array_equal(after.step_sizes.steps, state.step_sizes.steps)


def test_how_a_run_ends():
    case, start = STATE_ALONE, running(STATE_ALONE, Phase.STEP, FALLING)
    end = bracket(END, -1e-3, 1e-3)
    crossing = running(case, Phase.LOCATE, FALLING, bracket=end)
    _, over = iterated(case, crossing, trial(case, guards(end=(0.0, 1.0))))
    assert (int(over.status), int(over.log.kind[0]), int(over.log.which[0])) == (0, Kind.END, 0)
    _, over = iterated(case, start, trial(case, FALLING, length=DURATION - START))
    assert (int(over.status), int(over.log.kind[0])) == (Status.TIMEOUT, Kind.END)
    _, over = iterated(case, start._replace(attempts=jnp.asarray(200_000 - 1)), trial(case, FALLING))
    assert int(over.status) == Status.TOO_MANY_STEPS
    tiny = start._replace(step_sizes=StepSizes.of(jnp.asarray(1e-14), 2))
    _, over = iterated(case, tiny, trial(case, FALLING, norm=256.0, length=1e-14))
    assert int(over.status) == Status.STEP_TOO_SMALL
    _, over = iterated(case, tiny, trial(case, FALLING, norm=jnp.inf, length=1e-14, finite=False))
    assert int(over.status) == Status.NOT_FINITE
    _, over = iterated(case, running(case, Phase.REEVALUATE, FALLING), trial(case, FALLING, length=0.0, finite=False))
    assert int(over.status) == Status.NOT_FINITE
    _, on = iterated(case, start, trial(case, FALLING, norm=256.0))
    assert int(on.status) == Status.RUNNING
    # The other method's step may be short for a reason of its own: it went from one event to the next.
    other = start._replace(step_sizes=StepSizes(jnp.array([LENGTH, 1e-15]), jnp.ones(2)))
    _, on = iterated(case, other, trial(case, FALLING, norm=256.0))
    assert int(on.status) == Status.RUNNING
