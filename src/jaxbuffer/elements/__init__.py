"""Elements of mechanisms: parts between bodies, each of which says all of itself in one file.

Force elements without a state of their own, and bodies and joints, are those of `jaxbuffer.multibody`.
"""

from .attitude_control import AttitudeControl as AttitudeControl
from .ball_contact import BallContact as BallContact
from .ball_contact import BallState as BallState
from .buffer import Buffer as Buffer
from .buffer import BufferForce as BufferForce
from .drive import Drive as Drive
from .drive import Motor as Motor
from .element import ContactForces as ContactForces
from .element import Element as Element
from .element import Impacts as Impacts
from .element import Magnitudes as Magnitudes
from .element import Switch as Switch
from .latch import Latch as Latch
from .lockout import Lockout as Lockout
from .oscillators import Oscillators as Oscillators
from .picture import Level as Level
from .picture import Panel as Panel
from .picture import PanelCurve as PanelCurve
from .pin import Pin as Pin
from .report import EnergyShare as EnergyShare
from .report import Report as Report
from .sensor import Integral as Integral
from .sensor import Sensor as Sensor
from .sensor import deepest as deepest
from .spring_damper import SpringDamper as SpringDamper
from .stepping import SteppingHints as SteppingHints
from .stop import EndStop as EndStop
from .stop import RubberBlock as RubberBlock
from .thrust import Thrust as Thrust
from .wrench import Wrench as Wrench
