# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes made for Cycles open ready: what Cycles was told is told to Zraka, once by itself and by a button.

By itself only where Zraka's own settings were never touched and Cycles' were. Cycles keeps its settings in
``scene.cycles``; without its add-on they are still in the file, as bare numbers.
"""

from __future__ import annotations

import logging

import bpy
from bpy.app.handlers import persistent

from . import preload
from .properties import ENGINE

log = logging.getLogger(__name__)

# What is read, and Cycles' defaults of 4.2 to 5.2, for where its add-on does not tell.
DEFAULTS = {
    "samples": 4096,
    "preview_samples": 1024,
    "use_adaptive_sampling": True,
    "adaptive_threshold": 0.01,
    "use_preview_adaptive_sampling": True,
    "preview_adaptive_threshold": 0.1,
    "max_bounces": 12,
    "diffuse_bounces": 4,
    "glossy_bounces": 4,
    "transmission_bounces": 12,
    "transparent_max_bounces": 8,
    "sample_clamp_direct": 0.0,
    "sample_clamp_indirect": 10.0,
    "film_exposure": 1.0,
    "film_transparent_glass": False,
    "film_transparent_roughness": 0.1,
    "pixel_filter_type": "BLACKMAN_HARRIS",
    "filter_width": 1.5,
    "seed": 0,
    "time_limit": 0.0,
}
# What Zraka has nothing like, and the value that changes nothing.
_LEFT = {
    "use_animated_seed": (False, "the animated seed"),
    "caustics_reflective": (True, "no reflective caustics"),
    "caustics_refractive": (True, "no refractive caustics"),
    "use_fast_gi": (False, "the fast GI approximation"),
}
_FILTERS = ("BOX", "GAUSSIAN", "BLACKMAN_HARRIS")  # Cycles' numbers of them
_LEAST_AUTOMATIC = 1e-3

_owner = object()
_unsaid = []


def cycles_settings(scene):
    """What a file holds of Cycles' settings.

    Parameters
    ----------
    scene : bpy.types.Scene

    Returns
    -------
    values : dict
        Of every name in `DEFAULTS`, and others that were set.
    chosen : set of str
        Names that somebody gave another value than Cycles itself does.
    """
    known = {**DEFAULTS, **{name: value for name, (value, _) in _LEFT.items()}}
    group = getattr(scene, "cycles", None)
    if group is not None:
        names = [name for name in known if hasattr(group, name)]
        values = known | {name: getattr(group, name) for name in names}
        return values, {name for name in names if group.is_property_set(name)}
    stored = {name: value for name, value in _stored(scene).items() if name in known}
    if isinstance(stored.get("pixel_filter_type"), int):
        stored["pixel_filter_type"] = _FILTERS[stored["pixel_filter_type"]]
    return known | stored, set(stored)


def _stored(scene):
    """Cycles' settings as the file has them, {} where there are none; Blender 5 keeps them apart from the user's."""
    system = scene.bl_system_properties_get() if hasattr(scene, "bl_system_properties_get") else None
    found = (system or {}).get("cycles") or scene.get("cycles")
    return dict(found) if hasattr(found, "keys") else {}


def to_zraka(values):
    """Zraka's settings, by name, that mean what Cycles' `values` mean.

    Cycles counts bounces and we hits; it limits a sample's mean channel and we their sum; its threshold 0 chooses one
    by the number of samples. Source: Blender, intern/cycles/scene/integrator.cpp.
    """
    adaptive = bool(values["use_adaptive_sampling"])
    preview = bool(values["use_preview_adaptive_sampling"])
    return {
        "samples": max(1, values["samples"]),
        "viewport_samples": values["preview_samples"] or values["samples"],  # 0 is without end
        "noise_target": _threshold(values["adaptive_threshold"], values["samples"]) if adaptive else 0.0,
        "viewport_noise_target": _threshold(values["preview_adaptive_threshold"], values["samples"])
        if preview
        else 0.0,
        "adaptive": adaptive,
        "depth": values["max_bounces"] + 1,
        "diffuse_bounces": values["diffuse_bounces"],
        "glossy_bounces": values["glossy_bounces"],
        "transmission_bounces": values["transmission_bounces"],
        "transparent_depth": values["transparent_max_bounces"],
        "clamp_direct": 3 * values["sample_clamp_direct"],
        "clamp_indirect": 3 * values["sample_clamp_indirect"],
        "exposure": values["film_exposure"],
        "film_transparent_glass": bool(values["film_transparent_glass"]),
        "film_transparent_roughness": values["film_transparent_roughness"],
        "pixel_filter": values["pixel_filter_type"],
        "filter_width": values["filter_width"],
        "seed": values["seed"],
        "time_limit": values["time_limit"],
    }


def _threshold(threshold, samples):
    return threshold or max(_LEAST_AUTOMATIC, 1 / max(samples, 1))


def take_over(scene):
    """Give Zraka what Cycles was told.

    Returns
    -------
    str
        What was taken over, and what could not be.
    """
    values, chosen = cycles_settings(scene)
    settings = to_zraka(values)
    for name, value in settings.items():
        setattr(scene.zraka, name, value)
    scene.zraka.took_over = True
    left = [words for name, (value, words) in _LEFT.items() if name in chosen and values[name] != value]
    left += _left_lights(scene)
    said = (
        f"Taken over from Cycles: {settings['samples']} samples ({settings['viewport_samples']} in viewports), "
        f"noise target {settings['noise_target']:.4g}, depth {settings['depth']}, "
        f"{_said_bounces(settings)}transparent depth {settings['transparent_depth']}, "
        f"clamping {settings['clamp_direct']:.4g} and {settings['clamp_indirect']:.4g}, "
        f"exposure {settings['exposure']:.4g}, transparent glass, filter, seed and time limit"
    )
    return f"{said}; not taken over: {', '.join(left)}" if left else said


def _said_bounces(settings):
    """The limits of one kind of bounce that are below the depth's."""
    kinds = ("diffuse", "glossy", "transmission")
    limits = {kind: settings[f"{kind}_bounces"] for kind in kinds}
    return "".join(f"{limit} {kind} bounces, " for kind, limit in limits.items() if limit < settings["depth"] - 1)


