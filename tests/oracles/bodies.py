"""Bodies and starts that several tests make."""

import math

import numpy as np


def with_defaults(make, **defaults):
    """``make`` with these arguments where a call gives no others."""

    def made(**given):
        return make(**(defaults | given))

    return made


def lift(gaps, contacts):
    """How far a body has to be moved up until no contact is below its ground line, and one is on it."""
    return max(
        -gap / math.cos(contact.slope)
        for gap, contact in zip(gaps, contacts, strict=True)
    )


def reach(points, center, gyration_radius):
    """Size of a body: the longest arm or the radius of gyration."""
    arms = np.linalg.norm(np.array(points) - np.array(center), axis=1)
    return max(gyration_radius, arms.max())


def size(posture):
    """The same of a posture."""
    points = [contact.point for contact in posture.contacts]
    return reach(points, posture.center_of_mass, posture.gyration_radius)
