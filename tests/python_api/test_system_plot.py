"""Pictures of assemblies, checked by the objects drawn: outlines, forces in balance, rigid motions, marks by letters, and texts apart."""

import math

import matplotlib.pyplot as plt
import numpy as np
import pytest
import standfast as sf
from assemblies import G, arch, wall
from drawn import inside_and_apart
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from standfast import system_plot as plot
from standfast.scenery import joints

#: Forces and motions of small assemblies are known to 1e-9 of the largest one.
EXACT = 1e-8


def tower():
    return sf.System([sf.Block(1, 1, at=(0, k)) for k in range(6)], friction=0.6)


def stack():
    blocks = {"low": sf.Block(1, 0.5), "high": sf.Block(1, 0.5, at=(0.6, 0.5))}
    return sf.System(blocks, friction=0.6)


def between_walls():
    beside = [
        sf.SystemContact("block", None, (x, y), slope, 0.8)
        for x, slope in ((-0.5, -np.pi / 2), (0.5, np.pi / 2))
        for y in (0, 1)
    ]
    return sf.System({"block": sf.Block(1, 1)}, contacts=beside, ground=None)


def sideways(system):
    return sf.load_factor(system, acceleration=(G, 0))


def without_mode():
    factor = sideways(tower())
    return sf.results.LoadFactor(factor.system, factor.static, factor.forces, math.inf, None, False)  # fmt: skip


PICTURES = {
    "stack": lambda ax=None: stack().plot(ax=ax),
    "trough": lambda ax=None: sf.System([sf.Block(1, 1)], ground=[(-1, 1), (-0.5, 1), (-0.5, 0), (0.5, 0), (0.5, 1), (1, 1)]).plot(ax=ax),
    "forces of an arch": lambda ax=None: arch(9, 0.12).plot(forces=sf.onset(arch(9, 0.12)).forces, ax=ax),
    "no forces": lambda ax=None: stack().plot(forces=np.zeros((4, 2)), ax=ax),
    "mode of a stack": lambda ax=None: sf.onset(stack()).plot(ax=ax),
    "mode of an arch": lambda ax=None: sf.onset(arch(9, 0.1)).plot(ax=ax),
    "mode that holds": lambda ax=None: sf.onset(arch(9, 0.12)).plot(ax=ax),
    "factor of an arch": lambda ax=None: sideways(arch(9, 0.12)).plot(ax=ax),
    "factor of a wall": lambda ax=None: sideways(wall(6, 4, 0.75)).plot(ax=ax),
    "factor of a tower": lambda ax=None: sideways(tower()).plot(ax=ax),
    "factor between walls": lambda ax=None: sf.load_factor(between_walls(), acceleration=(0, -1)).plot(ax=ax),
    "factor without mode": lambda ax=None: without_mode().plot(ax=ax),
}  # fmt: skip


@pytest.fixture(autouse=True)
def _close():
    yield
    plt.close("all")


def drawn(axes, kind, color=None):
    """The lines or polygons of collections, in the order of the collections, of a colour of edges if one is given."""
    return [
        path.vertices[:-1] if kind is PolyCollection else path.vertices
        for collection in axes.collections
        if type(collection) is kind
        and (color is None or to_rgba(color) in map(tuple, collection.get_edgecolor()))
        for path in collection.get_paths()
    ]


def legend(axes):
    return [text.get_text() for text in axes.get_legend().get_texts()]


def title(axes):
    return axes.get_title(loc="left").replace("\n", " ")


def marks(axes):
    """The points (k, 2) of each entry of the legend that has markers."""
    return {line.get_label(): line.get_xydata() for line in axes.lines}


