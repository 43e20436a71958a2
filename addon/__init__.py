# SPDX-License-Identifier: GPL-3.0-or-later
"""Everything that touches Blender.

Nothing is imported before `register`, so that the command line answers a wrong argument without starting Blender.
"""

import atexit

_registered = []


def register():
    """Add the engine, its settings, its panels and its command to Blender; once is enough, twice does no harm."""
    if _registered:
        return
    import bpy

    from . import (
        cli,
        compare,
        denoise,
        engine,
        error_curve,
        preferences,
        presets,
        properties,
        takeover,
        ui,
        view_layer,
    )

    if not bpy.app.binary_path:
        # Blender as a module crashes at its end (4.2) over classes that are still registered.
        atexit.register(unregister)
    for module in (
        properties,
        preferences,
        engine,
        takeover,
        compare,
        error_curve,
        presets,
        ui,
        denoise,
        view_layer,
        cli,
    ):
        module.register()
        _registered.append(module)


def unregister():
    """Take them out again, the last one first."""
    while _registered:
        _registered.pop().unregister()
