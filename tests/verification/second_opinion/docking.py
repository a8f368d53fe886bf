"""Latches and a real buffer from M171 to M176 of docs/model.md in plain Python, sharing nothing with jaxbuffer."""

import math

from scipy.interpolate import PchipInterpolator

from jaxbuffer import Design
from jaxbuffer.mechanisms.probe_cone.parts import ProbeBuffer


class Latch:
    """The latches of a design; ``closed_from``: when the tip crossed the capture plane [s], ``largest`` force [N]."""

    def __init__(self, design: Design):
        latch, cone = design.latch, design.cone
        self.stiffness, self.damping = float(latch.stiffness), float(latch.damping)
        self.preload, self.length = float(latch.preload), float(latch.preload_length)
        self.turn_stiffness, self.turn_damping = float(latch.turn_stiffness), float(latch.turn_damping)
        self.closing_time = float(latch.closing_time)
        self.strength = math.inf if latch.strength is None else float(latch.strength)
        sin = math.sin(float(cone.half_angle))
        self.seat = -float(cone.offset) - float(design.probe.tip_radius) * sin + float(latch.depth)
        self.closed_from: float | None = None
        self.largest = 0.0

    def close(self, time):
        """Begin to close, if they have not begun."""
        self.closed_from = time if self.closed_from is None else self.closed_from

    def torn(self, time, tip, cone):
        """Whether the force exceeds the strength; it is remembered."""
        if self.since(time) > 0.0:
            self.largest = max(self.largest, math.hypot(*self.force(time, tip, cone)))
        return self.largest > self.strength

    def since(self, time):
        """How long ago the tip crossed the capture plane [s]; negative before."""
        return -1.0 if self.closed_from is None else time - self.closed_from

    def share(self, time):
        x = min(max(self.since(time) / self.closing_time, 0.0), 1.0)
        return x * x * (3.0 - 2.0 * x)

    def force(self, time, tip, cone):
        """The force on the tip."""
        x, y, u, v, _ = tip
        ox, oy, angle, ou, ov, turning = cone
        rx, ry = x - ox - math.cos(angle) * self.seat, y - oy - math.sin(angle) * self.seat
        vx, vy = u - ou + turning * (y - oy), v - ov - turning * (x - ox)
        elastic = self.stiffness + self.preload / math.sqrt(rx * rx + ry * ry + self.length**2)
        share = self.share(time)
        return -share * (elastic * rx + self.damping * vx), -share * (elastic * ry + self.damping * vy)

    def generalised(self, time, tip, bearer, cone):
        """That force on the body that bears the tip, and its opposite on the cone's, at the tip's centre."""
        px, py = self.force(time, tip, cone)
        x, y = tip[:2]
        on_bearer = [px, py, (x - bearer[0]) * py - (y - bearer[1]) * px]
        return [*on_bearer, -px, -py, -((x - cone[0]) * py - (y - cone[1]) * px)]

    def moment(self, time, rod, cone):
        """The moment on the probe; ``rod``: its angle and spin."""
        return -self.share(time) * (self.turn_stiffness * (rod[0] - cone[2]) + self.turn_damping * (rod[1] - cone[5]))


def buffer_force(buffer: ProbeBuffer) -> dict:
    """What Exudyn's spring-damper takes: two numbers, or a function of elongation and its rate that gives the pull."""
    more = (buffer.spring_curve, buffer.damper_curve, buffer.preload, buffer.c_A2, buffer.rebound_factor)
    if all(part is None for part in (*more, buffer.friction, buffer.rebound_stiffness)):
        return {"stiffness": float(buffer.k_A), "damping": float(buffer.c_A)}
    spring = _line(buffer.spring_curve, buffer.k_A)
    damper = _line(buffer.damper_curve, buffer.c_A)
    preload, length = float(buffer.preload or 0.0), float(buffer.preload_length)
    quadratic, factor = float(buffer.c_A2 or 0.0), float(buffer.rebound_factor or 1.0)
    friction, slip = float(buffer.friction or 0.0), float(buffer.friction_speed)
    stop, stop_damping, gap = float(buffer.rebound_stiffness or 0.0), float(buffer.rebound_damping), buffer.rebound_gap

    def pull(_mbs, _time, _item, elongation, rate, *_):
        stroke, speed = -elongation, -rate
        push = spring(stroke) + preload * stroke / math.sqrt(stroke**2 + length**2)
        size = damper(abs(speed)) + quadratic * speed**2
        push += math.copysign(size * (factor if speed < 0.0 else 1.0), speed) + friction * math.tanh(speed / slip)
        if stroke < -gap:
            push -= max(0.0, -stop * (stroke + gap) - stop_damping * speed)
        return -push

    return {"springForceUserFunction": pull}


def _line(curve, slope):
    """A measured curve, or the straight line of a number."""
    if curve is None:
        return lambda at: slope * at
    points = [(0.0, 0.0), *curve.points()]
    found = PchipInterpolator(*zip(*points, strict=True))
    ends = [(0.0, 0.0), points[-1]]
    slopes = [float(found.derivative()(x)) for x, _ in ends]

    def value(at):
        if 0.0 <= at <= ends[1][0]:
            return float(found(at))
        (x, y), m = (ends[0], slopes[0]) if at < 0.0 else (ends[1], slopes[1])
        return y + m * (at - x)

    return value
