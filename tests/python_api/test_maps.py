"""Sweeps: every point has the results of the functions of one posture, with any number of threads, processes and chunks."""

import importlib.util
import math
import os
import pickle
import runpy
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from itertools import combinations
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pytest
import standfast as sf
import xarray
from drawn import visible_texts
from matplotlib.colors import to_rgb, to_rgba
from matplotlib.figure import Figure
from standfast._core import Sweep
from standfast.cli import main
from standfast.map_plot import COLORS

EXAMPLES = Path(__file__).parents[2] / "examples"
FIELDS = [
    "frictional_stability",
    "by",
    "equilibrium",
    "equilibrium_margin",
    "kinematic_strong",
    "kinematic_strong_strict",
    "kinematic_margin",
    "unambiguous",
    "coupling",
    "clattering",
    "clattering_margin",
    "chatter",
    "chatter_margin",
    "energy",
    "delicate",
    "amplification",
]
#: The quantities that do not need the corner map.
CHEAP = [
    name
    for name in FIELDS
    if name not in ("frictional_stability", "by", "energy", "delicate", "amplification")
]


def example(name):
    spec = importlib.util.spec_from_file_location(name, EXAMPLES / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


FIGURE = example("third_figure")
VEE = FIGURE.vee(0.4)
PLACES = {
    "center_of_mass.x": np.linspace(-1.3, 1.3, 14),
    "center_of_mass.y": np.linspace(-1.0, 3.0, 23),
}


def with_center(posture, x, y):
    return sf.Posture(
        posture.mass,
        posture.gyration_radius,
        (x, y),
        posture.contacts,
        posture.restitution,
        posture.gravity,
    )


# Every point has the result of the function of one posture.


def test_every_field_of_a_verdict_to_the_bit():
    grid = sf.sweep(VEE, PLACES, FIELDS)
    for x in PLACES["center_of_mass.x"]:
        for y in PLACES["center_of_mass.y"]:
            verdict = sf.stability(with_center(VEE, float(x), float(y)))
            point = grid.sel({"center_of_mass.x": x, "center_of_mass.y": y})
            for name in FIELDS:
                expected = getattr(verdict, name)
                if name == "amplification" and expected is None:
                    assert math.isnan(point[name].item())
                    continue
                expected = "undecided" if expected is None else expected
                assert point[name].item() == expected, (name, x, y)
    assert set(grid["frictional_stability"].values.flat) == {"stable", "unstable"}


def random_posture(random):
    """Random postures of all kinds, with ties: equal contacts, no friction, no gravity."""
    pick = random.choice
    contacts = [
        sf.Contact(
            (float(side + pick([0.0, 0.3])), float(pick([0.0, random.uniform(-1, 1)]))),
            slope=float(pick([0.0, random.uniform(-1.4, 1.4)])),
            friction=float(pick([0.0, 0.5, random.uniform(0, 3)])),
            restitution=pick([None, 0.0, 0.6]),
        )
        for side in (-1, pick([1, -1]))
    ]
    return sf.Posture(
        mass=1.0,
        gyration_radius=float(pick([0.1, 1.0, random.uniform(0.1, 2)])),
        center_of_mass=(float(pick([0.0, random.uniform(-1, 1)])), 0.5),
        contacts=contacts,
        restitution=0.1,
        gravity=float(pick([0.0, 9.81, 9.81])),
    )


def test_the_cheap_way_is_the_whole_verdict_to_the_bit():
    """Values computed without allocation and without the corner map have the same bits as those of the whole
    verdict, on random postures and on ties."""
    random = np.random.default_rng(7)
    for _ in range(300):
        posture = random_posture(random)
        verdict = sf.stability(posture)
        grid = sf.sweep(posture, {"mass": [posture.mass]}, [*CHEAP, "theorem_3"])
        for name in CHEAP:
            np.testing.assert_array_equal(
                grid[name].item(), getattr(verdict, name), err_msg=f"{name} {posture}"
            )
        strong = verdict.kinematic_strong and verdict.kinematic_margin > 1e-10
        expected = strong and verdict.clattering
        assert grid["theorem_3"].item() == expected


@pytest.mark.parametrize(
    ("path", "value", "changed"),
    [
        ("mass", 2.0, lambda p: p.mass),
        ("gyration_radius", 0.7, lambda p: p.gyration_radius),
        ("gravity", 3.0, lambda p: p.gravity),
        ("restitution", 0.4, lambda p: p.restitution),
        ("friction", 0.9, lambda p: p.contacts[1].friction),
        ("center_of_mass.x", 0.2, lambda p: p.center_of_mass[0]),
        ("center_of_mass.y", 0.2, lambda p: p.center_of_mass[1]),
        ("contacts.1.point.x", -0.8, lambda p: p.contacts[0].point[0]),
        ("contacts.2.point.y", 0.1, lambda p: p.contacts[1].point[1]),
        ("contacts.1.slope", 0.1, lambda p: p.contacts[0].slope),
        ("contacts.2.friction", 0.3, lambda p: p.contacts[1].friction),
        ("contacts.1.restitution", 0.2, lambda p: p.contacts[0].restitution),
    ],
)
def test_every_path_sets_its_number(path, value, changed):
    """If the number is set by hand, the posture has the same verdict as in the sweep, and another verdict than
    before."""
    fields = {
        "mass": VEE.mass,
        "gyration_radius": VEE.gyration_radius,
        "center_of_mass": list(VEE.center_of_mass),
        "restitution": VEE.restitution,
        "gravity": VEE.gravity,
    }
    feet = [
        {
            "point": list(c.point),
            "slope": c.slope,
            "friction": c.friction,
            "restitution": c.restitution,
        }
        for c in VEE.contacts
    ]
    *where, last = path.split(".")
    if path == "friction":
        for foot in feet:
            foot["friction"] = value
    elif where[:1] == ["contacts"]:
        foot = feet[int(where[1]) - 1]
        if where[2:] == ["point"]:
            foot["point"]["xy".index(last)] = value
        else:
            foot[last] = value
    elif where:
        fields["center_of_mass"]["xy".index(last)] = value
    else:
        fields[path] = value
    posture = sf.Posture(contacts=[sf.Contact(**foot) for foot in feet], **fields)
    assert changed(posture) == value
    assert posture != VEE
    grid = sf.sweep(VEE, {path: [value]}, CHEAP)
    verdict = sf.stability(posture)
    for name in CHEAP:
        assert grid[name].item() == getattr(verdict, name), name


def test_fate_and_zeno_time_are_those_of_simulate():
    rod = sf.Posture.rod(0.5, 0.2, 0.1)
    start = {"q": (0, 0.011, math.asin(0.002)), "qdot": (0, 0, 0)}
    values = np.linspace(0.01, 0.9, 30)
    grid = sf.sweep(
        rod, {"restitution": values}, ["fate", "zeno_time"], **start, model="full"
    )
    for e in values:
        run = sf.simulate(sf.Posture.rod(0.5, 0.2, float(e)), **start, model="full")
        point = grid.sel(restitution=e)
        assert point["fate"].item() == run.outcome
        assert point["zeno_time"].item() == run.zeno_points[0].time
    # Thrown upwards: there is no Zeno point within the time limit.
    short = sf.sweep(
        rod,
        {"restitution": [0.1]},
        ["fate", "zeno_time"],
        q=(0, 1, 0),
        qdot=(0, 0, 0),
        time_limit=0.01,
    )
    assert short["fate"].item() == "time-limit"
    assert math.isnan(short["zeno_time"].item())


def test_the_dataset_says_what_it_is():
    grid = sf.sweep(VEE, PLACES, ["stability", "clattering_margin", "equilibrium"])
    assert isinstance(grid, xarray.Dataset)
    assert dict(grid.sizes) == {"center_of_mass.x": 14, "center_of_mass.y": 23}
    assert grid["stability"].dims == ("center_of_mass.x", "center_of_mass.y")
    assert grid["equilibrium"].dtype == bool
    assert grid["clattering_margin"].dtype == np.float64
    np.testing.assert_array_equal(grid["center_of_mass.x"], PLACES["center_of_mass.x"])
    assert grid["center_of_mass.x"].attrs["units"] == "m"
    assert grid["stability"].attrs == {"long_name": "frictional stability"}
    assert grid.attrs["posture"] == repr(VEE)
    three = sf.sweep(VEE, {"friction": [0.1, 0.2], **PLACES}, "theorem_3")
    assert three["theorem_3"].shape == (2, 14, 23)


def test_words_have_codes(tmp_path):
    """Numbers of the words as the conventions CF have them: xarray draws them, and NetCDF keeps them."""
    grid = sf.sweep(VEE, PLACES, ["stability", "by", "equilibrium"])
    assert set(grid) == {"stability", "stability_code", "by", "by_code", "equilibrium"}
    for name in ("stability", "by"):
        codes = grid[f"{name}_code"]
        values, words = codes.flag_values, codes.flag_meanings.split(" ")
        assert codes.dtype == values.dtype == np.int8
        meanings = dict(zip(values.tolist(), words, strict=True))
        found = np.vectorize(meanings.get)(codes.values)
        np.testing.assert_array_equal(found, grid[name].values)
        assert codes.dims == grid[name].dims
    assert grid["stability_code"].long_name == (
        "frictional stability: 0=stable, 1=unstable, 2=undecided"
    )
    for name in ("stability_code", "equilibrium"):
        figure = Figure()
        grid[name].plot(ax=figure.subplots())
        figure.draw_without_rendering()
    line = sf.sweep(VEE, {"friction": [0.1, 0.5, 0.9]})
    (drawn,) = line["stability_code"].plot(ax=Figure().subplots())
    np.testing.assert_array_equal(drawn.get_ydata(), line["stability_code"])
    grid.to_netcdf(tmp_path / "map.nc")
    with xarray.open_dataset(tmp_path / "map.nc") as read:
        assert read.load().identical(grid)


def test_values_are_of_any_kind():
    for values in ([0.1, 0.2], (0.1, 0.2), np.array([0.1, 0.2], dtype=np.float32)):
        assert (
            sf.sweep(VEE, {"restitution": values}, "coupling").sizes["restitution"] == 2
        )
    whole = sf.sweep(VEE, {"mass": range(1, 4)}, "coupling")
    assert whole["mass"].dtype == np.float64
    view = np.linspace(0, 0.9, 10)[::-3]
    grid = sf.sweep(VEE, {"restitution": view}, "clattering_margin")
    np.testing.assert_array_equal(grid["restitution"], view)
    assert grid["clattering_margin"].diff("restitution").min() > 0


# Threads, processes, chunks


def test_nothing_depends_on_threads_chunks_or_executors():
    names = ["stability", "by", "kinematic_margin"]
    whole = sf.sweep(VEE, PLACES, names, threads=1)
    for division in (
        {"threads": 2},
        {"threads": 7, "chunk": 13},
        {"chunk": 1},
        {"chunk": 10**6},
    ):
        assert whole.identical(sf.sweep(VEE, PLACES, names, **division)), division
    with ThreadPoolExecutor(3) as executor:
        assert whole.identical(
            sf.sweep(VEE, PLACES, names, executor=executor, chunk=17)
        )


def test_processes():
    names = ["stability", "kinematic_margin"]
    whole = sf.sweep(VEE, PLACES, names)
    with ProcessPoolExecutor(2) as executor:
        assert whole.identical(
            sf.sweep(VEE, PLACES, names, executor=executor, chunk=50)
        )


@pytest.mark.filterwarnings("default")  # of libraries
def test_a_dask_cluster():
    """Two worker processes of a cluster on this machine."""
    import distributed

    whole = sf.sweep(VEE, PLACES, ["stability", "by"])
    with (
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None
        ) as cluster,
        distributed.Client(cluster) as client,
    ):
        assert len(client.scheduler_info()["workers"]) == 2
        pids = client.run(os.getpid)
        assert os.getpid() not in pids.values()
        executor = client.get_executor()
        found = sf.sweep(VEE, PLACES, ["stability", "by"], executor=executor, chunk=20)
    assert whole.identical(found)


