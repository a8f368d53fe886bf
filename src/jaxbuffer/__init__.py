"""jaxbuffer: which spring, damper and tip mass behind a docking probe give the smallest impact force."""

from .capture import Capture as Capture
from .capture import simulate as simulate
from .errors import InputError as InputError
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
from .tuning import Case as Case
from .tuning import Limits as Limits
from .tuning import Objective as Objective
from .tuning import Problem as Problem
from .tuning import Then as Then
from .tuning import Tuned as Tuned
from .tuning import Variable as Variable
from .tuning import tune as tune
