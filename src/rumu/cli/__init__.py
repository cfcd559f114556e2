"""The command line starts here, with next to no imports: Ctrl-C is answered from the first line on."""

from __future__ import annotations

import atexit
import signal
import sys

from rumu.cli.interrupt import INTERRUPTED, CtrlC


def main(arguments: list[str] | None = None) -> None:
    """Run one command; ends with 0 (fine), 1 (refused or failed), 2 (wrong usage) or 130 (Ctrl-C)."""
    ctrl_c = CtrlC()
    before = signal.getsignal(signal.SIGINT)
    listening = ctrl_c.listen()
    if listening and arguments is None:
        atexit.register(ctrl_c.end)  # runs after all that is registered later
    from rumu.cli.commands import run

    code: object = INTERRUPTED
    try:
        ctrl_c.working = True
        code = run(sys.argv[1:] if arguments is None else arguments)
    except KeyboardInterrupt:
        ctrl_c.pressed = True
    finally:
        ctrl_c.working = False
        if listening and arguments is not None:
            signal.signal(signal.SIGINT, before)
    raise SystemExit(INTERRUPTED if ctrl_c.pressed else code)
