"""The mechanisms of the documents' examples, and a rig whose contact's force has a name of its own."""

import importlib.util
import re
import sys
from typing import NamedTuple

from documents.examples import DOCS, blocks
from jaxbuffer.mechanisms import registry

OWN = 'QUANTITIES = {"wall_force": PEAK_FORCE, "contact_time": CONTACT_TIME._replace(tuned=True)}'


class Tried(NamedTuple):
    """A mechanism: its ``main`` quantity, and a number of the design by whose power ``exponent`` that goes, or falls if
    that is None, with the ``ends`` of its range; another number and one of the scenario to sweep over; a number that a
    record of the quantity ``measured`` [m] until a time ``until`` [s] tells, with its value."""

    name: str
    main: str
    number: str
    ends: tuple[float, float]
    exponent: float | None
    others: dict[str, tuple[float, float]]
    measured: str
    until: float
    fitted: str
    value: float


SLED = Tried(
    name="sled",
    main="stroke",
    number="sled.spring",
    ends=(100.0, 400.0),
    exponent=None,
    others={"sled.latch": (4e3, 6e3), "scenario.force": (7.0, 8.0)},
    measured="stroke",
    until=0.2,
    fitted="sled.spring",
    value=200.0,
)
PENDULUM = Tried(
    name="pendulum",
    main="peak_force",
    number="rod.stiffness",
    ends=(5e8, 2e9),
    exponent=0.4,  # of Hertz's law without loss (M80)
    others={"rod.mass": (0.1, 0.3), "scenario.angle": (0.2, 0.4)},
    measured="gap contact",
    until=0.3,  # before the ball hangs
    fitted="rod.length",
    value=0.5,
)
RIG = PENDULUM._replace(name="rig", main="wall_force")


def _definitions(name):
    """The code that defines a mechanism, without the runs of the documents."""
    if name in ("sled", "flywheel"):
        sled, wheel = blocks(DOCS / "elements.md").split("run = jb.simulate", 1)
        if name == "sled":
            return sled
        return sled + wheel[wheel.index("from jaxbuffer.elements import Integral") :].split("spun = jb.simulate", 1)[0]
    pendulum = blocks(DOCS / "mechanisms.md").split("run = jb.simulate", 1)[0]
    if name == "pendulum":
        return pendulum
    # A contact without a time of its peak and a penetration.
    rig = re.sub(r"QUANTITIES = \{.*?\n\}", OWN, pendulum, flags=re.DOTALL)
    return rig.replace("Pendulum", "Rig").replace("pendulum", "rig")


def defined(name, folder):
    """A mechanism, from a module in a folder; it is not registered any more."""
    before = registry.all_registered()
    file = folder / f"own_{name}.py"
    file.write_text(_definitions(name))
    spec = importlib.util.spec_from_file_location(file.stem, file)
    module = importlib.util.module_from_spec(spec)
    # A function is found by its module when its program is kept.
    sys.modules[file.stem] = module
    spec.loader.exec_module(module)
    mechanism = registry.registered(name)
    for other in registry.all_registered():
        if other not in before:
            registry._BY_DESIGN.pop(other.design)
    return mechanism
