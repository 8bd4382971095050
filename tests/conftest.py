"""Settings of all tests."""

import os
import signal

import pytest

os.environ["MPLBACKEND"] = "Agg"
pytest.register_assert_rewrite("checks")

# Tests interrupt runs that would not end. A process started in the background ignores the signal by default.
signal.signal(signal.SIGINT, signal.default_int_handler)
