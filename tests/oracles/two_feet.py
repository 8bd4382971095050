"""Two contacts with four independent rows, in plain floats: their motion event by event, and the theorem on bounded corners.

Independent of the core: numpy only. The contacts have gaps h, gap rates u and sliding velocities v; (v', u') = b + W (f, forces), with W and b in the order
tangential 1, normal 1, tangential 2, normal 2. Impacts are frictionless (Newton), one at a time.
"""

from __future__ import annotations

import math
from itertools import product

import numpy as np

#: Speeds below this share of the largest one of the start count as zero: a cutoff of the oracle, which follows impacts one by one.
CUTOFF = 1e-9


class TwoFeet:
    """W (4, 4), b (4), friction (2), restitution (2)."""

    def __init__(self, W, b, friction, restitution):
        order = [1, 3, 0, 2]
        W, b = np.asarray(W)[np.ix_(order, order)], np.asarray(b)[order]
        self.D, self.C, self.S = W[:2, :2], W[2:, :2], W[2:, 2:]
        self.g, self.p = -b[:2], b[2:]
        self.mu, self.e = list(map(float, friction)), list(map(float, restitution))
        self.W, self.b = W, b

    def forces(self, closed, moves):
        """Accelerations (normal, tangential) and letters of the first consistent mode of the closed contacts; None if there is none.

        moves: sign of the sliding velocity of each contact, or 0.
        """
        for letters in product(*(self.letters(i, closed, moves) for i in (0, 1))):
            # unknowns: normal force of each contact that stays, tangential force of each one that sticks
            columns, rows = [], []
            for i, letter in enumerate(letters):
                if letter == "S":
                    continue
                column = self.W[:, i].copy()
                if letter in (1, -1):
                    column = column - letter * self.mu[i] * self.W[:, 2 + i]
                columns.append((column, i, "n"))
                rows.append(i)
                if letter == 0:
                    columns.append((self.W[:, 2 + i], i, "t"))
                    rows.append(2 + i)
            a = self.b.copy()
            fine = True
            if columns:
                matrix = np.array(
                    [[column[row] for column, *_ in columns] for row in rows]
                )
                x = np.linalg.solve(matrix, -self.b[rows])
                normal, tangential = [0.0, 0.0], [0.0, 0.0]
                for value, (column, i, kind) in zip(x, columns, strict=True):
                    a = a + value * column
                    (normal if kind == "n" else tangential)[i] = value
                for i, letter in enumerate(letters):
                    if letter != "S":
                        fine &= normal[i] >= 0
                    if letter == 0:
                        fine &= abs(tangential[i]) <= self.mu[i] * normal[i]
            for i, letter in enumerate(letters):
                if letter == "S" and closed[i]:
                    fine &= a[i] >= 0
                if letter in (1, -1) and moves[i] == 0:
                    fine &= a[2 + i] * letter > 0
            if fine:
                return letters, a
        return None

    @staticmethod
    def letters(i, closed, moves):
        if not closed[i]:
            return ["S"]
        return [moves[i], "S"] if moves[i] else [0, 1, -1, "S"]

    def run(self, h, u, v, events=500_000):
        """ "rest", or how the motion from this start fails: "jam", "far", "long"."""
        h, u, v = list(h), list(u), list(v)
        size = max(*map(abs, u), *map(abs, v), math.sqrt(max(*h, 0.0) * max(self.g)))
        small = CUTOFF * size
        for _ in range(events):
            # impacts of this instant
            for _ in range(1_000):
                hit = [i for i in (0, 1) if h[i] == 0 and u[i] < 0]
                if not hit:
                    break
                j = min(hit, key=lambda i: u[i])
                speed = -u[j]
                if speed < small:
                    u[j] = 0.0
                    continue
                impulse = (1 + self.e[j]) * speed / self.D[j, j]
                u = [u[i] + self.D[i, j] * impulse for i in (0, 1)]
                v = [v[i] + self.C[i, j] * impulse for i in (0, 1)]
                u[j] = self.e[j] * speed
                if u[j] < small:
                    u[j] = 0.0
            near = [
                h[i] <= (100 * small) ** 2 / self.g[i] and abs(u[i]) < 100 * small
                for i in (0, 1)
            ]
            if all(near):
                h, u = [0.0, 0.0], [0.0, 0.0]
            closed = [h[i] == 0 and u[i] == 0 for i in (0, 1)]
            if all(closed) and max(map(abs, v)) < small:
                v = [0.0, 0.0]
            moves = [int(np.sign(v[i])) if closed[i] else 0 for i in (0, 1)]
            found = self.forces(closed, moves)
            if found is None:
                return "jam"
            letters, a = found
            if letters == (0, 0):
                return "rest"
            dt = math.inf
            event = None
            for i in (0, 1):
                if not (closed[i] and letters[i] != "S"):
                    lands = landing(h[i], u[i], a[i])
                    if lands < dt:
                        dt, event = lands, ("land", i)
                elif letters[i] in (1, -1) and a[2 + i] * letters[i] < 0 and v[i] != 0:
                    stops = -v[i] / a[2 + i]
                    if stops < dt:
                        dt, event = stops, ("stop", i)
            if event is None:
                return "far"
            for i in (0, 1):
                if not (closed[i] and letters[i] != "S"):
                    h[i] += dt * (u[i] + 0.5 * a[i] * dt)
                    u[i] += a[i] * dt
                v[i] += a[2 + i] * dt
                if closed[i] and letters[i] == 0:
                    v[i] = 0.0
            kind, i = event
            if kind == "land":
                h[i] = 0.0
            else:
                v[i] = 0.0
            if max(*map(abs, u), *map(abs, v)) > 1e6 * size:
                return "far"
        return "long"

    # the theorem

    def alone(self, k, letter):
        """(normal force of k, tangential acceleration of k, acceleration of the gap of the other one), k on the ground, the other one in the air."""
        m = 1 - k
        if letter:
            n = self.g[k] / (self.D[k, k] - letter * self.mu[k] * self.C[k, k])
            f = -letter * self.mu[k] * n
        else:
            n, f = np.linalg.solve(
                [[self.D[k, k], self.C[k, k]], [self.C[k, k], self.S[k, k]]],
                [self.g[k], -self.p[k]],
            )
        along = self.p[k] + self.C[k, k] * n + self.S[k, k] * f
        fits = abs(f) <= self.mu[k] * n if letter == 0 else along * letter > 0
        return fits, along, self.D[m, k] * n + self.C[k, m] * f - self.g[m]

    def presses(self):
        soft = [
            self.D[k, k] > s * self.mu[k] * self.C[k, k]
            for k in (0, 1)
            for s in (1, -1)
        ]
        return (self.g > 0).all() and all(soft)

    def goes_on(self):
        """Whether each contact has one mode from rest, the other one in the air, and the other one then falls in every mode."""
        for k in (0, 1):
            modes = {x: self.alone(k, x) for x in (0, 1, -1)}
            if sum(fits for fits, *_ in modes.values()) != 1:
                return False
            if any(lift >= 0 for x, (fits, _, lift) in modes.items() if x or fits):
                return False
        return True

    def slide(self, signs):
        A = self.D - (np.array(signs) * self.mu * self.C.T)
        n = np.linalg.solve(A, self.g)
        return (
            np.linalg.det(A),
            n,
            self.p + self.C @ n - self.S @ (np.array(signs) * self.mu * n),
        )

    def stays(self):
        found = [self.slide(signs) for signs in product((1, -1), repeat=2)]
        return all(det > 0 and (n > 0).all() for det, n, _ in found)

    def stops(self):
        """Whether friction is stronger than the forces that hold the load, in every slide: sufficient."""
        held = -np.linalg.solve(self.W, self.b)[2:]
        return all(
            self.mu[i] * self.slide(signs)[1][i] + signs[i] * held[i] > 0
            for signs in product((1, -1), repeat=2)
            for i in (0, 1)
        )


def landing(h, u, a):
    """Time until the gap h with rate u and acceleration a is zero again; infinite if it never is."""
    if h == 0 and u == 0 and a >= 0:
        return math.inf
    root = u * u - 2 * a * h
    if root < 0 or (u >= 0 and a >= 0):
        return math.inf
    if u < 0:
        return 2 * h / (math.sqrt(root) - u)
    return (u + math.sqrt(root)) / -a
