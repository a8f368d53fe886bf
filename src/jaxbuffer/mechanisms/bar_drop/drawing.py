"""What the dropped bar looks like. Bending is not drawn: it is µm, and the figures over time show it."""

from ..drawing import GROUND, Detail, Disc, Drawing, Named, Outline, Rod, Spot, Touch, box
from .design import BarDrop
from .system import BAR, ball_on_plate

CLOSER = 4.0  # half of the detail's width, in radii of the ball


def drawing(design: BarDrop, bodies: tuple[str, ...] = ()) -> Drawing:
    """The bar on its hinge, the ball end, and the plate below it, in the design's lengths."""
    bar, plate = design.bar, design.plate
    half, ball = float(bar.length) / 2.0, float(bar.ball_radius)
    end, hinge, struck = Spot(BAR, half), Spot(GROUND), Spot(GROUND, 2.0 * half, -ball)
    reach, thick = float(plate.length) / 2.0, float(plate.thickness)
    slab = box(struck.x - reach, struck.x + reach, struck.y - thick, struck.y)
    return Drawing(
        shapes=(
            Outline(GROUND, slab, part="plate"),
            Rod(Spot(BAR, -half), end, float(bar.diameter), "bar"),
            Disc(end, ball, part="ball end"),
            Disc(hinge, 1.5 * float(bar.diameter), filled=False, part="hinge"),
        ),
        touches=(Touch(end, struck, ball_on_plate(design).shape, -1.0),),
        names=(Named(hinge, "hinge"), Named(struck, "where it strikes")),
        detail=Detail("where the ball strikes", struck, CLOSER * ball),
    )