def _left_lights(scene):
    """What lights ask of Cycles and Zraka does not do."""
    lights = {thing.data for thing in scene.objects if isinstance(thing.data, bpy.types.Light)}
    deepest = scene.zraka.depth - 1
    limited = [light for light in lights if getattr(getattr(light, "cycles", None), "max_bounces", 1024) < deepest]
    return [f"max bounces of {len(limited)} lights"] if limited else []


def first_use(scene):
    """Take over Cycles' settings, if nobody has chosen Zraka's and somebody Cycles'.

    Returns
    -------
    str
        What to say of it, "" where nothing was done.
    """
    group = scene.zraka
    if any(group.is_property_set(name) for name in group.bl_rna.properties.keys() if name not in {"rna_type", "name"}):
        return ""
    _, chosen = cycles_settings(scene)
    if not chosen:
        return ""
    said = take_over(scene)
    _unsaid.append(said)
    log.info("%s: %s", scene.name, said)
    return said


def pop_unsaid():
    """What was taken over and not yet reported, a list of sentences."""
    said, _unsaid[:] = list(dict.fromkeys(_unsaid)), []
    return said


class ZRAKA_OT_take_over_cycles(bpy.types.Operator):
    """Set Zraka's samples, depths, limits and film as Cycles' are in this scene."""

    bl_idname = "zraka.take_over_cycles"
    bl_label = "Take Over Cycles Settings"
    bl_description = (
        "Set samples, noise targets, depths, clamping, exposure, transparent glass, pixel filter, seed and time limit "
        "as Cycles' are in this scene. Error and time are then what the same numbers make of them in Zraka"
    )
    bl_options = {"REGISTER", "UNDO"}  # noqa: RUF012 - Blender's own name and type

    def execute(self, context):
        """Do it, and say what was done."""
        self.report({"INFO"}, take_over(context.scene))
        return {"FINISHED"}


# -- when it happens by itself -----------------------------------------------------------------------------------------


def _look():
    """Look at every scene that Zraka renders."""
    for scene in bpy.data.scenes:
        if scene.render.engine == ENGINE and scene.library is None:
            first_use(scene)
            if not bpy.app.background:
                preload.start()


@persistent
def _on_load(*_):
    # A file load ends all subscriptions.
    _subscribe()
    _look()


@persistent
def _on_render(scene, *_):
    # Without a window the engine is chosen by an argument, which tells no subscriber.
    if bpy.app.background and scene.render.engine == ENGINE:
        first_use(scene)


def _subscribe():
    bpy.msgbus.clear_by_owner(_owner)
    bpy.msgbus.subscribe_rna(key=(bpy.types.RenderSettings, "engine"), owner=_owner, args=(), notify=_look)


def register():
    """Add the operator, and look out for scenes that come from Cycles."""
    bpy.utils.register_class(ZRAKA_OT_take_over_cycles)
    bpy.app.handlers.load_post.append(_on_load)
    bpy.app.handlers.render_init.append(_on_render)
    _subscribe()


def unregister():
    """Undo `register`."""
    bpy.msgbus.clear_by_owner(_owner)
    bpy.app.handlers.render_init.remove(_on_render)
    bpy.app.handlers.load_post.remove(_on_load)
    bpy.utils.unregister_class(ZRAKA_OT_take_over_cycles)
