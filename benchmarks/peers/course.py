"""The course of one capture, whichever solver drives it: what happens at an event, and what is reported at the end."""

from __future__ import annotations

from dataclasses import dataclass, field

from .contact import SLOWEST_TOUCHDOWN, both_gaps
from .parameters import Parameters, Vector
from .watch import ACTIVE, CAPTURE, ESCAPE, MEMORY, PARAMETERS, context_of, forces


@dataclass(frozen=True)
class PeerCapture:
    """What a peer reports of one capture (M67 to M71 of docs/model.md)."""

    outcome: str  # captured, escaped, timeout or failed
    end_time: float  # [s]
    peak_force: float  # [N] the largest normal force of either flank
    peak_time: float  # [s]
    peak_flank: str  # lower or upper
    impacts: int  # touchdowns, the contact the run starts in among them
    steps: int | None  # accepted steps, where the solver tells
    evaluations: int | None  # right-hand sides, those inside a compiled Jacobian not counted


@dataclass
class Course:
    """A capture under way."""

    parameters: Parameters
    state: Vector = field(init=False)  # (25,) at t = 0
    context: Vector = field(init=False)
    peak: tuple[float, float, int] = (0.0, 0.0, 0)  # force [N], time [s], flank
    impacts: int = 1
    outcome: str = "timeout"
    steps: int = 0  # 0: not told
    evaluations: int = 0

    def __post_init__(self) -> None:
        self.state, self.context = context_of(self.parameters)

    def presses(self, flank: int) -> bool:
        """Whether that flank may press on the tip."""
        return bool(self.context[ACTIVE.start + flank])

    @property
    def over(self) -> bool:
        """Whether the capture has ended before its time."""
        return self.outcome != "timeout"

    def meet(self, event: int, y: Vector) -> None:
        """Let event 0 to 3 of ``watch`` happen at the state ``y`` (25,)."""
        if event == CAPTURE:
            self.outcome = "captured"
        elif event == ESCAPE:
            self.outcome = "escaped"
        elif self.presses(event):
            self.context[ACTIVE.start + event] = 0.0
        else:
            rate = both_gaps(y, self.context[PARAMETERS])[2 + event]
            self.context[ACTIVE.start + event] = 1.0
            self.context[MEMORY.start + event] = max(-rate, SLOWEST_TOUCHDOWN)
            self.impacts += 1

    def top(self, flank: int, t: float, y: Vector) -> None:
        """Note the top of a flank's force, reached at time ``t`` [s] in state ``y`` (25,)."""
        force = forces(y, self.context)[flank]
        if force > self.peak[0]:
            self.peak = (force, t, flank)

    def report(self, end_time: float) -> PeerCapture:
        """The capture, ended at ``end_time`` [s]."""
        force, time, flank = self.peak
        return PeerCapture(
            outcome=self.outcome,
            end_time=end_time,
            peak_force=force,
            peak_time=time,
            peak_flank=("lower", "upper")[flank],
            impacts=self.impacts,
            steps=self.steps or None,
            evaluations=self.evaluations,
        )
