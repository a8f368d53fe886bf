"""Planar rigid bodies: bodies, joints, force elements, the augmented index-1 system. Knows no contact, no capture."""

from .body import Body as Body
from .forces import AppliedForce as AppliedForce
from .forces import AppliedTorque as AppliedTorque
from .forces import AxialSpringDamper as AxialSpringDamper
from .forces import AxialState as AxialState
from .forces import ForceElement as ForceElement
from .forces import Load as Load
from .forces import SpringDirection as SpringDirection
from .forces import TorsionalSpringDamper as TorsionalSpringDamper
from .forces import load_at as load_at
from .initial import assemble as assemble
from .joints import FixedAngle as FixedAngle
from .joints import Joint as Joint
from .joints import PointOnLine as PointOnLine
from .joints import Prismatic as Prismatic
from .joints import Revolute as Revolute
from .joints import Row as Row
from .joints import Weld as Weld
from .kinematics import GROUND as GROUND
from .kinematics import Kinematics as Kinematics
from .system import Constraints as Constraints
from .system import Motion as Motion
from .system import System as System
