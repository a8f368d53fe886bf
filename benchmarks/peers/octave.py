"""GNU Octave's ode15s on the paper's own form D(y) y' = F(y) (its eqs. 15 to 17), in a process of its own.

The multipliers are the rates of four dummy unknowns, as in the paper, so there are 28 unknowns (29 with a free tip).
The contact's memory is an argument of the right-hand side: a touchdown is a terminal event, after which ode15s starts
anew. ode15s places an event on the straight line between two steps, too coarsely for this model, so the scripts locate
it once more by a Runge-Kutta flight from the step before. The seconds reported are those of the solve alone, by
Octave's own clock: neither its start-up nor the reading of the force's top from the steps is in them.

At relative tolerances of 1e-6 and above the error allowed in a position is larger than a penetration: ode15s then
chatters for minutes through the sliding contacts.
"""

from __future__ import annotations

import json
import shutil
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

from . import parameters as at
from .course import PeerCapture
from .parameters import Parameters, vector
from .start import start

SCRIPTS = Path(__file__).resolve().parent / "octave"
PROGRAMS = ("octave-cli", "octave")
MISSING = "skipped: octave not found"
PLACES = {
    "m_S": at.MASS_S, "I_S": at.INERTIA_S, "m_B": at.MASS_B, "I_B": at.INERTIA_B, "m_P": at.MASS_P,
    "I_P": at.INERTIA_P, "m_T": at.MASS_T, "I_T": at.INERTIA_T, "I_t": at.INERTIA_TIP, "a": at.HINGE,
    "h": at.HALF_CYLINDER, "l_r": at.REAR, "l_t": at.FRONT, "k_A": at.SPRING_A, "c_A": at.DAMPER_A,
    "k_T": at.SPRING_T, "c_T": at.DAMPER_T, "l_0": at.FREE_LENGTH, "R": at.RADIUS, "cos_beta": at.COSINE,
    "sin_beta": at.SINE, "L_T": at.CONE_OFFSET, "R_c": at.THROAT_RADIUS, "L_c": at.CONE_LENGTH, "K": at.STIFFNESS,
    "chi": at.HYSTERESIS, "mu": at.FRICTION, "v_s": at.SLIP_SPEED, "gain": at.GAIN,
}  # fmt: skip


class OctaveError(RuntimeError):
    """Octave is there but did not finish the capture."""


@dataclass(frozen=True)
class OctaveCapture:
    """A capture by Octave and the seconds [s] of its solve, by Octave's own clock."""

    capture: PeerCapture
    seconds: float


def program() -> str | None:
    """The Octave program on the path, if there is one."""
    return next((path for name in PROGRAMS if (path := shutil.which(name))), None)


def _job(parameters: Parameters, rtol: float, atol: float) -> dict:
    values = vector(parameters)
    y, active, memory = start(parameters)
    design = {name: float(values[place]) for name, place in PLACES.items()}
    return {
        "design": design | {"rolling": int(parameters.rolling)},
        "state": [*y[:24], 0.0, 0.0, 0.0, 0.0, *([0.0] if parameters.rolling else [])],
        "memory": list(memory * active),
        "duration": parameters.duration,
        "rtol": rtol,
        "atol": atol,
    }


def capture(
    parameters: Parameters, rtol: float, atol: float, runs: int = 2, limit: float = 600.0
) -> OctaveCapture | str:
    """One capture by ode15s, the last of ``runs`` in one Octave so that it is warm; or the reason why there is none.

    Raises ``OctaveError`` where Octave fails or takes longer than ``limit`` [s].
    """
    octave = program()
    if octave is None:
        return MISSING
    with tempfile.TemporaryDirectory() as folder:
        job = Path(folder) / "job.json"
        job.write_text(json.dumps(_job(parameters, rtol, atol)))
        command = [octave, "--quiet", "--norc", "--path", str(SCRIPTS), str(SCRIPTS / "run_capture.m"), str(job)]
        command.append(str(runs))
        try:
            # In the temporary folder, since an Octave that is stopped saves its workspace where it stands.
            done = subprocess.run(command, capture_output=True, text=True, timeout=limit, check=False, cwd=folder)
        except subprocess.TimeoutExpired as error:
            raise OctaveError(f"no result within {limit} s") from error
    line = next((line for line in done.stdout.splitlines() if line.startswith("RESULT ")), None)
    if line is None:
        raise OctaveError(done.stderr.strip() or done.stdout.strip())
    record = json.loads(line.removeprefix("RESULT "))
    result = PeerCapture(
        outcome=record["outcome"],
        end_time=record["end_time"],
        peak_force=record["peak_force"],
        peak_time=record["peak_time"],
        peak_flank=("lower", "upper")[int(record["peak_flank"]) - 1],
        impacts=int(record["impacts"]),
        steps=int(record["steps"]),
        evaluations=None,
    )
    return OctaveCapture(result, record["seconds"])
