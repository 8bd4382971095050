"""A body over ground of many short pieces: a flight over many of their ends is one event, and gaps are those to the pieces below."""

import numpy as np
import pytest
import standfast as sf

START = {"q": (0, 0.5, 0.2), "qdot": (0.3, 0, 0.5)}
SHAPES = {
    "hill": lambda x: -0.02 * x * x,
    "valley": lambda x: 0.02 * x * x - 0.01,
    "waves": lambda x: 0.01 * np.sin(20 * x) - 0.02,
}


def ground(shape, count=400):
    return [(x, float(SHAPES[shape](x))) for x in np.linspace(-5, 5, count)]


@pytest.mark.parametrize("shape", SHAPES)
def test_gaps_are_heights_over_the_pieces_below(shape):
    terrain = np.array(ground(shape))
    body = sf.Posture.box(1, 0.6, restitution=0.5, friction=0.4, terrain=terrain)
    run = sf.simulate(body, **START, time_limit=0.65)
    assert run.collisions > 2
    normals = np.diff(terrain, axis=0)[:, ::-1] * (-1, 1)
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    for t in np.linspace(0, run.time, 300):
        gaps = run.gaps_at(t)[: len(body.contacts)]
        for (x, y), gap in zip(run.points_at(t), gaps, strict=False):
            k = np.searchsorted(terrain[:, 0], x) - 1
            height = normals[k] @ ((x, y) - terrain[k])
            assert height > -1e-9
            # At a vertex it may still belong to the piece before.
            near = abs(normals[[k - 1, k, k + 1]] @ ((x, y) - terrain[k]) - gap)
            on_vertex = np.min(abs(terrain[:, 0] - x)) < 1e-9
            assert abs(height - gap) < 1e-11 or (on_vertex and min(near) < 1e-9)


@pytest.mark.parametrize("shape", SHAPES)
def test_a_run_has_the_same_end_with_and_without_its_record(shape):
    body = sf.Posture.box(1, 0.6, restitution=0.5, friction=0.4, terrain=ground(shape))
    runs = [
        sf.simulate(body, **START, time_limit=0.65, record=r) for r in (True, False)
    ]
    assert np.array_equal(runs[0].q, runs[1].q)
    assert runs[0].collisions == runs[1].collisions