def test_bodies_names_and_contacts():
    system = stack()
    (axes,) = system.plot().axes
    bodies = drawn(axes, PolyCollection, "0.25")
    for polygon, body in zip(bodies, system.bodies.values(), strict=True):
        np.testing.assert_array_equal(polygon, body.outline)
    assert [text.get_text() for text in axes.texts] == ["low", "high"]
    (line,) = axes.lines
    np.testing.assert_array_equal(line.get_xydata(), [c.point for c in system.contacts])
    # The surface of the ground at its height, and what is below.
    ((left, right),) = drawn(axes, LineCollection, plot.SURFACE)
    assert left[0] < -0.5 < 1.1 < right[0]
    assert left[1] == right[1] == 0
    assert not drawn(between_walls().plot().axes[0], LineCollection, plot.SURFACE)


def test_a_name_without_room_is_left_out():
    named = sf.System({"a long name": sf.Block(0.1, 1), "b": sf.Block(1, 1, at=(1, 0))})
    assert [text.get_text() for text in named.plot().axes[0].texts] == ["b"]


@pytest.mark.parametrize("push", [0.0, 0.05])
def test_drawn_forces_hold_each_body(push):
    """With one scale for all: length and place of the lines balance the weight and the push of each body, and its moments."""
    system = arch(9, 0.12)
    mode = sf.onset(system, acceleration=(G, 0), factor=push)
    (axes,) = system.plot(forces=mode.forces).axes
    bars = np.array(drawn(axes, LineCollection, plot.PRESSES))
    bodies = list(system.bodies)
    weight = G * sum(body.mass for body in system.bodies.values())
    names = [c.bodies for c in system.contacts[::2]]
    grounded = [on is None for _, on in names]
    scale = weight / (bars[grounded, 1] - bars[grounded, 0])[:, 1].sum()
    left = np.zeros((9, 3))
    for (low, high), pair in zip(bars, names, strict=True):
        force = scale * (high - low)
        for name, sign in zip(pair, (1, -1), strict=True):
            if name is not None:
                x, y = (low + high) / 2 - system.bodies[name].center_of_mass
                moment = x * force[1] - y * force[0]
                left[bodies.index(name)] += sign * np.array([*force, moment])
    masses = np.array([body.mass for body in system.bodies.values()])
    left[:, :2] += G * masses[:, None] * (push, -1)
    assert abs(left).max() < EXACT * weight
    largest = scale * max(np.hypot(*(high - low)) for low, high in bars)
    assert legend(axes) == [f"force, the longest {largest:.3g} N", "line of thrust"]
    # The line of thrust joins the points where the forces act.
    thrust = np.array(drawn(axes, LineCollection, "black"))
    assert len(thrust) == 9
    middles = {tuple(p) for p in bars.mean(axis=1).round(12)}
    assert {tuple(p) for p in thrust.reshape(-1, 2).round(12)} == middles


def test_a_force_at_the_limit_of_friction_has_its_cone():
    brick = sf.System([sf.Block(2, 1)], gravity=10)  # friction 1/2
    for push, limit in ((4.9, False), (5.0, True)):
        (axes,) = brick.plot(forces=[(-push, 10), (-push, 10)]).axes
        assert bool(drawn(axes, LineCollection, plot.SLIPS)) == limit
        assert (legend(axes)[0].split(",")[0] == "at the limit of friction") == limit
    apex, one, other = drawn(axes, PolyCollection)[-1]
    edges = np.array([one, other]) - apex
    assert abs(edges[:, 0] / edges[:, 1]) == pytest.approx([0.5, 0.5])
    ((low, high),) = drawn(axes, LineCollection, plot.SLIPS)
    assert one == pytest.approx(high)
    assert (low + high) / 2 == pytest.approx(apex)
    # Contacts without friction are at no limit.
    smooth = sf.System([sf.Block(2, 1)], friction=0)
    (axes,) = smooth.plot(forces=[(0, 1), (0, 1)]).axes
    assert not drawn(axes, LineCollection, plot.SLIPS)


def test_joints_are_pairs_of_flush_sides():
    table = [(0, 0), (1, 0), (1, 1), (3, 1), (3, 0), (4, 0), (4, 2), (0, 2)]
    pointed = [(0, 0), (1, 1), (3, 1), (4, 0), (4, 2), (0, 2)]
    for corners, expected in ((table, [[0, 1], [2, 3]]), (pointed, [[0], [1]])):
        assert joints(sf.System([sf.Rigid.polygon(corners)])) == expected


