"""Bodies that are thrown on stairs."""

import numpy as np
import standfast as sf

#: Without friction a body slides for as long as it is followed, at a few metres per second. It should not come to an end of the ground.
FAR = 200.0


def stairs(count, tread, rise):
    """Stairs that go down to the right from (0, 0)."""
    edges = [
        [(k * tread, -k * rise), (k * tread, -(k + 1) * rise)] for k in range(count)
    ]
    flat = [vertex for edge in edges for vertex in edge]
    return [(-FAR, 0.0), *flat, (FAR, -count * rise)]


def body(rng, **keywords):
    """A box, a convex polygon, or an L, of about half a metre."""
    kind = rng.integers(3)
    if kind == 0:
        return sf.Posture.box(rng.uniform(0.2, 1.0), rng.uniform(0.2, 1.0), **keywords)
    size = rng.uniform(0.3, 1.0)
    if kind == 1:
        # Angles that differ by less than π, so that the centre is inside.
        count = int(rng.integers(3, 7))
        angles = 2 * np.pi * (np.arange(count) + rng.uniform(-0.2, 0.2, count)) / count
        shape = 0.5 * np.stack([np.cos(angles), np.sin(angles)], 1)
        shape -= (0, shape[:, 1].min())
    else:
        shape = [(0, 0), (1, 0), (1, 0.4), (0.4, 0.4), (0.4, 1), (0, 1)]
    return sf.Posture.polygon([(size * x, size * y) for x, y in shape], **keywords)


def any_throw(rng, friction=True, sticky=False):
    """A body with any friction and restitution, q and q̇. ``sticky``: with e_t = e."""
    count, tread, rise = (
        rng.integers(3, 7),
        rng.uniform(0.3, 1.2),
        rng.uniform(0.1, 0.5),
    )
    e = float(rng.choice([0.0, rng.uniform(0, 0.7)]))
    posture = body(
        rng,
        friction=rng.uniform(0.05, 1.0) if friction else 0.0,
        restitution=e,
        tangential_restitution=e if sticky else 0.0,
        terrain=stairs(int(count), tread, rise),
    )
    q = (rng.uniform(-1, count * tread), rng.uniform(1.5, 2.5), rng.uniform(-3.1, 3.1))
    return posture, q, (rng.normal(), rng.normal(), 4 * rng.normal())


def short_throw(rng):
    """A box that falls by a few decimetres on stairs of about its own size, with little restitution: it comes to rest after few
    impacts, so that its end is not chaotic for most throws."""
    tread, rise = rng.uniform(0.4, 0.9), rng.uniform(0.1, 0.3)
    posture = sf.Posture.box(
        rng.uniform(0.3, 1.0),
        rng.uniform(0.3, 1.0),
        friction=rng.uniform(0.3, 1.0),
        restitution=float(rng.choice([0.0, rng.uniform(0, 0.3)])),
        terrain=stairs(3, tread, rise),
    )
    theta = rng.uniform(-0.8, 0.8)
    x = rng.uniform(-0.3, 3 * tread)
    width = np.ptp([c.point[0] for c in posture.contacts])
    height = np.ptp([c.point[1] for c in posture.contacts])
    # The lowest corner of the box is above the stair under its left corner.
    low = 0.5 * (width * abs(np.sin(theta)) + height * np.cos(theta))
    stair = -rise * np.clip(np.ceil((x - width) / tread), 0, 3)
    y = stair + low - height / 2 + rng.uniform(0.05, 0.4)
    return posture, (x, y, theta), (rng.uniform(-1, 1), 0.0, rng.uniform(-1.5, 1.5))
