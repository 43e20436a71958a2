# SPDX-License-Identifier: GPL-3.0-or-later
"""Presets of sampling, the way Blender keeps its own; ``zraka/sampling`` holds those that come with Zraka."""

from __future__ import annotations

from pathlib import Path

import bpy
from bl_operators.presets import AddPresetBase
from bl_ui.utils import PresetPanel

FOLDER = "zraka/sampling"
VALUES = (
    "samples viewport_samples noise_target viewport_noise_target adaptive time_limit depth diffuse_bounces "
    "glossy_bounces transmission_bounces transparent_depth clamp_direct clamp_indirect pixel_filter filter_width"
).split()


class ZRAKA_OT_sampling_preset_add(AddPresetBase, bpy.types.Operator):
    """Add or remove a preset of samples, limits, depths and pixel filter."""

    bl_idname = "zraka.sampling_preset_add"
    bl_label = "Add Sampling Preset"
    bl_description = "Add a preset of samples, limits, depths and pixel filter, or remove the one chosen"
    preset_menu = "ZRAKA_PT_sampling_presets"
    preset_defines = ["zraka = bpy.context.scene.zraka"]  # noqa: RUF012 - Blender's own names and types
    preset_values = [f"zraka.{name}" for name in VALUES]  # noqa: RUF012
    preset_subdir = FOLDER


class ZRAKA_PT_sampling_presets(PresetPanel, bpy.types.Panel):
    """The menu in the header of *Sampling*."""

    bl_label = "Sampling Presets"
    preset_subdir = FOLDER
    preset_operator = "script.execute_preset"
    preset_add_operator = ZRAKA_OT_sampling_preset_add.bl_idname
    COMPAT_ENGINES = {"ZRAKA"}  # noqa: RUF012


CLASSES = (ZRAKA_OT_sampling_preset_add, ZRAKA_PT_sampling_presets)


def register():
    """Add the menu, and where Blender finds Zraka's own presets."""
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.utils.register_preset_path(_home())


def unregister():
    """Remove them; presets of the user's stay."""
    bpy.utils.unregister_preset_path(_home())
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)


def _home():
    """The folder in which Blender looks for one of the name ``presets``."""
    return str(Path(__file__).resolve().parents[1])
