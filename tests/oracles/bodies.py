"""Bodies, starts and options that several tests make."""

import math

import numpy as np
import standfast as sf


def with_defaults(make, **defaults):
    """``make`` with these arguments where a call gives no others."""

    def made(**given):
        return make(**(defaults | given))

    return made


#: Every law of impact; all but the first have friction.
LAWS = ["newton", "poisson", "stronge", "chatterjee-ruina", "moreau"]
FRICTION_LAWS = LAWS[1:]
IN_TURN = "first-contact-first"


def order_for(law, wanted="newton"):
    """What is asked for contacts that are hit at once: laws with friction take them one after the other."""
    return IN_TURN if law != "newton" and wanted == "newton" else wanted


def draw_order(rng, law):
    return order_for(
        law, str(rng.choice(["newton", "first-contact-first", "last-contact-first"]))
    )


def draw_contacts(rng, places, rise, steep, size=1.0, **fields):
    """Contacts at these places along x, at heights up to ``rise`` and on slopes up to ``steep``; 0: on a level floor.

    Each other field is a function that draws it. ``places`` may draw, too: one after the other contact is drawn.
    """
    return [
        sf.Contact(
            point=(x, size * rng.uniform(-rise, rise) if rise else 0.0),
            slope=rng.uniform(-steep, steep) if steep else 0.0,
            **{name: draw() for name, draw in fields.items()},
        )
        for x in places
    ]


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