def test_a_mode_moves_rigid_bodies_and_keeps_hinges():
    mode = sf.onset(arch(9, 0.101))
    (axes,) = mode.plot().axes
    moved = drawn(axes, PolyCollection, "0.25")
    rest = [body.outline for body in mode.system.bodies.values()]
    gaps = lambda p: np.hypot(*(p[:, None] - p).T)  # noqa: E731
    for one, other in zip(moved, rest, strict=True):
        np.testing.assert_allclose(gaps(one), gaps(other), atol=1e-12)
    # All are moved by one time: to first order in it, the farthest corner by a tenth of the size.
    step = [p.mean(axis=0) - q.mean(axis=0) for p, q in zip(moved, rest, strict=True)]
    motions = mode.acceleration.reshape(-1, 3)
    factor = step[4][1] / motions[4, 1]  # the keystone does not turn
    arms = [b.outline - b.center_of_mass for b in mode.system.bodies.values()]
    ways = [m[:2] + m[2] * np.stack([-a[:, 1], a[:, 0]], axis=1) for m, a in zip(motions, arms, strict=True)]  # fmt: skip
    farthest = factor * max(np.hypot(*way.T).max() for way in ways)
    assert farthest == pytest.approx(0.1 * np.ptp(np.vstack(rest), axis=0).max())
    assert title(axes) == "begins to move: 6 contacts open"
    found = marks(axes)
    assert len(found["opens (S)"]) == 2 * 6
    assert len(found["hinge (F, the other end opens)"]) == 6
    assert len(found["holds (F)"]) == mode.word.count("F") - 6


def test_arrows_of_sliding_point_where_the_body_goes():
    """A block that falls between two walls: on its left side that is along the tangent, on its right side against it."""
    mode = sf.load_factor(between_walls(), acceleration=(0, -1)).mode
    (axes,) = mode.plot().axes
    arrows = [c for c in axes.collections if hasattr(c, "U")]
    for arrow, color, x in zip(arrows, (plot.RIGHT, plot.LEFT), (-0.5, 0.5), strict=True):  # fmt: skip
        assert tuple(arrow.get_facecolor()[0]) == to_rgba(color)
        np.testing.assert_allclose(arrow.U, [0, 0], atol=1e-12)
        np.testing.assert_allclose(arrow.V, [-1, -1])
        np.testing.assert_allclose(arrow.X, [x, x])
    assert legend(axes) == ["slides right (R)", "slides left (L)", "at rest"]
    assert title(axes) == "begins to move: 4 contacts slide"


def test_bodies_that_do_not_move_have_the_colour_of_those_that_stand():
    (axes,) = sf.onset(stack()).plot().axes
    bodies = next(c for c in axes.collections if len(c.get_paths()) == 2)
    colors = [tuple(color) for color in bodies.get_facecolor()]
    assert colors == [to_rgba(plot.STANDS), to_rgba(plot.MOVES)]
    assert len(drawn(axes, PolyCollection, "0.45")) == 1


def test_a_mode_that_holds_shows_its_forces():
    mode = sf.onset(arch(9, 0.12))
    (axes,) = mode.plot().axes
    assert title(axes) == "holds"
    whole = mode.system.plot(forces=mode.forces).axes[0]
    for color in (plot.PRESSES, "black"):
        np.testing.assert_array_equal(drawn(axes, LineCollection, color), drawn(whole, LineCollection, color))  # fmt: skip


