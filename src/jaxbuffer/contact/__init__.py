"""Contact: laws, friction, shapes, and the pair that turns them into forces. Knows no mechanism."""

from .friction import RegularisedCoulomb as RegularisedCoulomb
from .laws import ContactLaw as ContactLaw, LankaraniNikravesh as LankaraniNikravesh, hertz_stiffness as hertz_stiffness
from .pair import Approach as Approach, Ball as Ball, BallOnSegments as BallOnSegments, Carrier as Carrier
from .shapes import Foot as Foot, Segment as Segment
