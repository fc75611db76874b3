"""How the command says that something is wrong: one sentence behind its name, on stderr."""

import sys


def complain(what: object) -> None:
    """Say what a user can mend."""
    print(f"ulna: {what}", file=sys.stderr)
