"""jaxbuffer: which spring, damper and tip mass behind a docking probe give the smallest impact force."""

from .capture import Capture as Capture
from .capture import simulate as simulate
from .certificate import Certificate as Certificate
from .certificate import Verdict as Verdict
from .errors import InputError as InputError
from .first_impact import FirstImpact as FirstImpact
from .first_impact import first_impact as first_impact
from .mechanisms import (
    Design as Design,
)
from .mechanisms import (
    Scenario as Scenario,
)
from .mechanisms import (
    get as get,
)
from .mechanisms import (
    paths as paths,
)
from .mechanisms import (
    replace as replace,
)
from .mechanisms import (
    rigid_probe as rigid_probe,
)
from .mechanisms import (
    table2 as table2,
)
from .outcome import Outcome as Outcome
from .runtime import configure as configure
from .sensitivity import Sensitivity as Sensitivity
from .sensitivity import sensitivity as sensitivity
from .sweep import Sweep as Sweep
from .sweep import sweep as sweep
from .tune import Problem as Problem
from .tune import Tuned as Tuned
from .tune import Variable as Variable
from .tune import tune as tune
