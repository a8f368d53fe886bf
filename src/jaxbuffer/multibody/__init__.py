"""Planar rigid bodies: bodies, joints, force elements, the augmented index-1 system. Knows no contact and no capture."""

from .body import Body as Body
from .forces import (
    AppliedForce as AppliedForce,
    AppliedTorque as AppliedTorque,
    AxialSpringDamper as AxialSpringDamper,
    ForceElement as ForceElement,
    Load as Load,
    TorsionalSpringDamper as TorsionalSpringDamper,
    load_at as load_at,
)
from .initial import assemble as assemble
from .joints import (
    FixedAngle as FixedAngle,
    Joint as Joint,
    PointOnLine as PointOnLine,
    Prismatic as Prismatic,
    Revolute as Revolute,
    Row as Row,
    Weld as Weld,
)
from .kinematics import GROUND as GROUND, Frame as Frame, Kinematics as Kinematics, Vector as Vector
from .linear import inverse as inverse, ldl_solve as ldl_solve
from .system import Constraints as Constraints, Motion as Motion, System as System
