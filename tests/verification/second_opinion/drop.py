"""``PYTHONPATH=src:tests python -m verification.second_opinion.drop``: felupe's opinion on three drops onto the tank.

Ten minutes or so: deviations from felupe's finest [%], then what a change of 2 % does to our figures [%].
"""

import jaxbuffer.programs.process

jaxbuffer.programs.process.configure(cache=None)

from verification.second_opinion import dropped_tank as drop  # noqa: E402
from verification.second_opinion.felupe_drop import dropped as dropped_by_felupe  # noqa: E402

THEIRS = {"empty": ((3, 1000), (3, 500), (2, 1000)), "liquid": ((2, 300), (2, 150)), "plates": ((3, 300), (2, 150))}
ALTERED = {"empty": (*drop.NOTICED["empty"], "support.stiffness"), **{k: drop.NOTICED[k] for k in ("liquid", "plates")}}


def line(words, found, reference, wet):
    moved = drop.deviations(found, reference, drop.WET if wet else drop.DRY).values()
    pressed = f"{100.0 * drop.apart(found, reference):12.3f}" if wet else ""
    print(f"{words:30s}" + "".join(f"{100.0 * x:+12.3f}" for x in moved) + pressed, flush=True)


def table(name) -> None:
    """A case's: elements across the wall and steps of felupe, then our meshes."""
    wet = name == "liquid"
    print(f"{name:30s}" + "".join(f"{part:>12s}" for part in (*(drop.WET if wet else drop.DRY), *["pressed"] * wet)))
    reference, *others = (dropped_by_felupe(name, *given) for given in THEIRS[name])
    figures = "".join(f"{getattr(reference, part):12.6g}" for part in (drop.WET if wet else drop.DRY))
    print("{:30s}".format("felupe {}, {} steps".format(*THEIRS[name][0])) + figures, flush=True)
    for (fine, steps), found in zip(THEIRS[name][1:], others, strict=True):
        line(f"felupe {fine}, {steps} steps", found, reference, wet)
    ours = {fine: drop.dropped(fine, name) for fine in (1, 2, 4)}
    for fine, found in ours.items():
        line(f"refinement {fine}", found, reference, wet)
    line("refinement 2, steps halved", drop.dropped(2, name, rtol=2.5e-7), reference, wet)
    line("extrapolated", drop.extrapolated(ours[2], ours[4]), reference, wet)
    for field in ALTERED[name]:
        line(f"{field} + 2 %", drop.dropped(2, name, drop.altered(name, field)), ours[2], wet)


for case in THEIRS:
    table(case)
