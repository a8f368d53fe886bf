"""The bar dropped on a plate: a hinged bar falls, and its ball end strikes a rigid plate."""

from .design import BarDrop as BarDrop
from .design import BarDropScenario as BarDropScenario
from .mechanism import BAR_DROP as BAR_DROP
