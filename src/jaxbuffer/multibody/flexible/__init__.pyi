"""The public names of the package, which Python imports when they are first used."""

from .bar import Bar as Bar
from .bar import FlexibleBar as FlexibleBar
from .bars import cantilever_bar as cantilever_bar
from .bars import free_bar as free_bar
from .bars import pinned_bar as pinned_bar
from .damping import modal_damping as modal_damping
from .damping import rayleigh_damping as rayleigh_damping
from .modes import ComponentModes as ComponentModes
from .modes import Marker as Marker
from .planar import Attachment as Attachment
from .planar import PlanarModes as PlanarModes
from .planar import boundary as boundary
from .planar import planar_modes as planar_modes
from .plates import RectangularPlate as RectangularPlate
from .plates import plate_strip as plate_strip
from .recovery import axial_force as axial_force
from .recovery import bending_moment as bending_moment
from .recovery import deflection as deflection
from .recovery import stress as stress
