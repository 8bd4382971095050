"""Records of the ground from files."""

import numpy as np
import pytest
import standfast as sf

SAMPLES = [0.0, 1e-3, -0.25, 0.125, 0.5, -0.0625, 0.0]
HEADS = {
    "words first": "NPTS=      7, DT=   .0050 SEC,",
    "numbers first": "     7    0.0050    NPTS, DT",
}


def peer(head, samples=SAMPLES):
    rows = [samples[:5], samples[5:]]
    text = ["PEER STRONG MOTION DATABASE", "A QUAKE, 90", "ACCELERATION IN UNITS OF G", head]  # fmt: skip
    return "\n".join([*text, *["".join(f"{x:15.7E}" for x in row) for row in rows]])


@pytest.mark.parametrize("head", HEADS.values(), ids=HEADS)
def test_a_file_of_peer(tmp_path, head):
    path = tmp_path / "quake.AT2"
    path.write_text(peer(head) + "\n")
    times, acceleration = sf.read_record(path)
    np.testing.assert_array_equal(times, np.arange(7) * 0.005)
    np.testing.assert_allclose(acceleration, np.multiply(SAMPLES, 9.80665), rtol=1e-15)


@pytest.mark.parametrize(
    "text",
    [
        "t,a\n0,1\n0.1,2e0\n\n0.2,-3\n",
        "# a record\n0 1 # first\n.1\t2\n0.2   -3.",
        "time; acc\n0;1\n0.1;2;\n0.2;-3\n",
    ],
)
@pytest.mark.parametrize(("unit", "factor"), [("g", 9.80665), ("m/s^2", 1), ("cm/s^2", 0.01)])  # fmt: skip
def test_columns(tmp_path, text, unit, factor):
    path = tmp_path / "quake.txt"
    path.write_text(text)
    times, acceleration = sf.read_record(str(path), unit=unit)
    np.testing.assert_array_equal(times, [0, 0.1, 0.2])
    np.testing.assert_allclose(
        acceleration, np.multiply([1, 2, -3], factor), rtol=1e-15
    )


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("a.at2", peer("nothing"), "the first 4 lines have no NPTS= and DT="),
        ("a.AT2", peer(HEADS["words first"], SAMPLES[:-1]), "6 samples, but NPTS = 7"),
        ("a.at2", peer(HEADS["words first"]) + " x", "line 6: 'x' is no number"),
        ("a.csv", "time,a\n", "no line begins with a number"),
        ("a.csv", "0,1\n1,2,3\n", "line 2: 3 columns; two are needed"),
        ("a.csv", "0,1\n1,nan\n", "line 2: 'nan' is no number"),
        ("a.csv", "0,1\n0,2\n", "line 2: time 0.0 s after 0.0 s; increasing times"),
    ],
)
def test_wrong_files_are_refused(tmp_path, name, text, message):
    path = tmp_path / name
    path.write_text(text)
    with pytest.raises(ValueError, match=message) as refusal:
        sf.read_record(path)
    assert str(path) in str(refusal.value)


def test_wrong_units_and_missing_files(tmp_path):
    with pytest.raises(ValueError, match=r"unit = 'ft' cannot be used: one of 'g', 'm/s\^2', 'cm/s\^2'"):  # fmt: skip
        sf.read_record(tmp_path / "a.csv", unit="ft")
    with pytest.raises(FileNotFoundError):
        sf.read_record(tmp_path / "none.csv")


def test_one_number_for_each_time_is_horizontal():
    times, along = [0, 1, 2], [0.5, -0.5, 0]
    assert sf.GroundMotion(times, along) == sf.GroundMotion(
        times, [(a, 0) for a in along]
    )
    assert sf.GroundMotion(times, np.array(along)) == sf.GroundMotion(times, along)
    with pytest.raises(TypeError, match=r"acceleration\.2"):
        sf.GroundMotion(times, [1, "x", 0])
