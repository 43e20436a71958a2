# SPDX-License-Identifier: GPL-3.0-or-later
"""Ctrl-C while the command renders: ``blender --python interrupt_command.py --command zraka render ...``."""

from __future__ import annotations

import os
import signal
import threading
import time


def interrupt():
    while not getattr(signal.getsignal(signal.SIGINT), "__module__", "").startswith("bl_ext."):
        time.sleep(0.1)
    time.sleep(2)
    os.kill(os.getpid(), signal.SIGINT)


threading.Thread(target=interrupt, daemon=True).start()
