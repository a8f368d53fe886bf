"""The slider-crank with radial clearance, by programs that share no code with the product.

``model``, ``dop853`` and ``run``: minimal coordinates, compiled, every event located by stepping onto it.
``plain``: absolute coordinates and multipliers, by SciPy alone. ``reference`` writes what tests compare with.
"""

from .parameters import SliderCrank as SliderCrank
from .run import Impact as Impact
from .run import Run as Run
from .run import simulate as simulate
