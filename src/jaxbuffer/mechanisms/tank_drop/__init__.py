"""The drop onto a tank: a rigid slider with a cushion falls on a tank that holds a liquid."""

from .design import TankDrop as TankDrop
from .design import TankDropScenario as TankDropScenario
from .mechanism import TANK_DROP as TANK_DROP
