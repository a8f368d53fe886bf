"""Fibre composites: plies, laminates, and how near their plies are to failure."""

from .failure import CRITERIA as CRITERIA
from .failure import Strength as Strength
from .failure import hoffman as hoffman
from .failure import is_bounded as is_bounded
from .failure import maximum_stress as maximum_stress
from .failure import tsai_hill as tsai_hill
from .failure import tsai_wu as tsai_wu
from .laminate import Laminate as Laminate
from .ply import Ply as Ply
from .ply import in_ply_axes as in_ply_axes