def test_a_load_factor_shows_forces_and_motion():
    factor = sideways(arch(9, 0.12))
    left, right = factor.plot().axes
    assert title(left) == f"forces hold up to {factor.static:.4g} times the load"
    assert not factor.complete
    assert title(right) == f"moves at {factor.moves:.4g} times the load: 4 contacts open"  # fmt: skip
    assert len(drawn(left, LineCollection, plot.PRESSES)) == 10
    assert len(marks(right)["opens (S)"]) == 2 * 4
    axes = Figure().subplots()
    assert factor.plot(ax=axes) is axes
    assert title(axes) == title(right)
    # Wide panels are one above the other, tall ones side by side.
    spots = [[a.get_subplotspec().rowspan.start for a in f.plot().axes] for f in (factor, sideways(tower()))]  # fmt: skip
    assert spots == [[0, 1], [0, 0]]


def test_a_load_factor_without_mode_says_so():
    (axes,) = without_mode().plot().axes
    static = sideways(tower()).static
    assert title(axes) == f"forces hold up to {static:.4g} times the load; no contact mode that moves was found"  # fmt: skip


@pytest.mark.parametrize(
    ("system", "kinds"),
    [(arch(301, 0.1), {"S": 6, "F": 598}), (wall(15, 20, 0.3), {"R": 40, "F": 1704})],
    ids=["arch", "wall"],
)
def test_hundreds_of_bodies_are_few_objects(system, kinds):
    mode = sf.onset(system, acceleration=(G, 0), factor=0.5 if "R" in kinds else 0.0)
    assert {letter: mode.word.count(letter) for letter in kinds} == kinds
    for figure in (system.plot(), system.plot(forces=mode.forces), mode.plot()):
        (axes,) = figure.axes
        bodies = len(drawn(axes, PolyCollection, "0.25"))
        assert bodies == len(system.bodies)
        assert len(axes.collections) + len(axes.lines) + len(axes.patches) < 10
        assert not axes.texts
        inside_and_apart(figure)


@pytest.mark.parametrize("name", PICTURES)
@pytest.mark.parametrize("width", [None, 3.4])
def test_no_text_overlaps(name, width):
    """In a figure of its own, and in one column of a paper."""
    if width is None:
        return inside_and_apart(PICTURES[name]())
    figure = Figure(figsize=(width, 3.6))
    PICTURES[name](figure.subplots())
    return inside_and_apart(figure)


@pytest.mark.parametrize("name", PICTURES)
def test_contract_of_pictures(name, tmp_path, caplog):
    """Nothing is left open in pyplot and nothing is logged; axes that are given are what comes back; a path is written or refused."""
    figure = PICTURES[name]()
    assert plt.get_fignums() == []
    assert figure._repr_png_().startswith(b"\x89PNG")
    assert caplog.messages == []
    axes = Figure().subplots()
    assert PICTURES[name](axes) is axes
    assert axes.figure.axes == [axes]


@pytest.mark.parametrize("make", [stack, lambda: sf.onset(stack()), lambda: sideways(tower())])  # fmt: skip
def test_files_and_wrong_arguments(make, tmp_path):
    make().plot(tmp_path / "picture.svg")
    assert (tmp_path / "picture.svg").read_bytes().startswith(b"<?xml")
    axes = Figure().subplots()
    with pytest.raises(ValueError, match=r"path = .*picture\.bmp.* a file name that ends in one of"):  # fmt: skip
        make().plot(tmp_path / "picture.bmp")
    with pytest.raises(ValueError, match=r"path = .*None is allowed with ax"):
        make().plot(tmp_path / "other.png", ax=axes)
    with pytest.raises(TypeError, match="ax = 3 cannot be used"):
        make().plot(ax=3)
    assert [path.name for path in tmp_path.iterdir()] == ["picture.svg"]


@pytest.mark.parametrize(
    ("forces", "message"),
    [
        ([(0, 1)], r"forces = .1 pairs. cannot be used: a pair for each of the 4 contacts"),
        (np.zeros((4, 3)), r"forces\.1 = "),
        ([(0, 1)] * 3 + [(0, math.inf)], r"forces\.4\.normal = inf .* finite"),
        (3, "forces = 3 .* a sequence is needed"),
    ],
)  # fmt: skip
def test_wrong_forces_are_named(forces, message):
    with pytest.raises((ValueError, TypeError), match=message):
        stack().plot(forces=forces)