def test_a_question_is_picklable():
    question = Sweep(
        VEE,
        list(PLACES.items()),
        ["fate", "coupling"],
        (0, 0.01, 0),
        (0, 0, 0.1),
        {"model": "local", "time_limit": 2.0},
    )
    again = pickle.loads(pickle.dumps(question))
    assert again.size == question.size == 14 * 23
    assert repr(again) == repr(question)
    for one, other in zip(question.run(0, 30), again.run(0, 30), strict=True):
        np.testing.assert_array_equal(one, other)


# The cache


class Failing(Executor):
    """A function that succeeds for some calls, then fails; it counts its calls."""

    def __init__(self, answers):
        self.answers, self.asked = answers, []

    def submit(self, function, /, *args, **kwargs):
        self.asked.append(args[1])
        future = Future()
        if len(self.asked) > self.answers:
            future.set_exception(RuntimeError("the machine is gone"))
        else:
            future.set_result(function(*args, **kwargs))
        return future


def test_an_interrupted_sweep_goes_on_where_it_was(tmp_path):
    ask = {"quantity": ["stability", "coupling"], "chunk": 25, "cache": tmp_path}
    parts = math.ceil(14 * 23 / 25)
    with pytest.raises(RuntimeError, match="gone"):
        sf.sweep(VEE, PLACES, **ask, executor=Failing(5))
    (folder,) = tmp_path.iterdir()
    assert len(list(folder.glob("*.part"))) == 5
    second = Failing(10**9)
    resumed = sf.sweep(VEE, PLACES, **ask, executor=second)
    assert len(second.asked) == parts - 5
    assert resumed.identical(sf.sweep(VEE, PLACES, ask["quantity"]))
    third = Failing(0)
    assert resumed.identical(sf.sweep(VEE, PLACES, **ask, executor=third))
    assert third.asked == []
    assert not list(folder.glob("*.tmp"))


