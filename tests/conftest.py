"""Shared by all tests."""

import os
import signal

import pytest

os.environ["MPLBACKEND"] = "Agg"
pytest.register_assert_rewrite("checks")

# Tests interrupt runs that would not end by themselves; a process started in the background ignores that.
signal.signal(signal.SIGINT, signal.default_int_handler)
