"""Wrong inputs, and what is said of each: as a user reads it, whole, for a person to review."""

from pathlib import Path

import pytest
import standfast as sf

TOML = """\
gravity = 9.81
restitution = 0.1
[body]
mass = 1.0
gyration_radius = 0.2
center_of_mass = [0.0, 0.0]
[[contact]]
point = [-0.5, 0.0]
[[contact]]
point = [0.5, 0.0]
slope = 0.0
[start]
q = [0.0, 0.011, 0.002]
[run]
model = "full"
"""
JSON = """\
{"gravity": 9.81, "restitution": 0.1,
"body": {"mass": 1.0, "gyration_radius": 0.2, "center_of_mass": [0.0, 0.0]},
"contact": [
{"point": [-0.5, 0.0]},
{"point": [0.5, 0.0], "slope": 0.0}
],
"start": {"q": [0.0, 0.011, 0.002]},
"run": {"model": "full"}}
"""
BODY = "[body]\nmass = 1.0\ngyration_radius = 0.2\ncenter_of_mass = [0.0, 0.0]"
BOTH = "[[contact]]\npoint = [-0.5, 0.0]\n[[contact]]"
BOM = "\ufeff"

#: A text replaced in TOML, by what, and the message behind the name of the file.
IN_TOML = [
    # Numbers out of range.
    ("mass = 1.0", "mass = 0.0", "line 4, column 8: body.mass = 0.0 is outside its range: finite and > 0, from 1e-150 to 1e150"),
    ("gravity = 9.81", "gravity = -9.81", "line 1, column 11: gravity = -9.81 is outside its range: finite and >= 0: 0, or from 1e-150 to 1e150"),
    ("gravity = 9.81", BOM + "gravity = -9.81", "line 1, column 11: gravity = -9.81 is outside its range: finite and >= 0: 0, or from 1e-150 to 1e150"),
    ("slope = 0.0", "slope = 2.0", "line 11, column 9: contact.2.slope = 2.0 is outside its range: |slope| < pi/2, so that the normal points up"),
    ("[0.5, 0.0]", "[0.5, nan]", "line 10, column 15: contact.2.point.y = NaN is outside its range: finite, at most 1e150 in size"),
    ("slope = 0.0", "tangential_restitution = 1.0", "line 11, column 26: contact.2.tangential_restitution = 1.0 is outside its range: 0 <= tangential_restitution < 1"),
    ("slope = 0.0", "segment = [1.0, 2.0]", "line 11, column 11: contact.2.segment = (1.0, 2.0) cannot be used: low <= 0 <= high with low < high"),
    ("0.011", "inf", "line 13, column 11: start.q.y = inf is outside its range: finite, at most 1e150 in size"),
    ('model = "full"', "tolerance = 0.0", "line 15, column 13: run.tolerance = 0.0 is outside its range: finite and > 0, from 1e-150 to 1e150"),
    ("mass = 1.0", "mass = 1e999", "line 4, column 8, body.mass: floating-point number overflowed"),
    ('model = "full"', "event_limit = 99999999999999999999999", "line 15, column 15, run.event_limit: invalid type: integer `99999999999999999999999`, expected an integer >= 0"),
    # Wrong kinds of values.
    ("mass = 1.0", "mass = '1'", 'line 4, column 8, body.mass: invalid type: string "1", expected a number'),
    ('model = "full"', 'model = "ful"', "line 15, column 9, run.model: unknown variant `ful`, expected one of `auto`, `local`, `full`"),
    ('model = "full"', "model = { full = 1 }", "line 15, column 9, run.model: invalid type: table, expected a string"),
    ('model = "full"', "time_limit = { inf = 1 }", 'line 15, column 14, run.time_limit: a number, "inf" or "-inf" is needed'),
    (BODY, "body = [1.0, 0.2, [0.0, 0.0]]", "line 3, column 8, body: invalid type: array, expected a table"),
    ("[run]", "[[run]]", "line 14, column 1, run: invalid type: array, expected a table"),
    (BOTH, "[contact]", "line 7, column 1, contact: invalid type: table, expected an array of tables, each under [[contact]] in TOML"),
    # Fields that are missing, unknown or there twice.
    ("mass = 1.0\n", "", "line 3, column 1, body: missing field `mass`"),
    ("mass = 1.0", "mass = 1.0\ncolour = 1", "line 5, column 1, body.colour: unknown field `colour`, expected one of `mass`, `gyration_radius`, `center_of_mass`"),
    ("mass = 1.0", "mass = 1.0\nmass = 1.0", "line 5, column 1: duplicate key `mass`"),
    (TOML, "", "is empty"),
    ("gravity", BOM + BOM + "gravity", "line 1, column 1: invalid unquoted key, expected letters, numbers, `-`, `_`"),
]  # fmt: skip

#: As `IN_TOML`.
IN_JSON = [
    ('"mass": 1.0', '"mass": 0.0', "line 2, column 18: body.mass = 0.0 is outside its range: finite and > 0, from 1e-150 to 1e150"),
    ("0.011", "1e200", "line 7, column 22: start.q.y = 1e200 is outside its range: finite, at most 1e150 in size"),
    ("0.011", "1e999", "line 7, column 26, start.q.2: a number within the range of doubles is needed"),
    ("0.011", "NaN", "line 7, column 22, start.q.2: a value of JSON is needed; it has no NaN and no Infinity"),
    ('"mass": 1.0', '"mass": null', "line 2, column 18, body.mass: invalid type: null, expected a number"),
    ('"full"', "null", "line 8, column 18, run.model: invalid type: null, expected a string"),
    ('"full"', '{"full": null}', "line 8, column 18, run.model: invalid type: table, expected a string"),
    ('"model": "full"', '"event_limit": -1', "line 8, column 24, run.event_limit: invalid value: integer `-1`, expected an integer >= 0"),
    ('{"model": "full"}', '["full"]', "line 8, column 8, run: invalid type: array, expected a table"),
    ('{"point": [0.5, 0.0], "slope": 0.0}', "[[0.5, 0.0]]", "line 5, column 1, contact.2: invalid type: array, expected a table"),
    (JSON, "[9.81, 0.1]", "line 1, column 1: invalid type: array, expected a table"),
    ('"mass": 1.0', '"mass": 1.0, "mass": 1.0', "line 2, column 9, body: duplicate field `mass`"),
    ('"start"', "start", "line 7, column 1: key must be a string"),
]  # fmt: skip


@pytest.mark.parametrize(
    ("name", "text", "old", "new", "message"),
    [("scene.toml", TOML, *row) for row in IN_TOML]
    + [("scene.json", JSON, *row) for row in IN_JSON],
)
def test_a_wrong_scene_file(tmp_path, name, text, old, new, message):
    assert old in text
    path = tmp_path / name
    path.write_text(text.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(ValueError) as error:  # noqa: PT011
        sf.load(path)
    assert str(error.value) == f"{path}: {message}"