def test_what_is_under_way_when_one_fails_is_kept(tmp_path):
    """The first chunk fails at once while the second one is running. The second chunk is finished and kept."""
    begun, failed = threading.Event(), threading.Event()

    class Two(ThreadPoolExecutor):
        def submit(self, function, /, *args, **kwargs):
            def first():
                begun.wait()
                failed.set()
                raise RuntimeError("the machine is gone")

            def second():
                begun.set()
                failed.wait()
                return function(*args, **kwargs)

            return super().submit(first if args[1] == 0 else second)

    with Two(2) as executor, pytest.raises(RuntimeError, match="gone"):
        sf.sweep(VEE, PLACES, chunk=161, cache=tmp_path, executor=executor)
    (folder,) = tmp_path.iterdir()
    assert [path.name for path in folder.glob("*.part")] == ["000000161-000000322.part"]


def test_a_broken_chunk_is_computed_again(tmp_path):
    ask = {"quantity": "coupling", "chunk": 100, "cache": tmp_path}
    whole = sf.sweep(VEE, PLACES, **ask)
    (folder,) = tmp_path.iterdir()
    one, two, three, _ = sorted(folder.glob("*.part"))
    one.write_bytes(one.read_bytes()[:-30])
    two.write_bytes(b"")
    three.write_bytes(sorted(folder.glob("*.part"))[3].read_bytes())
    assert whole.identical(sf.sweep(VEE, PLACES, **ask))
    assert whole.identical(sf.sweep(VEE, PLACES, **ask, executor=Failing(0)))


