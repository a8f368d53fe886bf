"""Phases of the loop, outcomes of a trial step, and the table of transitions between phases (docs/loop.md)."""

import enum
import functools
import operator

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Int


class Phase(enum.IntEnum):
    """What the next trial step is for.

    ``STEP``: to go on, as far as accuracy and stability allow. ``LOCATE``: to end on an event ahead. ``LOOK_BACK``: to
    end on a maximum inside a step that stands; the run then returns to the end of that step. ``RETAKE_…``: the same
    step as in the phase of that name, which was taken with the state alone and succeeded, now with tangents.
    ``REEVALUATE``: none; only the derivative of the state is evaluated, at the start and where it jumps.
    """

    STEP = 0
    LOCATE = 1
    LOOK_BACK = 2
    RETAKE_STEP = 3
    RETAKE_LOCATE = 4
    RETAKE_LOOK_BACK = 5
    REEVALUATE = 6


LOCATING = (Phase.LOCATE, Phase.LOOK_BACK, Phase.RETAKE_LOCATE, Phase.RETAKE_LOOK_BACK)
LOOKING_BACK = (Phase.LOOK_BACK, Phase.RETAKE_LOOK_BACK)
RETAKING = (Phase.RETAKE_STEP, Phase.RETAKE_LOCATE, Phase.RETAKE_LOOK_BACK)


class StepOutcome(enum.IntEnum):
    """What becomes of a trial step.

    ``ACCEPT``: the run goes on from its end, on whatever event lies there. ``REJECT``: its error is too large; a
    shorter step follows from the same start. ``LOCATE``: it holds an event; shorter steps follow that end on it.
    ``LOOK_BACK``: it stands, and holds a maximum and nothing else, which is located before the run goes on from the
    step's end. ``REFINE``: it does not yet end on the event that is being located; a better length follows.
    ``ABANDON``: the event that was being located is given up. ``RETAKE``: it was taken with the state alone, succeeded,
    and is taken again with tangents. ``SHORTEN``: an event may have begun and ended within it; a step follows that ends
    between the two.
    """

    ACCEPT = 0
    REJECT = 1
    LOCATE = 2
    LOOK_BACK = 3
    REFINE = 4
    ABANDON = 5
    RETAKE = 6
    SHORTEN = 7


_OF_A_STEP = {
    StepOutcome.ACCEPT: Phase.STEP,
    StepOutcome.REJECT: Phase.STEP,
    StepOutcome.LOCATE: Phase.LOCATE,
    StepOutcome.LOOK_BACK: Phase.LOOK_BACK,
    StepOutcome.SHORTEN: Phase.STEP,
}
_OF_A_LOCATION = {
    StepOutcome.ACCEPT: Phase.STEP,
    StepOutcome.LOCATE: Phase.LOCATE,
    StepOutcome.ABANDON: Phase.STEP,
    StepOutcome.SHORTEN: Phase.STEP,
}

# Pairs that are not listed cannot occur. After ACCEPT the event may ask for another phase: see `update.next_phase`.
TRANSITIONS: dict[Phase, dict[StepOutcome, Phase]] = {
    Phase.STEP: {**_OF_A_STEP, StepOutcome.RETAKE: Phase.RETAKE_STEP},
    Phase.LOCATE: {**_OF_A_LOCATION, StepOutcome.REFINE: Phase.LOCATE, StepOutcome.RETAKE: Phase.RETAKE_LOCATE},
    Phase.LOOK_BACK: {
        **_OF_A_LOCATION,
        StepOutcome.REFINE: Phase.LOOK_BACK,
        StepOutcome.RETAKE: Phase.RETAKE_LOOK_BACK,
    },
    Phase.RETAKE_STEP: _OF_A_STEP,
    Phase.RETAKE_LOCATE: {**_OF_A_LOCATION, StepOutcome.REFINE: Phase.LOCATE},
    Phase.RETAKE_LOOK_BACK: {**_OF_A_LOCATION, StepOutcome.REFINE: Phase.LOOK_BACK},
    Phase.REEVALUATE: {StepOutcome.ACCEPT: Phase.STEP, StepOutcome.REJECT: Phase.STEP},
}
# Pairs that cannot occur need a number too; which one is of no consequence.
_TABLE = np.array([TRANSITIONS[phase].get(outcome, Phase.STEP) for phase in Phase for outcome in StepOutcome])


def following(phase: Int[Array, ""], outcome: Int[Array, ""]) -> Int[Array, ""]:
    """Return the next phase by the table of transitions."""
    return jnp.asarray(_TABLE)[phase * len(StepOutcome) + outcome]


def is_one_of(phase: Int[Array, ""], phases: tuple[Phase, ...]) -> Bool[Array, ""]:
    """Return whether the phase is one of several."""
    return functools.reduce(operator.or_, [phase == one for one in phases])
