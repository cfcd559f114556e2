"""Ctrl-C: who answers it, and the exit code of a command that it ended."""

from __future__ import annotations

import os
import signal

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