def test_what_is_no_chunk_is_computed_again(tmp_path):
    """Files that are not chunks: arrays of other kinds, of lengths beyond the memory, and pipes."""
    ask = {"quantity": "coupling", "chunk": 100, "cache": tmp_path}
    whole = sf.sweep(VEE, PLACES, **ask)
    (folder,) = tmp_path.iterdir()
    one, two, three, four = sorted(folder.glob("*.part"))
    with one.open("wb") as file:
        np.save(file, np.full(100, 7.0))
    with two.open("wb") as file:
        np.lib.format.write_array_header_1_0(
            file, {"descr": "<f8", "fortran_order": False, "shape": (10**15,)}
        )
    three.write_bytes(np.full(len(three.read_bytes()) // 8, 7.0).tobytes())
    four.unlink()
    os.mkfifo(four)
    assert whole.identical(sf.sweep(VEE, PLACES, **ask))
    assert whole.identical(sf.sweep(VEE, PLACES, **ask, executor=Failing(0)))


def test_another_question_is_another_folder(tmp_path):
    rod = sf.Posture.rod(0.5, 0.2, 0.1)
    fall = {"q": (0, 0.01, 0), "qdot": (0, 0, 0)}
    asked = [
        (VEE, {"restitution": [0.1, 0.2]}, "coupling", {}),
        (VEE, {"restitution": [0.1, 0.3]}, "coupling", {}),
        (VEE, {"restitution": [0.1, 0.2]}, "clattering", {}),
        (FIGURE.vee(0.8), {"restitution": [0.1, 0.2]}, "coupling", {}),
        (rod, {"restitution": [0.1, 0.2]}, "zeno_time", fall),
        (rod, {"restitution": [0.1, 0.2]}, "zeno_time", {**fall, "q": (0, 0.02, 0)}),
        (rod, {"restitution": [0.1, 0.2]}, "zeno_time", {**fall, "time_limit": 0.01}),
    ]
    for count, (posture, over, quantity, start) in enumerate(asked, start=1):
        cached = sf.sweep(posture, over, quantity, cache=tmp_path, **start)
        assert cached.identical(sf.sweep(posture, over, quantity, **start))
        assert len(list(tmp_path.iterdir())) == count


def test_ctrl_c_ends_a_sweep(tmp_path):
    """A run that would take hours is interrupted; chunks finished before are kept."""
    code = """
import sys
import standfast as sf
rod = sf.Posture.rod(0.5, 0.2, 0.1, friction=0.5)
print("begun", flush=True)
# With restitution .1 the rod comes to rest at once; with .999999999 it bounces for ever.
sf.sweep(rod, {"restitution": [0.1, 0.999999999]}, "fate", chunk=1, cache=sys.argv[1],
         q=(0, 1, 0.3), qdot=(0, 0, 3), event_limit=10**15)
"""
    process = subprocess.Popen(
        [sys.executable, "-c", code, str(tmp_path)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert process.stdout.readline() == "begun\n"
    limit = time.monotonic() + 60.0
    while not list(tmp_path.glob("*/*.part")) and time.monotonic() < limit:
        with pytest.raises(subprocess.TimeoutExpired):
            process.wait(0.2)
    process.send_signal(signal.SIGINT)
    _, said = process.communicate(timeout=60)
    assert "KeyboardInterrupt" in said
    (folder,) = tmp_path.iterdir()
    assert [path.name for path in folder.glob("*.part")] == ["000000000-000000001.part"]


# Refusals


@pytest.mark.parametrize(
    ("over", "said"),
    [
        ({"colour": [1.0]}, r"over = \"colour\".*gyration_radius"),
        ({"contacts.3.slope": [0.1]}, r"contacts\.3\.slope.*from 1 to 2"),
        ({"contacts.1.colour": [0.1]}, r"contacts\.1\.colour"),
        ({"mass": [1.0, -1.0]}, r"mass = -1\.0.*> 0"),
        ({"contacts.2.slope": [4.0]}, r"contacts\.2\.slope = 4\.0"),
        ({"restitution": [math.nan]}, r"restitution = NaN"),
        ({"restitution": []}, r"restitution = \[\].*at least one"),
        ({"restitution": [[0.1]]}, r"restitution = array of shape \[1, 1\]"),
        ({"restitution": 0.1}, r"restitution = array of shape \[\]"),
        ({}, "at least one parameter"),
        (
            {"friction": [0.1], "contacts.1.friction": [0.1]},
            "friction.*contacts.1.friction",
        ),
        (
            {"mass": np.ones(10**5), "gravity": np.ones(10**5)},
            "at most 100000000 points",
        ),
    ],
)
def test_wrong_grids(over, said):
    with pytest.raises(ValueError, match=said):
        sf.sweep(VEE, over)


def test_wrong_types():
    with pytest.raises(TypeError, match=r"mass = .*numbers"):
        sf.sweep(VEE, {"mass": ["heavy"]})
    with pytest.raises(TypeError, match="over = "):
        sf.sweep(VEE, [("mass", [1.0])])
    with pytest.raises(TypeError, match="executor = "):
        sf.sweep(VEE, {"mass": [1.0]}, executor=2)


def test_wrong_questions():
    over = {"mass": [1.0]}
    with pytest.raises(ValueError, match=r"quantity = \"beauty\".*theorem_3"):
        sf.sweep(VEE, over, "beauty")
    with pytest.raises(ValueError, match="at least one quantity"):
        sf.sweep(VEE, over, [])
    with pytest.raises(ValueError, match="each name is allowed only once"):
        sf.sweep(VEE, over, ["by", "by"])
    with pytest.raises(ValueError, match="q, qdot"):
        sf.sweep(VEE, over, "fate")
    with pytest.raises(ValueError, match="q, qdot"):
        sf.sweep(VEE, over, "fate", q=(0, 0, 0))
    with pytest.raises(ValueError, match='only "fate"'):
        sf.sweep(VEE, over, "by", q=(0, 0, 0), qdot=(0, 0, 0))
    with pytest.raises(ValueError, match="q, qdot"):
        sf.sweep(VEE, over, "by", model="local")
    with pytest.raises(
        TypeError, match=r"colour = 1 cannot be used: no keyword of sweep"
    ):
        sf.sweep(VEE, over, "fate", q=(0, 0, 0), qdot=(0, 0, 0), colour=1)
    for threads in (0, -1, 10**9):
        with pytest.raises(ValueError, match="threads"):
            sf.sweep(VEE, over, threads=threads)
    for chunk in (0, -3, 1.5, True):
        with pytest.raises(ValueError, match="chunk"):
            sf.sweep(VEE, over, chunk=chunk)
    with ThreadPoolExecutor(1) as executor, pytest.raises(ValueError, match="threads"):
        sf.sweep(VEE, over, threads=2, executor=executor)


def test_a_point_without_an_answer_is_named():
    rod = sf.Posture.rod(0.5, 0.2, 0.1)
    with pytest.raises(ValueError, match=r"gap.*\(at contacts\.1\.slope = -?0\.\d+"):
        sf.sweep(
            rod,
            {"contacts.1.slope": np.linspace(-0.5, 0.5, 300)},
            "fate",
            q=(0.1, 0.01, 0),
            qdot=(0, 0, 0),
        )
    one = sf.Posture(1.0, 0.2, (0, 1), [sf.Contact((0, 0))], restitution=0.1)
    with pytest.raises(ValueError, match=r"contacts.*exactly 2"):
        sf.sweep(one, {"mass": [1.0]}, "theorem_3")
    above = sf.Posture(
        1.0,
        0.5,
        (0.0, 1.0),
        [sf.Contact((-1.0, 0.0)), sf.Contact((1.0, 0.0))],
        0.1,
        terrain=[(-2, 0), (2, 0)],
    )
    assert sf.sweep(above, {"contacts.2.point.x": [0.5, 1.5]})["stability"].size == 2
    with pytest.raises(ValueError, match=r"1 contacts touch.*at contacts\.2"):
        sf.sweep(above, {"contacts.2.point.y": [0.0, 0.5]}, "theorem_3")
    with pytest.raises(ValueError, match="terrain of the posture determines it"):
        sf.sweep(above, {"contacts.2.slope": [0.0]})


def test_without_xarray_the_extra_is_named():
    code = """
import sys
sys.modules["xarray"] = None
import standfast as sf
try:
    sf.sweep(sf.Posture.rod(0.5, 0.2, 0.1), {"mass": [1.0]})
except ImportError as error:
    print(error)
"""
    said = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    assert "pip install xarray" in said.stdout


def test_a_bar_only_if_asked(capsys):
    sf.sweep(VEE, PLACES, "coupling")
    assert capsys.readouterr().err == ""
    sf.sweep(VEE, PLACES, "coupling", progress=True)
    assert "322/322" in capsys.readouterr().err


# Pictures and the command line


@pytest.mark.parametrize(
    "quantity",
    ["stability", "by", "kinematic_margin", "clattering", "equilibrium_margin"],
)
def test_a_map_is_drawn(quantity, tmp_path):
    path = tmp_path / "map.png"
    figure = sf.plot_map(sf.sweep(VEE, PLACES, quantity), posture=VEE)
    figure.savefig(path)
    assert path.read_bytes().startswith(b"\x89PNG")
    assert figure.get_figwidth() == 3.4
    axes = figure.axes[0]
    assert axes.get_xlabel() == "centre of mass x / m"
    assert axes.get_ylabel() == "centre of mass y / m"
    line = sf.plot_map(sf.sweep(VEE, {"restitution": [0.1, 0.2, 0.3]}, quantity))
    (mesh,) = line.axes[0].collections or [None]
    if mesh is not None:  # an area of visible size
        low, high = mesh.get_coordinates()[[0, -1], 0, 1]
        assert high > low
    if quantity == "stability":
        words = [text.get_text().split()[0] for text in axes.get_legend().get_texts()]
        assert words == ["stable", "unstable"]


def overlaps(figure):
    """Pairs of texts that overlap, and texts that leave the figure."""
    figure.draw_without_rendering()
    boxes = [(t.get_text(), t.get_window_extent()) for t in visible_texts(figure)]
    inside = figure.bbox.padded(1.0)
    for text, box in boxes:
        if (
            box.x0 < inside.x0
            or box.x1 > inside.x1
            or box.y0 < inside.y0
            or box.y1 > inside.y1
        ):
            yield text, "the edge"
    for (one, box), (other, second) in combinations(boxes, 2):
        if box.padded(-1.0).overlaps(second.padded(-1.0)):
            yield one, other


@pytest.mark.parametrize("given", ["a figure", "arranged axes", "axes"])
@pytest.mark.parametrize("over", [PLACES, {"friction": np.linspace(0, 1, 9)}])
@pytest.mark.parametrize("quantity", ["by", "theorem_3", "kinematic_margin", "energy"])
def test_a_map_is_readable_in_one_column(quantity, over, given):
    grid = sf.sweep(VEE, over, quantity)
    if given != "a figure":
        layout = None if given == "axes" else "constrained"
        figure = Figure(figsize=(3.4, 2.6), layout=layout)
        axes = figure.subplots()
        assert sf.plot_map(grid, axes) is axes
    else:
        figure = sf.plot_map(grid)
    assert list(overlaps(figure)) == []
    texts = [text.get_fontsize() for text in visible_texts(figure)]
    assert min(texts) >= 8.0


def test_maps_side_by_side():
    figure = sf.plot_map(sf.sweep(VEE, PLACES, ["by", "coupling", "theorem_3"]))
    assert len([axes for axes in figure.axes if axes.get_xlabel()]) == 3
    assert figure.get_figwidth() == 6.8
    assert list(overlaps(figure)) == []


def test_no_figure_is_left_open():
    """A figure that pyplot knows would be shown twice in a notebook."""
    figure = sf.plot_map(sf.sweep(VEE, PLACES, "coupling"))
    assert plt.get_fignums() == []
    assert figure._repr_png_().startswith(b"\x89PNG")


def test_colors_and_labels_of_the_caller():
    grid = sf.sweep(VEE, PLACES, ["stability", "coupling"])
    labels = {"stable": "safe", "stability": "Is it safe?", "center_of_mass.x": "x"}
    figure = sf.plot_map(grid, None, {"stable": "teal", "coupling": "magma"}, labels)
    words, numbers = figure.axes[:2]
    legend = words.get_legend()
    assert legend.get_title().get_text() == "Is it safe?"
    assert legend.get_texts()[0].get_text().startswith("safe  ")
    assert legend.get_patches()[0].get_facecolor() == to_rgba("teal")
    assert words.get_xlabel() == "x"
    assert words.get_ylabel() == "centre of mass y / m"
    assert numbers.collections[0].get_cmap().name == "magma"
    # Words of the caller's own.
    sides = np.where(grid["center_of_mass.x"] < 0, "left", "right")
    own = xarray.Dataset(
        {"side": ("center_of_mass.x", sides)},
        {"center_of_mass.x": PLACES["center_of_mass.x"]},
    )
    drawn = sf.plot_map(own, colors={"left": "red", "right": "blue"})
    texts = drawn.axes[0].get_legend().get_texts()
    assert [text.get_text() for text in texts] == ["left  50.0 %", "right  50.0 %"]
    with pytest.raises(ValueError, match=r"colors\['left'\] = None cannot be used"):
        sf.plot_map(own, colors={"right": "blue"})


@pytest.mark.parametrize(
    ("change", "error", "said"),
    [
        ({"dataset": 3}, TypeError, "dataset = 3 cannot be used: a Dataset of sweep"),
        ({"ax": 3}, TypeError, "ax = 3 cannot be used: None or matplotlib axes"),
        ({"ax": True}, ValueError, r"quantities by, coupling: .*dataset\[\['by'\]\]"),
        ({"colors": ["red"]}, TypeError, r"colors = \['red'\] cannot be used"),
        ({"labels": "x"}, TypeError, "labels = 'x' cannot be used"),
        ({"colors": {"stabel": "red"}}, ValueError, "'stabel'.*theorem-3"),
        ({"labels": {"mas": "x"}}, ValueError, "'mas'.*coupling.*friction.*mass"),
        ({"colors": {"theorem-3": "rde"}}, ValueError, "'rde' cannot be used"),
        ({"posture": 3}, TypeError, "posture = 3 cannot be used"),
    ],
)
def test_wrong_arguments_of_a_picture(change, error, said):
    over = {"mass": [1.0, 2.0], "friction": [0.1, 0.5, 0.9]}
    grid = sf.sweep(VEE, over, ["by", "coupling"])
    if change.get("ax") is True:
        change = {"ax": Figure().subplots()}
    with pytest.raises(error, match=said):
        sf.plot_map(**{"dataset": grid, **change})
    assert plt.get_fignums() == []


def test_every_word_has_a_color():
    question = Sweep(
        VEE,
        [("mass", [1.0])],
        ["stability", "by", "reason", "fate"],
        (0, 0, 0),
        (0, 0, 0),
    )
    for words in question.words:
        assert set(words) <= set(COLORS)
        assert len({COLORS[word] for word in words}) == len(words)


#: The linear RGB colours that people without one kind of cone see: Machado, Oliveira and Fernandes (2009), severity 1.
CONES = {
    "all": np.eye(3),
    "no long": [
        [0.152286, 1.052583, -0.204868],
        [0.114503, 0.786281, 0.099216],
        [-0.003882, -0.048116, 1.051998],
    ],
    "no middle": [
        [0.367322, 0.860646, -0.227968],
        [0.280085, 0.672501, 0.047413],
        [-0.011820, 0.042940, 0.968881],
    ],
    "no short": [
        [1.255528, -0.076749, -0.178779],
        [-0.078411, 0.930809, 0.147602],
        [0.004733, 0.691367, 0.303900],
    ],
}
#: From linear RGB to XYZ, relative to the white of sRGB.
TO_XYZ = np.array(
    [
        [0.4124564, 0.3575761, 0.1804375],
        [0.2126729, 0.7151522, 0.0721750],
        [0.0193339, 0.1191920, 0.9503041],
    ]
)


def seen(color, cones):
    """The colour in CIELAB as a person with these cones sees it. In CIELAB a distance of 2.3 is just visible."""
    rgb = np.array(to_rgb(color))
    linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    xyz = TO_XYZ @ np.clip(np.array(cones) @ linear, 0, 1) / TO_XYZ.sum(axis=1)
    x, y, z = np.where(xyz > 0.008856, np.cbrt(xyz), 7.787 * xyz + 16 / 116)
    return np.array([116 * y - 16, 500 * (x - y), 200 * (y - z)])


@pytest.mark.parametrize("cones", CONES)
def test_colors_differ_with_every_kind_of_vision(cones):
    question = Sweep(
        VEE,
        [("mass", [1.0])],
        ["stability", "by", "reason", "fate"],
        (0, 0, 0),
        (0, 0, 0),
    )
    for words in (*question.words, ["yes", "no"]):
        for one, other in combinations([COLORS[word] for word in words], 2):
            away = seen(one, CONES[cones]) - seen(other, CONES[cones])
            assert np.linalg.norm(away) > 15.0, (one, other)


def scene(tmp_path):
    path = tmp_path / "vee.toml"
    sf.Scene(VEE, (0, 0.01, 0.001), (0, 0, 0)).save(path)
    return path


def test_map_on_the_command_line(tmp_path, capsys):
    picture = tmp_path / "map.png"
    over = [
        "--over",
        "center_of_mass.x=-1.3:1.3:14",
        "--over",
        "center_of_mass.y=-1:3:23",
    ]
    asked = [
        "map",
        str(scene(tmp_path)),
        *over,
        "--quantity",
        "by",
        "--quantity",
        "coupling",
    ]
    assert main([*asked, "--plot", str(picture)]) == 0
    captured = capsys.readouterr()
    assert captured.err == ""
    grid = sf.sweep(VEE, PLACES, "by")
    for word, count in zip(*np.unique(grid["by"], return_counts=True), strict=True):
        line = next(
            line for line in captured.out.splitlines() if line.split()[:1] == [word]
        )
        assert line.split()[1] == str(count)
    assert "from -1.3 to 1.3 m" in captured.out
    assert picture.read_bytes().startswith(b"\x89PNG")
    fate = [
        "map",
        str(scene(tmp_path)),
        "--over",
        "friction=0:1:5",
        "--quantity",
        "fate",
    ]
    assert main(fate) == 0
    assert "outcome of the run" in capsys.readouterr().out


def test_a_map_as_netcdf(tmp_path, capsys, monkeypatch):
    path, out = scene(tmp_path), tmp_path / "map.nc"
    asked = ["map", str(path), "--over", "mass=1:2:3", "--quantity", "by"]
    assert main([*asked, "--netcdf", str(out)]) == 0
    assert capsys.readouterr().out.endswith(f"wrote {out}\n")
    grid = sf.sweep(sf.load(path).posture, {"mass": [1.0, 1.5, 2.0]}, "by")
    with xarray.open_dataset(out) as read:
        assert read.load().identical(grid)
    monkeypatch.setitem(sys.modules, "scipy", None)
    assert main([*asked, "--netcdf", str(out)]) == 2
    assert "--netcdf needs scipy: pip install scipy" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--over", "mass"], "PATH=LOW:HIGH:COUNT"),
        (["--over", "mass=1:2"], "PATH=LOW:HIGH:COUNT"),
        (["--over", "mass=1:2:0"], "PATH=LOW:HIGH:COUNT"),
        (["--over", "mass=1:nan:3"], "PATH=LOW:HIGH:COUNT"),
        (["--over", "mass=1:2:3.5"], "PATH=LOW:HIGH:COUNT"),
        (["--over", "mass=1:2:99999999999"], "at most"),
        (["--over", "mass=0:2:3"], "mass = 0.0"),
        (["--over", "colour=0:2:3"], "gyration_radius"),
        (["--over", "mass=1:2:3", "--over", "mass=1:2:3"], "given twice"),
        (["--over", "mass=1:2:3", "--quantity", "beauty"], "beauty"),
        (["--over", "mass=1:2:3", "--plot", "map.txt"], ".png"),
        ([], "over"),
    ],
)
def test_wrong_maps_on_the_command_line(tmp_path, capsys, arguments, said):
    assert main(["map", str(scene(tmp_path)), *arguments]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.count("\n") == 1
    assert said in captured.err


def test_three_parameters_are_no_picture(tmp_path, capsys):
    over = [f"--over={path}=0.1:0.2:2" for path in ("mass", "gravity", "restitution")]
    arguments = ["map", str(scene(tmp_path)), *over]
    assert main(arguments) == 0
    capsys.readouterr()
    assert main([*arguments, "--plot", str(tmp_path / "map.png")]) == 2
    assert "one or two parameters" in capsys.readouterr().err


# The paper's Fig. 3


def crossings(grid, name):
    """Heights at which a flag changes at x = 0: the middles of the steps."""
    line = grid[name].sel({"center_of_mass.x": 0.0})
    y = line["center_of_mass.y"].values
    at = np.flatnonzero(np.diff(line.values))
    return (y[at] + y[at + 1]) / 2


@pytest.mark.parametrize(
    ("rho", "clattering", "strong"),
    [
        (0.8, [-0.572366], [2.426058]),
        (0.4, [0.917984], [1.402005, 2.249340, 2.412763]),
    ],
)
def test_third_figure(rho, clattering, strong):
    points = 101
    grid = FIGURE.grid(rho, points)
    step = 4.0 / (points - 1)
    assert crossings(grid, "clattering") == pytest.approx(clattering, abs=step / 2)
    assert crossings(grid, "kinematic_strong") == pytest.approx(strong, abs=step / 2)
    # The strip |x| ≤ 289/300 at every height.
    x = grid["center_of_mass.x"]
    np.testing.assert_array_equal(
        grid["equilibrium"], (abs(x) <= 289 / 300).broadcast_like(grid["equilibrium"])
    )
    both = grid["kinematic_strong"] & grid["clattering"]
    np.testing.assert_array_equal(grid["theorem_3"], both)
    # As stated in the paper: below the terrain in (a), above it in (b).
    ground = 8 / 15 * abs(x)
    above = (both & (grid["center_of_mass.y"] > ground)).any().item()
    assert above == (rho == 0.4)
    # The verdicts of Theorem 3 remain; the sharper tests decide nearly all other postures.
    assert (grid["stability"] == "stable").where(both, True).all()
    before, after = FIGURE.silent(grid)
    assert before == pytest.approx({0.8: 0.950, 0.4: 0.662}[rho], abs=0.01)
    assert after < 0.004


def test_the_figure_is_drawn(tmp_path, capsys):
    path = tmp_path / "figure.png"
    FIGURE.main(path, points=30)
    assert path.read_bytes().startswith(b"\x89PNG")
    assert capsys.readouterr().out.count("undecided by Theorem 3") == 3


def test_jams_as_impacts_in_the_figure():
    """Where jams end by impacts, no posture is unstable by a jam, and nearly all others keep their verdict."""
    before, after = (FIGURE.grid(0.4, 60, jams) for jams in ("none", "impact"))
    jams = before["by"] == "no-solution"
    assert 0.2 < float(jams.sum() / before["equilibrium"].sum()) < 0.3
    assert not (after["by"] == "no-solution").any()
    assert (after["stability"] == before["stability"]).where(~jams, True).mean() > 0.99
    assert float((after["stability"].where(jams) == "stable").sum() / jams.sum()) > 0.9
    assert {*before["by"].values.flat, *after["by"].values.flat} <= set(FIGURE.AREAS)


def test_the_table_of_undecided_postures():
    """A row of the table in docs/maps.md is what the script prints."""
    root = Path(__file__).parents[2]
    row = runpy.run_path(str(root / "benches" / "open_postures.py"))["row"]
    page = (root / "docs" / "maps.md").read_text(encoding="utf-8").splitlines()
    assert row(0.4, 0.1) in page


# The paper's Fig. 2


def test_second_figure(tmp_path):
    """Impacts clatter to a common Zeno point exactly where (10) predicts it."""
    figure = example("second_figure")
    e, psi, found = figure.fates(60)
    above = psi > figure.clattering(e)[:, None]
    clatters = found == list(figure.KINDS).index(("2-zeno", "clatter"))
    np.testing.assert_array_equal(clatters, above)
    assert 300 < above.sum() < 600
    # Goyal's bound is the weaker one, and the bounds are those of a verdict.
    assert (figure.chatter(e) < figure.clattering(e)).all()
    rod = sf.Posture.rod(0.5, 0.3, 0.1)
    grid = sf.sweep(
        rod, {"restitution": e}, ["coupling", "clattering_margin", "chatter_margin"]
    )
    for name, bound in (
        ("clattering_margin", figure.clattering),
        ("chatter_margin", figure.chatter),
    ):
        np.testing.assert_allclose(grid["coupling"] - grid[name], bound(e), atol=1e-15)
    path = tmp_path / "figure.png"
    figure.main(path, points=20)
    assert path.read_bytes().startswith(b"\x89PNG")
    curve = [sf.theory.neimark_sacker(float(x)) for x in e]
    similar = found == list(figure.KINDS).index(("2-zeno", "self-similar"))
    assert similar.sum() > 100
    assert (psi > np.array(curve)[:, None])[similar].all()


def test_shape_chaos(tmp_path):
    """The known chaotic orbit and a periodic one; chaos occurs only where impacts keep most of their speed."""
    figure = example("shape_chaos")
    assert figure.largest_exponent(0.9, 0.22) == pytest.approx(0.199, abs=0.01)
    e, psi = 0.7, 0.7
    c = sf.theory.self_similar(e, psi)
    assert c.stable
    local = sf.LocalModel(gravity=(1, 1), psi=(psi, psi), phi=(0, 0), restitution=e)
    at_rest = local.exponents((0, c.gap), (1, c.rate)).lyapunov[0]
    assert figure.largest_exponent(e, psi) == pytest.approx(at_rest, abs=1e-3)
    e, psi, found = figure.chaos(20)
    chaotic = found > figure.CHAOS
    assert not chaotic[e < 0.8].any()
    assert chaotic[e > 0.95].mean() > 0.4
    path = tmp_path / "figure.png"
    figure.main(path, points=10)
    assert path.read_bytes().startswith(b"\x89PNG")
