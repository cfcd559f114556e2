"""The command line starts here, with next to no imports: Ctrl-C is answered from the first line on."""

from __future__ import annotations

import atexit
import os
import signal
import sys

INTERRUPTED = 130
"""The exit code of a command that Ctrl-C ended; it is the shell's own."""


class CtrlC:
    """Answers Ctrl-C: at once while nothing has been done or all has, else by KeyboardInterrupt.

    A KeyboardInterrupt that a library swallows leaves `pressed` behind, which the exit code follows.
    """

    def __init__(self) -> None:
        self.pressed = False
        self.working = False

    def __call__(self, number: int, frame: object) -> None:
        """Handle the signal."""
        if self.pressed or not self.working:
            os._exit(INTERRUPTED)
        self.pressed = True
        raise KeyboardInterrupt

    def listen(self) -> bool:
        """Take the signal, where this process may and nobody told it to ignore Ctrl-C."""
        try:
            if signal.getsignal(signal.SIGINT) in (None, signal.SIG_IGN):
                return False
            signal.signal(signal.SIGINT, self)
        except ValueError:  # not in the main thread
            return False
        return True

    def end(self) -> None:
        """Answer no more: while the interpreter is taken down there is nobody who could."""
        signal.signal(signal.SIGINT, signal.SIG_IGN)


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
