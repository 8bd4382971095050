"""Bodies, starts and options that several tests make."""

import math

import numpy as np
import standfast as sf


def with_defaults(make, **defaults):
    """``make`` with these arguments where a call gives no others."""

    def made(**given):
        return make(**(defaults | given))

    return made


def frame(slope):
    """Unit tangent and normal of ground with this slope."""
    cos, sin = math.cos(slope), math.sin(slope)
    return np.array([cos, sin]), np.array([-sin, cos])


def jacobian(posture):
    """Rows N_i = (n_i, b_i) and T_i = (t_i, −c_i) of the contacts at rest."""
    normals, tangents = [], []
    for contact in posture.contacts:
        t, n = frame(contact.slope)
        arm = np.array(contact.point) - posture.center_of_mass
        normals.append([*n, t @ arm])
        tangents.append([*t, -n @ arm])
    return np.array(normals), np.array(tangents)


def valley(left, right, width):
    """Terrain that falls with the gradient ``left`` to (0, 0) and rises with ``right``."""
    return [(-width, width * left), (0, 0), (width, width * right)]


def feet_on_slope(slope, places, frictions):
    """Contacts on one line through the origin, at these places along it."""
    t, _ = frame(slope)
    return [
        sf.Contact(point=s * t, slope=slope, friction=friction)
        for s, friction in zip(places, frictions, strict=True)
    ]


def stance(contacts, center_of_mass, gyration_radius=0.5, restitution=0.1, gravity=1.0):
    """A body of 1 kg."""
    return sf.Posture(
        1.0, gyration_radius, center_of_mass, contacts, restitution, gravity
    )


def vee(slope, friction, center_of_mass=(0, 0), *, width=1.0, height=0.0, **fields):
    """A body on two contacts in a V."""
    contacts = [
        sf.Contact((side * width, height), slope=side * slope, friction=friction)
        for side in (-1, 1)
    ]
    return stance(contacts, center_of_mass, **fields)


def paper_vee(x, y, gyration_radius=0.4, restitution=0.1):
    """The V of tan β = 8/15 with friction ½, with the centre of mass at (x, y)."""
    return vee(
        math.atan(8 / 15),
        0.5,
        (x, y),
        height=8 / 15,
        gyration_radius=gyration_radius,
        restitution=restitution,
        gravity=9.81,
    )


def odd(restitution):
    """Kinematic-strong, and yet unstable for restitutions in between."""
    contacts = [
        sf.Contact((-1, 0), slope=-0.31, friction=0.89),
        sf.Contact((1, 0.25), slope=1.16, friction=0.89),
    ]
    return stance(contacts, (0.58, 0.95), 0.38, restitution)


#: Every law of impact; all but the first have friction.
LAWS = ["newton", "poisson", "stronge", "chatterjee-ruina", "moreau"]
FRICTION_LAWS = LAWS[1:]
IN_TURN = "first-contact-first"


def order_for(law, wanted="together"):
    """The value of `simultaneous` for this law: Newton's and Moreau's are laws for all contacts that are hit at once."""
    one_by_one = law not in ("newton", "moreau")
    return IN_TURN if one_by_one and wanted == "together" else wanted


def draw_order(rng, law):
    return order_for(
        law, str(rng.choice(["together", "first-contact-first", "last-contact-first"]))
    )


def draw_contacts(rng, places, rise, steep, size=1.0, **fields):
    """Contacts at these places along x, at heights up to ``rise`` and on slopes up to ``steep``; with 0 they are on
    a level floor.

    Each other field is a function that draws a value. ``places`` may draw, too; then the contacts are drawn one after
    the other.
    """
    return [
        sf.Contact(
            point=(x, size * rng.uniform(-rise, rise) if rise else 0.0),
            slope=rng.uniform(-steep, steep) if steep else 0.0,
            **{name: draw() for name, draw in fields.items()},
        )
        for x in places
    ]


def draw_rough(rng, count, rise, steep):
    """Contacts of any friction, and some of their own restitution, at random along two metres."""
    return draw_contacts(
        rng,
        (rng.uniform(-1, 1) for _ in range(count)),
        rise,
        steep,
        friction=lambda: rng.uniform(0, 1.5) if rng.random() < 0.8 else 0.0,
        restitution=lambda: rng.uniform(0, 0.95) if rng.random() < 0.3 else None,
        tangential_restitution=lambda: (
            rng.uniform(0, 0.9) if rng.random() < 0.3 else 0.0
        ),
    )


def lift(posture, q, model="full"):
    """How far the body at ``q`` has to be moved up until no contact is below its ground line, and one is on it."""
    # The gaps of the local model are N·q.
    gaps = posture.gap_rates(np.zeros(3), q) if model == "local" else posture.gaps(q)
    return max(
        -gap / math.cos(contact.slope)
        for gap, contact in zip(gaps, posture.contacts, strict=True)
    )


def reach(points, center, gyration_radius):
    """Size of a body: the longest arm or the radius of gyration."""
    arms = np.linalg.norm(np.array(points) - np.array(center), axis=1)
    return max(gyration_radius, arms.max())


def size(posture):
    """The same of a posture."""
    points = [contact.point for contact in posture.contacts]
    return reach(points, posture.center_of_mass, posture.gyration_radius)
