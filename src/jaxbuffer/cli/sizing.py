"""The command that sizes parts, as its help shows it."""

from typing import Annotated

import typer


def _wish(name: str, metavar: str, text: str) -> typer.models.OptionInfo:
    return typer.Option(name, metavar=metavar, help=text, show_default=False)


def size(
    settling_time: Annotated[
        str | None, _wish("--settling-time", "S", "Held within that time after latching [s]; default: what comes.")
    ] = None,
    latch_energy_share: Annotated[
        str | None,
        _wish("--latch-energy-share", "SHARE", "Of the approach's energy, put in by the latch; default 10 %."),
    ] = None,
    peak_latch_force: Annotated[
        str | None, _wish("--peak-latch-force", "N", "Largest force of the latch [N]; default: latch.strength.")
    ] = None,
    stroke: Annotated[
        str | None, _wish("--stroke", "M", "Stroke that the fastest approach takes [m]; default: buffer.max_stroke.")
    ] = None,
    overspeed: Annotated[
        str | None, _wish("--overspeed", "TIMES", "The fastest approach, that the end stop still takes; default 1.5.")
    ] = None,
) -> None:
    """Size a docking's latch and buffer from the speeds, masses, misses and attitudes of the study's scenarios.

    The latch's stiffness is what its share of energy allows: ½ w μ v²/(r² + 0.3 (v τ)²) with the reduced mass μ, the
    slowest speed v, the largest miss r at the capture plane and the closing time τ; its turn stiffness ½ w μ v²/φ²,
    with the probe's largest angle φ. Damping ratios follow from the time, the buffer from its stroke and the fastest
    speed, the end stop from what a faster approach has left. The sized design is then simulated in every scenario.

    Wishes that are not given here are those of [problem.constraints] with the same names. It ends with exit code 1
    where a run misses one, and says which wish stands in the way.

    \b
    Files in DIR:
      design.toml  the study with what was sized, ready to be simulated and tuned
      size.json    every number with its rule, closed forms and simulated values
      size.txt     the tables
      size.png     what energy, force, time and stroke cost: each over the stiffness that sets it

    \b
    Examples:
      jaxbuffer size study.toml --output sized
      jaxbuffer size study.toml --settling-time "10 s" --latch-energy-share "8 %" --stroke "25 mm"
    """
