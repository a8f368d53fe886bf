"""Where a pin is in its bush over a run: its path."""

import numpy as np
from jaxtyping import Float

from ...errors import InputError, check_choice
from ..run import Run

PINS = ("piston_pin", "crank_pin")


def journal_path(run: Run, pin: str = "piston_pin") -> Float[np.ndarray, "steps 2"]:
    """Return the pin's centre relative to the bush's at every step of a slider-crank's history, along the slider's line
    and across it [m], shape (steps, 2).

    **Arguments:** ``run``: one simulated with ``history=True``; ``pin``: "piston_pin" or "crank_pin".

    **Raises:** `InputError` for a run without a history and for an unknown pin.

    **Example:**

    >>> import numpy as np
    >>> run = jb.simulate(jb.SliderCrank(), jb.SliderCrankScenario(), duration=1e-3, history=True)
    >>> eccentricity = np.hypot(*jb.journal_path(run).T)
    >>> f"at most {1e6 * eccentricity.max():.0f} µm off the middle of a bush with 500 µm of clearance"
    'at most 578 µm off the middle of a bush with 500 µm of clearance'
    """
    check_choice("pin", pin, PINS)
    if run.history is None:
        raise InputError("this run has no history; simulate it with history=True")
    # A pin without play has no contact to record its place: it is in the middle of its bush.
    if getattr(run.design, pin).joint == "pinned":
        return np.zeros((len(run.history.time), 2))
    return np.stack([np.asarray(run.history.others[f"{pin}_{axis}"]) for axis in ("x", "y")], axis=1)
