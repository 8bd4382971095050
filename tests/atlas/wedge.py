"""A body without friction on two straight pieces of ground: a motion with one degree of freedom, in closed form up to a
quadrature."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from mpmath import mp, mpf


@dataclass
class Wedge:
    """The motion from rest at θ = 0, where both contacts touch."""

    #: For each contact: the slope of its ground, and its arm from the centre of mass.
    slopes: tuple
    arms: tuple
    rho: mpf
    gravity: mpf

    @cached_property
    def normals(self):
        return [(-mp.sin(slope), mp.cos(slope)) for slope in self.slopes]

    def place(self, theta):
        """Position of the centre of mass by n·(r + R(θ)d − d) = 0 at both contacts, and its derivative with respect to θ."""
        (a, b), (c, d) = self.normals
        cos, sin = mp.cos(theta), mp.sin(theta)
        sides, rates = [], []
        for n, (x, y) in zip(self.normals, self.arms, strict=True):
            sides.append(
                -n[0] * ((cos - 1) * x - sin * y) - n[1] * (sin * x + (cos - 1) * y)
            )
            rates.append(n[0] * (sin * x + cos * y) - n[1] * (cos * x - sin * y))

        def solve(f, g):
            return (f * d - b * g) / (a * d - b * c), (a * g - f * c) / (a * d - b * c)

        return solve(*sides), solve(*rates)

    def downhill(self):
        """Sign of the rotation while it slides down."""
        return -1 if self.place(mpf("-1e-3"))[0][1] < 0 else 1

    def spin(self, theta):
        """|ω|, by energy."""
        (_, y), (dx, dy) = self.place(theta)
        return mp.sqrt(-2 * self.gravity * y / (dx * dx + dy * dy + self.rho**2))

    def time(self, theta):
        """Time until the body has turned by this angle. The substitution θ s² removes the singularity of the
        integrand at rest."""
        theta = abs(theta) * self.downhill()
        return mp.quad(
            lambda s: 2 * abs(theta) * s / self.spin(theta * s * s),
            [0, 0.5, 1],
            method="gauss-legendre",
        )

    def way(self, theta, contact):
        """Displacement of this contact along its ground."""
        (x, y), _ = self.place(theta)
        cos, sin = mp.cos(theta), mp.sin(theta)
        p, q = self.arms[contact]
        tangent = mp.cos(self.slopes[contact]), mp.sin(self.slopes[contact])
        return tangent[0] * (x + (cos - 1) * p - sin * q) + tangent[1] * (
            y + sin * p + (cos - 1) * q
        )

    def acceleration_by_forces(self, theta=0.0, omega=0.0):
        """Acceleration (ẍ, ÿ, θ̈) in doubles, from the forces that keep both contacts on their ground."""
        cos, sin, rows, bends = np.cos(theta), np.sin(theta), [], []
        for slope, (x, y) in zip(self.slopes, self.arms, strict=True):
            n = np.array([-np.sin(float(slope)), np.cos(float(slope))])
            arm = np.array(
                [cos * float(x) - sin * float(y), sin * float(x) + cos * float(y)]
            )
            rows.append([*n, n[1] * arm[0] - n[0] * arm[1]])
            bends.append(n @ arm * omega**2)
        rows, inverse = np.array(rows), np.diag([1.0, 1.0, 1.0 / float(self.rho) ** 2])
        load = np.array([0.0, -float(self.gravity), 0.0])
        forces = np.linalg.solve(rows @ inverse @ rows.T, np.array(bends) - rows @ load)
        return load + inverse @ rows.T @ forces
