"""Runs as tables, and runs that are saved and loaded again."""

import json
import re

import numpy as np
import pytest
import standfast as sf
from motion.test_forces import draw

LOCAL = sf.LocalModel(gravity=(10, 10), psi=(0.2, 0.2), phi=(0.1, 0.2), restitution=0.5)


def runs(count):
    """Random runs of all models and laws, with terrain and without."""
    for seed in range(count):
        posture, q, qdot, options = draw(np.random.default_rng([1804, seed]))
        yield sf.simulate(posture, q, qdot, **options)


def without_body():
    return LOCAL.simulate(gaps=(5, 20), rates=(0, 0), theta=0.1, omega=0.2)


@pytest.fixture
def rod():
    rod = sf.Posture.rod(half_length=0.5, gyration_radius=0.2, restitution=0.1)
    return sf.simulate(rod, q=(0, 0.011, 0.002), qdot=(0, 0, 0))


def test_a_dataset_has_the_values_of_the_run():
    for run in [*runs(40), without_body()]:
        data = run.to_xarray()
        times = data.time.values
        assert times[0] == 0.0
        assert times[-1] == run.time
        assert (np.diff(times) > 0).all()
        assert set(run.impacts["time"]) <= set(times)
        assert {phase.start for phase in run.phases} <= set(times)
        q, qdot = run.at(times)
        gaps, rates = run.gaps_at(times), run.gap_rates_at(times)
        for name, values in {
            "q": q,
            "qdot": qdot,
            "gaps": gaps,
            "rates": rates,
            "points": run.points_at(times),
            "forces": run.forces_at(times),
        }.items():
            np.testing.assert_array_equal(data[name].values, values)
            assert data[name].attrs["units"]
        for phase in run.phases:
            part = data.sel(time=(data.time >= phase.start) & (data.time < phase.end))
            assert (part["mode"] == list(phase.mode)).all()
        # Only contacts on the ground have forces.
        pushed = (data.forces != 0).any("direction") & data.forces.notnull().all(
            "direction"
        )
        sums = {z.time for z in run.zeno_points if z.method in ("nested", "mixed")}
        if not sums:
            assert (data["mode"].values[pushed.values] != "S").all()
        assert data.attrs["outcome"] == run.outcome
        assert ("posture" in data.attrs) == (run.posture is not None)


def test_a_dataset_at_given_times(rod):
    data = rod.to_xarray([0.0, rod.time])
    assert data.forces.dims == ("time", "contact", "direction")
    assert data.points.dims == ("time", "contact", "axis")
    np.testing.assert_array_equal(data["mode"], [["S", "S"], ["F", "F"]])
    np.testing.assert_array_equal(data.contact, [1, 2])
    assert data.q.sel(coordinate="theta", time=0.0) == 0.002
    with pytest.raises(ValueError, match=r"t = array of shape \(1, 1\)"):
        rod.to_xarray([[0.0]])
    with pytest.raises(ValueError, match=r"t = .*from 0\.0 on"):
        rod.to_xarray([-1.0])


def test_a_dataset_is_written_to_a_file_and_read_again(rod, tmp_path):
    xarray = pytest.importorskip("xarray")
    data = rod.to_xarray()
    pytest.importorskip("scipy")
    data.to_netcdf(tmp_path / "run.nc", engine="scipy")
    with xarray.open_dataset(tmp_path / "run.nc", engine="scipy") as same:
        for name in ("q", "forces", "gaps"):
            np.testing.assert_array_equal(same[name], data[name])
            assert same[name].attrs == data[name].attrs


def test_the_table_of_impacts():
    pandas = pytest.importorskip("pandas")  # xarray needs it
    for run in [*runs(20), without_body()]:
        table, hits = run.impact_table(), run.impacts
        assert all(column.shape == hits.shape for column in table.values())
        for name in ("time", "elapsed", "contact"):
            np.testing.assert_array_equal(table[name], hits[name])
        for k, hit in enumerate(hits):
            assert table["rate_before"][k] == hit["rates_before"][hit["index"]]
            assert table["rate_after"][k] == hit["rates_after"][hit["index"]]
        impulse = np.stack(
            [table["impulse_tangential"], table["impulse_normal"]], axis=1
        )
        np.testing.assert_array_equal(impulse, hits["impulse"])
        columns = 7 if run.posture is None else 9
        assert pandas.DataFrame(table).shape == (len(hits), columns)


