# SPDX-License-Identifier: GPL-3.0-or-later
"""What differs between Blender 4.2 and 5.2, as far as the export sees it."""

from __future__ import annotations

import bpy
from mathutils import Color


def shader_tree(owner):
    """The node tree that a material, world or light is rendered with, or None.

    Materials and worlds always use their nodes since 5.0, lights since 5.1; reading `use_nodes` then warns.
    """
    always = bpy.app.version >= ((5, 1) if isinstance(owner, bpy.types.Light) else (5, 0))
    return owner.node_tree if always or owner.use_nodes else None


def casts_shadow(light):
    """Whether a light casts shadows; Cycles had a setting of its own until it took Blender's."""
    cycles = getattr(light, "cycles", None)
    return bool(getattr(cycles, "cast_shadow", light.use_shadow))


def temperature_color(light):
    """Linear Rec.709 colour of the light's temperature (3 floats), white where it is off or before 4.5."""
    return tuple(light.temperature_color) if getattr(light, "use_temperature", False) else (1.0, 1.0, 1.0)


def exposure(light):
    """Stops that are added to the light's power; since 4.5."""
    return getattr(light, "exposure", 0.0)


def normalizes(light):
    """Whether the power is independent of the light's size; always so before 4.5."""
    return getattr(light, "normalize", True)


def lamps_in_world():
    """Whether Cycles tells nodes of lamps places in the world, not in the lamp's space; in 4.2 and 4.3, not in 4.5."""
    return bpy.app.version < (4, 4)


def alpha_mode(image, stored):
    """How an image's colours go with alpha, as Cycles takes it.

    Since 5.2 the image's setting tells whether they are multiplied; before, it was as they are `stored`: ``"AUTO"``
    (a file says so itself), ``"STRAIGHT"`` or ``"PREMUL"``.
    """
    told = bpy.app.version >= (5, 2) or image.alpha_mode in ("CHANNEL_PACKED", "NONE")
    return image.alpha_mode if told else stored


def rounds_to_nearest():
    """Whether pictures that Cycles keeps in half floats are rounded to the nearest, and not towards 0; since 5.1."""
    return bpy.app.version >= (5, 1)


def voronoi_operation():
    """The operation of the Voronoi Texture, whose random numbers changed in 5.0."""
    return "voronoi" if bpy.app.version >= (5, 0) else "voronoi_4"


def older_voronoi():
    """Properties of the Voronoi Texture, which found the nearest point by the distance itself before 4.5."""
    return {"older": ("order",)} if bpy.app.version < (4, 5) else {}


def bump_correction(material):
    """A material's setting "Bump Map Correction", which is Cycles'; on without Cycles."""
    return bool(getattr(getattr(material, "cycles", None), "use_bump_map_correction", True))


def displacement_step():
    """Footprints of a pixel between the heights that displacement is bumped by."""
    return 0.1 if bpy.app.version >= (4, 5) else 1.0


def older_principled():
    """Properties that name what the Principled BSDF did otherwise before (`core.bsdf.principled.expand`)."""
    older = [name for name, until in (("coat", (4, 5)), ("film", (5, 0))) if bpy.app.version < until]
    return {"older": tuple(older)} if older else {}


def older_diffuse():
    """Properties of the Diffuse BSDF; before 4.3 light was not scattered again between its facets."""
    return {"older": ("facets",)} if bpy.app.version < (4, 3) else {}


def older_ies():
    """Properties of the IES Texture, whose splines began and ended at 0 before 5.0."""
    return {"older": ("ends",)} if bpy.app.version < (5, 0) else {}


def older_normals():
    """What is done otherwise on normals that nodes turn (`core.scene.Material.older`).

    Before 4.5 diffuse reflection was softened by another formula, and strands were softened and shaded by the side that
    light comes from before 5.0.
    """
    return tuple(name for name, until in (("softening", (4, 5)), ("strands", (5, 0))) if bpy.app.version < until)


def normal_map():
    """Properties of the Normal Map; since 5.1 the normal of tangent space is made a unit vector."""
    return {"unit_normal": True} if bpy.app.version >= (5, 1) else {}


def texture_coordinate():
    """Properties of Texture Coordinate; since 5.2 a bump steps by pixels over the window, however its points lie."""
    return {"window_step": "PIXEL"} if bpy.app.version >= (5, 2) else {}


def moves_background():
    """Whether the Vector pass tells how the background moves before a camera that turns or zooms; since 5.2."""
    return bpy.app.version >= (5, 2)


def blends_features():
    """Whether what a denoiser is told goes smoothly from surfaces to what they mirror; since 5.1."""
    return bpy.app.version >= (5, 1)


# Operations that Blender does not compute itself, even of constants; measured in 5.0 and 5.2.
LEFT_TO_ENGINES = {"bright_contrast", "combine_color", "hue_saturation", "invert"}
LEFT_TO_ENGINES |= {"mapping", "normal", "rgb_to_bw", "separate_color"}


def groups_convert():
    """Whether a value that varies is converted to the types of group sockets that it passes.

    Since 5.0 Blender dissolves groups before the engine sees them, and converts only what it can compute on the way:
    constants, and what follows from them by most nodes (`LEFT_TO_ENGINES`).
    """
    return bpy.app.version < (5, 0)


def boolean_kind():
    """What a boolean socket holds: before 5.0 a whole number, like an integer socket."""
    return "bool" if bpy.app.version >= (5, 0) else "int"


def working_space():
    """Name of the space that the file's colours are in; since 5.0 not always Rec.709."""
    spaces = getattr(bpy.data, "colorspace", None)
    return getattr(spaces, "working_space", "Linear Rec.709")


def has_other_working_space():
    """Whether the file's colours are in another space than Linear Rec.709."""
    return working_space() != "Linear Rec.709"


def to_working_space():
    """Matrix from Linear Rec.709 to the working space, 9 floats by rows; None where they are the same."""
    if not has_other_working_space():
        return None
    columns = [Color(unit).from_rec709_linear_to_scene_linear() for unit in ((1, 0, 0), (0, 1, 0), (0, 0, 1))]
    return tuple(column[row] for row in range(3) for column in columns)


def default_is_principled():
    """Whether what has no material is shown as Principled BSDF; as Diffuse BSDF in 4.2 and 4.3, which were measured."""
    return bpy.app.version >= (5, 0)
