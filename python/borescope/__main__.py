"""The command ``borescope``."""

import signal
import sys

from borescope import _borescope


def main() -> None:
    """Run the command line of the program, and end with its status."""
    # The command has its own way to end at Ctrl-C.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    sys.exit(_borescope.command(["borescope", *sys.argv[1:]]))


if __name__ == "__main__":
    main()