def test_the_table_says_where_the_body_is_hit():
    """The corner, turned about the centre of mass and moved with it."""
    box = sf.Posture.box(0.3, 0.5, friction=0.5, restitution=0.3)
    run = sf.simulate(box, (0, 0.6, 0.4), (1.5, 0.5, -3), impact="moreau")
    table = run.impact_table()
    for time, contact, x, y in zip(
        *(table[name] for name in ("time", "contact", "x", "y")), strict=True
    ):
        rx, ry, theta = run.at(time)[0]
        arm = np.subtract(box.contacts[contact - 1].point, box.center_of_mass)
        place = complex(*box.center_of_mass) + complex(rx, ry)
        place += complex(*arm) * np.exp(1j * theta)
        assert (x, y) == pytest.approx((place.real, place.imag), abs=1e-12)


def test_runs_are_loaded_to_the_bit(tmp_path):
    path = tmp_path / "run.json"
    for run in [*runs(50), without_body()]:
        run.save(path)
        same = sf.Run.load(path)
        assert same.to_dict() == run.to_dict()
        assert same.impacts.tobytes() == run.impacts.tobytes()
        times = run.sample(20)[0]
        for ask in ("forces_at", "points_at", "energy"):
            one, other = getattr(run, ask)(times), getattr(same, ask)(times)
            assert one.tobytes() == other.tobytes()
        text = path.read_text(encoding="utf-8")
        same.save(path)
        assert path.read_text(encoding="utf-8") == text


def test_a_run_that_was_not_recorded_is_loaded(tmp_path, rod):
    path = tmp_path / "run.json"
    bare = sf.simulate(rod.posture, (0, 0.011, 0.002), (0, 0, 0), record=False)
    bare.save(path)
    assert sf.Run.load(path).to_dict() == bare.to_dict()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda told: told.update(outcome="zeno"), r'outcome = "zeno" .*has "rest"'),
        (
            lambda told: told["q"].__setitem__(1, np.nextafter(told["q"][1], 1)),
            r"q\.2 = .* cannot be used: the run from this start has",
        ),
        (
            lambda told: told["impacts"][2].update(contact=7),
            r"impacts\.3\.contact = 7",
        ),
        (lambda told: told["impacts"].pop(), r"impacts = 8 entries .*9 entries"),
        (lambda told: told.update(colour="red"), r'colour = "red" .*has null'),
        (lambda told: told["posture"].update(mass=-1.0), r"line \d+, .*mass = -1\.0"),
        (
            lambda told: told["options"].update(stop="never"),
            r"line \d+, .*options\.stop",
        ),
        (lambda told: told.pop("start"), "holds no run: .*missing field `start`"),
        (lambda told: told.update(posture=None), "start = given .*posture"),
    ],
)
def test_a_changed_file_is_refused_by_name(tmp_path, rod, change, message):
    path = tmp_path / "run.json"
    told = rod.to_dict()
    change(told)
    path.write_text(json.dumps(told, indent=2), encoding="utf-8")
    with pytest.raises(ValueError, match=re.escape(str(path)) + ".*" + message):
        sf.Run.load(path)


def test_sentences_may_be_worded_differently(tmp_path, rod):
    path = tmp_path / "run.json"
    told = rod.to_dict() | {"model_reason": "because", "warnings": ["none"]}
    path.write_text(json.dumps(told), encoding="utf-8")
    assert sf.Run.load(path).model_reason == rod.model_reason


def test_other_files_are_refused(tmp_path):
    with pytest.raises(FileNotFoundError):
        sf.Run.load(tmp_path / "nothing.json")
    with pytest.raises(ValueError, match="is a directory, not a file of a run"):
        sf.Run.load(tmp_path)
    scene = tmp_path / "scene.json"
    posture = sf.Posture.rod(half_length=0.5, gyration_radius=0.2, restitution=0.1)
    sf.Scene(posture, (0, 0, 0), (0, 0, 0)).save(scene)
    with pytest.raises(ValueError, match=r"scene\.json: holds no run: "):
        sf.Run.load(scene)
