"""Checks that several tests make."""

import copy
import pickle
import re

import pytest
from mpmath import mp, mpf


def close(value, exact, rel=1e-12, scale=0):
    """``value`` is within ``rel`` of ``exact``, relative to it or to a larger scale."""
    exact = mpf(exact)
    error, size = abs(mpf(float(value)) - exact), max(abs(exact), mpf(scale))
    assert error <= rel * size, f"{value!r}: {mp.nstr(error / size, 3)} from {exact}"


def assert_refused(make, kind, words):
    """The error is of this kind, and its one short line has the words, `*` for any others."""
    with pytest.raises(kind) as error:
        make()
    message = str(error.value)
    pattern = ".*".join(re.escape(word) for word in words.split("*"))
    assert re.match(pattern, message), message
    assert "\n" not in message
    assert len(message) < 250


def assert_named(make, words):
    """A ValueError whose message has all of these words."""
    with pytest.raises(ValueError) as error:  # noqa: PT011
        make()
    for word in words:
        assert word in str(error.value)


def assert_copies(value):
    """Pickled and copied, a value equals itself and prints the same; it equals nothing else."""
    for other in (
        pickle.loads(pickle.dumps(value)),
        copy.copy(value),
        copy.deepcopy(value),
    ):
        assert other == value
        assert repr(other) == repr(value)
    assert value != 1
    assert value is not None
