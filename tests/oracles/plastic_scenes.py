"""Bodies released above level ground."""

import math

import standfast as sf
from bodies import IN_TURN


def body(xs, restitution=0.0, height=0.5, **fields):
    """A body over level ground, on contacts in one line."""
    contacts = [sf.Contact((x, 0.0), friction=0.5) for x in xs]
    rho = fields.pop("gyration_radius", 0.5)
    return sf.Posture(1.0, rho, (0.0, height), contacts, restitution, **fields)


def rod(restitution, **fields):
    return sf.Posture.rod(
        half_length=0.5, gyration_radius=0.2, restitution=restitution, **fields
    )


def local(rates=(0.1, -1.9), restitution=0.1):
    """Clattering of the local model, from an impact at contact 1 or from contact with the ground at both."""
    model = sf.LocalModel(
        gravity=(1, 1), psi=(0.9, 0.9), phi=(0.5, -0.5), restitution=restitution
    )
    return model.simulate(gaps=(0.0, 0.0 if rates[0] == 0.0 else 0.1), rates=rates)


def drop(posture, tilt=0.0, height=0.1, qdot=(0, 0, 0), **options):
    """Released above the ground, rotated by `tilt`."""
    options.setdefault("impact", "newton")
    return sf.simulate(posture, (0, height, tilt), qdot, **options)


def block():
    """Housner's block, 1 m x 3 m, tilted by 0.2 rad on its left corner; plastic impacts."""
    feet = [sf.Contact((x, 0.0), friction=0.6) for x in (-0.5, 0.5)]
    posture = sf.Posture(1.0, math.sqrt(10 / 12), (0.0, 1.5), feet, 0.0)
    c, s = math.cos(0.2), math.sin(0.2)
    q = (-0.5 + 0.5 * c - 1.5 * s, -1.5 + 0.5 * s + 1.5 * c, 0.2)
    return sf.simulate(posture, q, (0, 0, 0), impact="poisson", simultaneous=IN_TURN)
