"""``PYTHONPATH=src:tests python -m verification.second_opinion.drop``: felupe's opinion on four drops onto the tank.

A quarter of an hour or so, or one drop by its name: deviations from felupe's finest [%], then what a change of 2 %
does to our figures [%].
"""

import sys

import jaxbuffer.programs.process

jaxbuffer.programs.process.configure(cache=None)

from verification.second_opinion import dropped_tank as drop  # noqa: E402
from verification.second_opinion.felupe_drop import dropped as dropped_by_felupe  # noqa: E402

THEIRS = {
    "empty": ((3, 1000), (3, 500), (2, 1000)),
    "liquid": ((2, 300), (2, 150)),
    "plates": ((3, 300), (2, 150)),
    "yielding": ((3, 1000), (3, 500), (2, 1000)),
}
ALTERED = drop.NOTICED | {"empty": (*drop.NOTICED["empty"], "support.stiffness")}


def line(words, found, reference, name):
    moved = drop.deviations(found, reference, drop.FIGURES[name]).values()
    pressed = f"{100.0 * drop.apart(found, reference):13.3f}" if name == "liquid" else ""
    print(f"{words:30s}" + "".join(f"{100.0 * x:+13.3f}" for x in moved) + pressed, flush=True)


def table(name) -> None:
    """A case's: elements across the wall and steps of felupe, then our meshes."""
    figures = drop.FIGURES[name]
    print(f"{name:30s}" + "".join(f"{part:>13s}" for part in (*figures, *["pressed"] * (name == "liquid"))))
    reference, *others = (dropped_by_felupe(name, *given) for given in THEIRS[name])
    numbers = "".join(f"{getattr(reference, part):13.6g}" for part in figures)
    print("{:30s}".format("felupe {}, {} steps".format(*THEIRS[name][0])) + numbers, flush=True)
    for (fine, steps), found in zip(THEIRS[name][1:], others, strict=True):
        line(f"felupe {fine}, {steps} steps", found, reference, name)
    ours = {fine: drop.dropped(fine, name) for fine in (1, 2, 4)}
    for fine, found in ours.items():
        line(f"refinement {fine}", found, reference, name)
    line("refinement 2, steps halved", drop.dropped(2, name, rtol=2.5e-7), reference, name)
    line("extrapolated", drop.extrapolated(ours[2], ours[4]), reference, name)
    for field in ALTERED[name]:
        line(f"{field} + 2 %", drop.dropped(2, name, drop.altered(name, field)), ours[2], name)


for case in sys.argv[1:] or THEIRS:
    table(case)
