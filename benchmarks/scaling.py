"""Time and memory of sweeps from one capture to ten thousand, each in a process of its own."""

from __future__ import annotations

from . import fresh
from .figures import Check, Curve, Figure, Part, Plot, Ratio
from .plan import Plan
from .sweep import MEMORY, chosen

COUNTS = (1, 10, 100, 1000, 10_000)
POOLED = 1000  # captures; a pool's time grows in proportion beyond


def named(count: int) -> str:
    """A number of captures in words."""
    return f"{count} capture{'s' if count > 1 else ''}"


def measure(plan: Plan) -> Part:
    """The product and the pool of the best peer, at the settings of the sweep."""
    pick = chosen(plan)
    counts = COUNTS[:3] if plan.quick else COUNTS
    mine, theirs = {}, {}
    for count in plan.track(counts, "scaling"):
        mine[count] = fresh.measured("sweep", captures=count, **pick.own.choice)
        if count <= POOLED:
            theirs[count] = fresh.measured("pool", captures=count, **pick.theirs.choice)
    sides = (("jaxbuffer, sweep", mine), (f"{pick.theirs.solver}, 2 processes", theirs))
    ratios = tuple(
        Ratio(
            f"scaling/{count}",
            named(count),
            *(
                Figure(label, 1e3 * row[count]["seconds"], "ms", setting.errors, setting.tolerances)
                for (label, row), setting in zip(sides, (pick.own, pick.theirs), strict=True)
            ),
        )
        for count in theirs
    )
    plots = tuple(
        Plot(
            f"scaling-{quantity}",
            f"Sweeps of Table 2: {quantity}",
            "captures",
            f"{quantity} [{unit}]",
            tuple(
                Curve(label, tuple(map(float, row)), tuple(one[name] for one in row.values())) for label, row in sides
            ),
            line,
        )
        for quantity, name, unit, line in (("time", "seconds", "s", None), ("peak memory", "mebibytes", "MiB", MEMORY))
    )
    checks = tuple(
        Check(f"peak memory of {named(count)}", Figure("jaxbuffer", row["mebibytes"], "MiB"), MEMORY)
        for count, row in mine.items()
    )
    rates = ", ".join(f"{count}: {count / row['seconds']:.0f}/s" for count, row in mine.items())
    return Part("scaling", "Time and memory over the number of captures", ratios, checks, plots, (f"rates: {rates}",))
