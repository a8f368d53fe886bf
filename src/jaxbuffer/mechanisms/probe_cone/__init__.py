"""The probe-cone mechanism: a probe with a ball tip behind a buffer meets a cone; two vehicles capture each other."""

from .bending import bending_frequencies as bending_frequencies
from .bending import with_bending as with_bending
from .capture import Capture as Capture
from .capture import FirstImpact as FirstImpact
from .closed_form import first_impact as first_impact
from .design import Design as Design
from .design import Scenario as Scenario
from .design import rigid_probe as rigid_probe
from .design import table2 as table2
from .mechanism import PROBE_CONE as PROBE_CONE
from .outcome import Outcome as Outcome
from .sized import size_buffer as size_buffer
from .sized import size_latch as size_latch
