"""Shock: how a single degree of freedom answers to pulses and to signals, and the shear below a struck surface."""

from .pressure import hertz_shear as hertz_shear
from .pulses import PULSES as PULSES
from .pulses import Pulse as Pulse
from .pulses import largest_response as largest_response
from .pulses import response as response
from .spectrum import shock_spectrum as shock_spectrum
from .spectrum import spectrum_of_motion as spectrum_of_motion
