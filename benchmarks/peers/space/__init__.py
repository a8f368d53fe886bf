"""The docking in space in one compiled loop, by equations in minimal coordinates (Kane's method) that share no code
with the product: captures, from the cone or from a free start, with welded or free tip.

``python -m benchmarks peers.space.check`` compares it with the reference captures.
"""

from .parameters import Parameters as Parameters
from .run import capture as capture
