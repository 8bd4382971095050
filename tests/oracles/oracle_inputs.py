"""Inputs of the oracle, as named in ``oracle.LOCAL_INPUTS`` and ``FULL_INPUTS``: random ones, and the same run by the
package."""

import math

import oracle
import standfast as sf


def least_coupling(e):
    """Bound of [Or & Rimon 2008, eq. 10] on ψ: clattering converges above it."""
    return (e ** (1 / 3) + e ** (2 / 3)) / (1 + e)


def draw_restitution(rng):
    """Half uniform, half uniform in the logarithm, in (.001, .9)."""
    if rng.random() < 0.5:
        return rng.uniform(0.001, 0.9)
    return math.exp(rng.uniform(math.log(0.001), math.log(0.9)))


def draw_flight(rng):
    """Gravities, gaps and rates of two contacts; heights from 1 µm to 1 m."""
    g = [9.81 * math.exp(rng.uniform(-1, 1)) for _ in range(2)]
    height = 10 ** rng.uniform(-6, 0)
    speed = math.sqrt(max(g) * height)
    h = [height * rng.random() for _ in range(2)]
    u = [speed * rng.normal() for _ in range(2)]
    return g, h, u, speed


def draw_local(rng):
    """Asymmetric couplings and gravities for which [10] holds; heights from 1 µm to 1 m."""
    e = draw_restitution(rng)
    bound = least_coupling(e)
    psi = bound + (1 - bound) * rng.uniform(0.02, 0.98)
    skew = math.exp(rng.uniform(-1.5, 1.5))
    g, h, u, speed = draw_flight(rng)
    if rng.random() < 0.2:
        # The start is right after an impact at one contact.
        i = rng.integers(2)
        h[i], u[i] = 0.0, abs(u[i])
    values = (e, *g, psi * skew, psi / skew, *rng.uniform(-2, 2, size=2))
    state = (*h, rng.uniform(-0.02, 0.02), *u, rng.normal() * speed)
    names = oracle.LOCAL_INPUTS
    return dict(zip(names, map(float, (*values, *state)), strict=True))


def draw_full(rng):
    """Bodies of about a metre, sloped terrain, [10] at the nominal posture; drops up to 10 cm."""
    while True:
        e, rho = draw_restitution(rng), rng.uniform(0.03, 0.9)
        com = rng.uniform(-0.5, 0.5), rng.uniform(0.1, 1.0)
        points = [
            (-rng.uniform(0.5, 1.2), 0.0),
            (rng.uniform(0.5, 1.2), rng.uniform(-0.2, 0.2)),
        ]
        slopes = -rng.uniform(-0.3, 0.7), rng.uniform(-0.3, 0.7)
        if rng.random() < 0.3:
            slopes = 0.0, 0.0
        v = {"e": e, "g": 9.81, "rho": rho, "x_x": com[0], "x_y": com[1]}
        for i in (0, 1):
            v[f"x{i + 1}_x"], v[f"x{i + 1}_y"] = points[i]
            v[f"alpha{i + 1}"] = slopes[i]
        height = 10 ** rng.uniform(-3, -1)
        speed = math.sqrt(9.81 * height)
        v |= {"r_x": rng.normal() * height, "r_y": height * rng.uniform(0.2, 1.5)}
        v |= {"theta": height * rng.uniform(-0.3, 0.3)}
        v |= {"v_x": speed * rng.normal(), "v_y": speed * rng.normal()}
        v |= {"omega": speed * rng.normal() * rng.random() ** 2}
        v = {name: float(v[name]) for name in oracle.FULL_INPUTS}
        motion = oracle.FullMotion(oracle.DOUBLE, v | {"r_y": v["r_y"] + 10})
        gaps = [h - 10 * n[1] for h, n in zip(motion.h, motion.n, strict=True)]
        nominal = oracle.FullMotion(
            oracle.DOUBLE, v | {"r_x": 0.0, "r_y": 1.0, "theta": 0.0}
        )
        psi = nominal.psi(0), nominal.psi(1)
        if min(psi) <= 0 or math.sqrt(psi[0] * psi[1]) <= least_coupling(e) + 1e-3:
            continue
        if min(gaps) > 1e-6:
            return v


def draw_spinning(rng):
    """Any body and terrain, rotating at up to tens of rad/s: gaps that accelerate upwards, several revolutions between
    landings, without the condition [10]."""
    while True:
        v = draw_full(rng)
        v["rho"], v["e"] = (
            float(rng.uniform(0.05, 1.5)),
            float(rng.uniform(0.001, 0.84)),
        )
        v["omega"] = float(rng.normal() * 10 ** rng.uniform(-1, 1.5))
        v["theta"] = float(rng.uniform(-1, 1) * 10 ** rng.uniform(-3, 0))
        v["r_y"] += float(rng.choice([0.0, 0.3, 1.5]))
        try:
            gaps = oracle.FullMotion(oracle.DOUBLE, v).h
        except ValueError:
            continue
        if min(gaps) > 1e-6:
            return v


def simulate_local(v):
    """Run the local model up to its first Zeno point."""
    model = sf.LocalModel(
        gravity=(v["g1"], v["g2"]),
        psi=(v["psi1"], v["psi2"]),
        phi=(v["phi1"], v["phi2"]),
        restitution=v["e"],
    )
    return model.simulate(
        gaps=(v["h1"], v["h2"]),
        rates=(v["u1"], v["u2"]),
        theta=v["theta"],
        omega=v["omega"],
        stop="zeno",
        simultaneous="first-contact-first",
    )


def simulate_full(v, **options):
    """Run the full model up to its first Zeno point."""
    contacts = [
        sf.Contact(point=(v[f"x{i}_x"], v[f"x{i}_y"]), slope=v[f"alpha{i}"])
        for i in (1, 2)
    ]
    posture = sf.Posture(
        mass=1.0,
        gyration_radius=v["rho"],
        center_of_mass=(v["x_x"], v["x_y"]),
        contacts=contacts,
        restitution=v["e"],
        gravity=v["g"],
    )
    return sf.simulate(
        posture,
        q=(v["r_x"], v["r_y"], v["theta"]),
        qdot=(v["v_x"], v["v_y"], v["omega"]),
        model="full",
        stop="zeno",
        simultaneous="first-contact-first",
        **options,
    )
