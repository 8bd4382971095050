"""The same bits on every platform: no computation uses the mathematical library of the system."""

import re
import shutil
import subprocess
import sys

import pytest
import standfast._core

# C99's functions of a double with different rounding in different libraries; sqrt, fma, fmod and similar ones are exact.
ROUNDED = re.compile(
    r"a?(cos|sin|tan)h?|atan2|sincos|cbrt|erfc?|exp(2|10|m1)?|hypot|[lt]gamma(_r)?|log(10|1p|2)?|pow"
)

# Clarabel also has exponential and power cones, which no program of standfast uses.
OF_CLARABEL = {"exp", "log", "pow"}


@pytest.mark.skipif(sys.platform != "linux", reason="reads an ELF file")
@pytest.mark.skipif(shutil.which("nm") is None, reason="needs nm")
def test_no_function_of_the_systems_libm_is_called():
    command = ["nm", "-D", "--undefined-only", standfast._core.__file__]
    listing = subprocess.run(command, check=True, capture_output=True, text=True)
    wanted = {line.split()[-1].split("@")[0] for line in listing.stdout.splitlines()}
    assert "memcpy" in wanted  # the list of symbols is not empty
    assert {name for name in wanted if ROUNDED.fullmatch(name)} <= OF_CLARABEL
