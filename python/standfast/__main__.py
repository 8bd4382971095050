"""The command line, as `python -m standfast`."""

import sys

from .cli import main

sys.exit(main())
