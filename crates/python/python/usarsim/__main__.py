"""The program `usarsim`: `python -m usarsim serve`."""

from __future__ import annotations

import signal
import sys

from . import _native


def main() -> int:
    """Runs the program with the arguments of this process, and returns its exit code."""
    # The program runs outside of Python, which would only note Ctrl-C.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    return _native.main(["usarsim", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
