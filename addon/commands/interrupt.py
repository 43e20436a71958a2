# SPDX-License-Identifier: GPL-3.0-or-later
"""Ctrl-C ends a command in good order."""

from __future__ import annotations

import contextlib
import signal
import threading


@contextlib.contextmanager
def interruptible():
    """Make Ctrl-C end the render in good order; a second one ends the program as ever."""
    interrupted = threading.Event()

    def on_interrupt(number, frame):
        interrupted.set()
        signal.signal(signal.SIGINT, before)

    # Python cannot put Blender's own handler back, which it knows as None.
    before = signal.signal(signal.SIGINT, on_interrupt) or signal.SIG_DFL
    try:
        yield interrupted
    finally:
        signal.signal(signal.SIGINT, before)
