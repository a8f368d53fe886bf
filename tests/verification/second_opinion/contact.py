"""The tip against both flanks, from M29 to M59 of docs/model.md in plain Python, sharing nothing with jaxbuffer.

With the damping factor of Lankarani and Nikravesh only.
"""

import math

from jaxbuffer import Design

SLOWEST = 1e-5  # m/s


class Contact:
    """The tip against two flanks: forces from positions and velocities, and the memory of the approach speed."""

    def __init__(self, design: Design, reach: float, spins: bool):
        cone, contact = design.cone, design.contact
        self.reach, self.spins, self.radius = reach, spins, float(design.probe.tip_radius)
        self.cos, self.sin = math.cos(cone.half_angle), math.sin(cone.half_angle)
        self.offset, self.throat, self.length = float(cone.offset), float(cone.throat_radius), float(cone.length)
        modulus = contact.young_modulus / (1 - contact.poisson_ratio**2)
        hertz = 2 / 3 * modulus * math.sqrt(self.radius)
        self.stiffness = hertz if contact.stiffness is None else float(contact.stiffness)
        self.loss = 0.75 * (1 - contact.restitution**2)
        self.friction, self.slip_speed = float(contact.friction), float(contact.slip_speed)
        self.memory, self.open = [SLOWEST, SLOWEST], [True, True]

    def touch(self, tip, cone, side):
        """Gap, approach speed, slip, foot, normal and tangent of one flank; ``tip``: x, y, u, v, ω; ``cone``: pose,
        rates."""
        x, y, u, v, spin = tip
        ox, oy, angle, ou, ov, turning = cone
        c, s = math.cos(angle), math.sin(angle)
        tx, ty = c * self.cos - s * side * self.sin, s * self.cos + c * side * self.sin  # towards the throat
        ex = ox - c * self.offset + s * side * self.throat
        ey = oy - s * self.offset - c * side * self.throat
        slant = min(max(-((x - ex) * tx + (y - ey) * ty), 0.0), self.length)
        fx, fy = ex - slant * tx, ey - slant * ty
        far = math.hypot(x - fx, y - fy)
        nx, ny = (x - fx) / far, (y - fy) / far
        mx, my = side * ny, -side * nx
        rx = u + spin * (y - fy) - (ou - turning * (fy - oy))
        ry = v - spin * (x - fx) - (ov + turning * (fx - ox))
        return far - self.radius, -(rx * nx + ry * ny), rx * mx + ry * my, fx, fy, nx, ny, mx, my

    def normal_force(self, flank, gap, speed):
        if gap >= 0.0:
            return 0.0
        # A contact that opens within this very step has no memory yet: it meets at its present speed.
        met = max(speed, SLOWEST) if self.open[flank] else self.memory[flank]
        return self.stiffness * (-gap) ** 1.5 * max(0.0, 1.0 + self.loss * speed / met)

    def tip(self, probe, ball):
        x, y, angle, u, v, spin = probe
        if self.spins:
            return ball[0], ball[1], ball[3], ball[4], ball[5]
        rx, ry = self.reach * math.cos(angle), self.reach * math.sin(angle)
        return x + rx, y + ry, u - spin * ry, v + spin * rx, spin

    def generalised(self, probe, ball, cone):
        """Forces and moments on the body that bears the tip, and on the cone's."""
        tip = self.tip(probe, ball)
        bearer = ball if self.spins else probe
        total = [0.0] * 6
        for flank, side in enumerate((1.0, -1.0)):
            gap, speed, slip, fx, fy, nx, ny, mx, my = self.touch(tip, cone, side)
            normal = self.normal_force(flank, gap, speed)
            if normal > 0.0:
                tangential = -self.friction * normal * math.tanh(slip / self.slip_speed)
                px, py = normal * nx + tangential * mx, normal * ny + tangential * my
                total[0] += px
                total[1] += py
                total[2] += (fx - bearer[0]) * py - (fy - bearer[1]) * px
                total[3] -= px
                total[4] -= py
                total[5] -= (fx - cone[0]) * py - (fy - cone[1]) * px
        return total
