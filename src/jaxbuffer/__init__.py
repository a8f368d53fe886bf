"""jaxbuffer: which spring, damper and tip mass behind a docking probe give the smallest impact force."""

from .capture import Capture as Capture, simulate as simulate
from .errors import InputError as InputError
from .mechanisms import (
    Design as Design,
    Scenario as Scenario,
    get as get,
    paths as paths,
    replace as replace,
    rigid_probe as rigid_probe,
    table2 as table2,
)
from .outcome import Outcome as Outcome
from .runtime import configure as configure
from .sensitivity import Sensitivity as Sensitivity, sensitivity as sensitivity
from .tune import Problem as Problem, Tuned as Tuned, Variable as Variable, tune as tune
