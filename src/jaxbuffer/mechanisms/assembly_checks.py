"""What an assembled mechanism is checked for: names, and where its numbers are known, magnitudes and constraints."""

from collections import Counter
from collections.abc import Iterable, Mapping
from typing import Any

import jax
import numpy as np
from jaxtyping import Array, Float

from .._types import Scalar
from ..errors import InputError, concrete
from ..multibody import GROUND, Joint, System
from .system import ContactSystem

DEPENDENT = 1e-10  # singular value of constraint rows of unit length, below which rows are dependent but for rounding
SHARE = 1e-6  # of a joint's row in a dependence, above which the joint takes part in it


def known(numbers: Any, dimensions: int) -> bool:
    """Return whether numbers have values to look at: none is traced, or has more axes than so many ``dimensions``."""
    leaves = jax.tree.leaves(numbers)
    return not any(isinstance(leaf, jax.core.Tracer) or np.ndim(leaf) > dimensions for leaf in leaves)


def check_names(what: str, names: Iterable[str]) -> None:
    """Raise `InputError` where two have one name. ``what``: what they are, in the plural."""
    for name, count in Counter(names).items():
        if count > 1:
            raise InputError(f"{count} {what} are called {name!r}: give each a name of its own")


def check_magnitudes(system: ContactSystem, others: Mapping[str, Scalar | None]) -> None:
    """Raise `InputError` for a threshold, scale or tolerance that is no number: NaN is below and above nothing, so that
    what is compared with it is decided without a word. ``others``: magnitudes besides the system's own, by name."""
    # A threshold may be -∞, a limit ∞ and a number that nothing stands for None; NaN is wrong everywhere.
    magnitudes: dict[str, tuple[Any, bool]] = {
        **{f"roundoff of {name}": (x, True) for name, x in zip(system.observed, system.roundoff(), strict=True)},
        "scales": (system.scales(), False),
        "scale_limits": (system.scale_limits(), True),
        "typical_speed": (system.typical_speed, False),
        "energy_scale": (system.energy_scale, False),
        "momentum_scale": (system.momentum_scale, False),
        "tolerance_share": (system.tolerance_share, False),
        **{name: (value, False) for name, value in others.items()},
    }
    for name, (value, unbounded) in magnitudes.items():
        array = None if value is None else concrete(value)
        if array is not None and not np.all(~np.isnan(array) if unbounded else np.isfinite(array)):
            raise InputError(f"{name} of the assembled mechanism is {array}: give the elements finite numbers")


def check_constraints(system: System, q: Float[Array, " coordinates"], v: Float[Array, " coordinates"]) -> None:
    """Raise `InputError` for joints that hold one motion several times at t = 0: nothing then says which of them takes
    the reaction, and the augmented system is singular."""
    if not system.joints:
        return
    kin = system.kinematics(q, v)
    jacobian = np.asarray(system.constraints(kin).jacobian, float)
    if not np.all(np.isfinite(jacobian)):
        return  # a state that is not finite is said of the run
    length = np.linalg.norm(jacobian, axis=1)
    # Rows of unit length, because their units differ; all entries of a row of zeros are zero.
    rows = jacobian / np.where(length > 0.0, length, 1.0)[:, None]
    combinations, sizes, _ = np.linalg.svd(rows)
    dependences = combinations[:, np.pad(sizes, (0, len(rows) - len(sizes))) < DEPENDENT]
    if not dependences.shape[1]:
        return
    # A joint takes part where one of its rows is in a combination that gives nothing.
    owners = np.repeat(np.arange(len(system.joints)), [len(joint.rows(kin)) for joint in system.joints])
    involved = dict.fromkeys(owners[np.max(np.abs(dependences), axis=1) > SHARE].tolist())
    named = " and ".join(_named(place, system.joints[place]) for place in involved)
    raise InputError(
        f"{named} hold one motion more than once: of {len(rows)} constraints {dependences.shape[1]} can be left out,"
        " and nothing says which of them takes the reaction; leave a joint out, or take one that holds less, such as"
        " PointOnLine in place of Prismatic"
    )


def _named(place: int, joint: Joint) -> str:
    """Return a joint in words: "Prismatic joints[1] (ground, body 0)"."""
    bodies = ("ground" if body == GROUND else f"body {body}" for body in (joint.first, joint.second))
    return f"{type(joint).__name__} joints[{place}] ({', '.join(bodies)})"
