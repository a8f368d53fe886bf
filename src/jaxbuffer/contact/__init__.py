"""Contact: laws, friction, shapes, and the pair that turns them into forces. Knows no mechanism."""

from .friction import RegularisedCoulomb as RegularisedCoulomb
from .laws import LAWS as LAWS
from .laws import ContactLaw as ContactLaw
from .laws import KelvinVoigt as KelvinVoigt
from .laws import LankaraniNikravesh as LankaraniNikravesh
from .laws import contact_law as contact_law
from .laws import hertz_stiffness as hertz_stiffness
from .pair import Approach as Approach
from .pair import Ball as Ball
from .pair import BallOnSegments as BallOnSegments
from .pair import Carrier as Carrier
from .shapes import Foot as Foot
from .shapes import Segment as Segment
