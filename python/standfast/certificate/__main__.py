"""Checks the certificates in files: `python -m standfast.certificate FILE`."""

import sys
from collections.abc import Iterable
from pathlib import Path

from . import check, read, summary


def main(arguments: Iterable[str]) -> int:
    """Checks the certificates in files; 0 if all hold."""
    code = 0
    for name in arguments:
        try:
            certificate = read(Path(name))
            check(certificate)
            print(f"{name}: {summary(certificate)}")
        except (ValueError, OSError) as error:
            print(f"{name}: {error}", file=sys.stderr)
            code = 2
    return code


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
