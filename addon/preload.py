# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads the modules that Rendered shading needs in a thread, so that Blender's window does not wait for them.

Nor does it wait for Python to look for garbage among them, with numpy's and Blender's some 150,000 things, which takes
45 ms and may fall into any call: what is there once all is read is left out of that (`gc.freeze`).
"""

from __future__ import annotations

import gc
import importlib
import logging
import weakref
from threading import Thread

import bpy

log = logging.getLogger(__name__)

_LOOK_EVERY = 0.02  # seconds
_MODULES = (".export.scene", ".viewport.viewport", "..core.compile", "..core.render")
_thread = None


def start():
    """Begin to read, if nobody did."""
    global _thread
    if _thread is None:
        _thread = Thread(target=_read, name="Zraka preload")  # no daemon: Python must not end while it reads
        _thread.start()


def wait():
    """Wait until it has ended, if it began: two threads that read the same modules may each wait for the other's."""
    if _thread is not None:
        _thread.join()


def finish():
    """Wait until it has ended; Python then looks for garbage everywhere again."""
    wait()
    if _thread is not None:
        gc.unfreeze()


def is_done():
    """Whether all is read, or cannot be."""
    return _thread is not None and not _thread.is_alive()


def redraw_when_done(engine):
    """Have Blender call ``engine.view_draw`` when all is read."""
    start()
    waiting = weakref.ref(engine)

    def look():
        if not is_done():
            return _LOOK_EVERY
        engine = waiting()
        try:
            if engine is not None:
                engine.tag_redraw()
        except ReferenceError:  # Blender deleted the engine
            pass
        return None

    bpy.app.timers.register(look, first_interval=_LOOK_EVERY, persistent=True)


def _read():
    try:
        for name in _MODULES:
            importlib.import_module(name, __package__)
    except ImportError:
        log.debug("what is missing is said where it is wanted", exc_info=True)
    else:
        gc.freeze()
