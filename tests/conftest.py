"""Shared by all tests."""

import os

os.environ["MPLBACKEND"] = "Agg"
