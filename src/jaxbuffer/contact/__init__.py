"""Contact: laws, friction, shapes, and the pair that turns them into forces. Knows no mechanism."""

from .friction import RegularisedCoulomb as RegularisedCoulomb
from .laws import DAMPING_FACTORS as DAMPING_FACTORS
from .laws import LAWS as LAWS
from .laws import PIN_IN_HOLE_LAWS as PIN_IN_HOLE_LAWS
from .laws import ContactLaw as ContactLaw
from .laws import KelvinVoigt as KelvinVoigt
from .laws import LankaraniNikravesh as LankaraniNikravesh
from .laws import PinInHoleLaw as PinInHoleLaw
from .laws import contact_law as contact_law
from .laws import contact_modulus as contact_modulus
from .laws import damping_factor as damping_factor
from .laws import hertz_stiffness as hertz_stiffness
from .laws import laws_with as laws_with
from .laws import pin_in_hole_law as pin_in_hole_law
from .laws import register_law as register_law
from .laws import socket_stiffness as socket_stiffness
from .pair import Approach as Approach
from .pair import Ball as Ball
from .pair import BallPair as BallPair
from .pair import Carrier as Carrier
from .shapes import Foot as Foot
from .shapes import Hole as Hole
from .shapes import Segment as Segment
from .shapes import Shape as Shape
