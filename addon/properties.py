# SPDX-License-Identifier: GPL-3.0-or-later
"""The scene's and the objects' settings, and how they become `core.settings.Settings`."""

from __future__ import annotations

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty

from ..core.settings import Settings
from ..core.visibility import UNLIMITED
from .preferences import preferred_processes, preferred_threads

ENGINE = "ZRAKA"
"""What ``scene.render.engine`` is where Zraka renders."""

METHODS = (
    ("PHONG", "Phong", "Ambient, diffuse and specular light of every lamp; no shadows, no secondary rays: the fastest"),
    ("RAYCAST", "Ray Casting", "Phong where a shadow ray finds the lamp free: hard shadows at one ray a lamp more"),
    ("RAYTRACE", "Ray Tracing", "Ray casting and mirror and refracted rays, to the depth chosen: no soft light"),
    ("PATHTRACE", "Path Tracing", "All light, by random paths: right on average, and noise falls with samples"),
)
FILTERS = (
    ("BOX", "Box", "The mean over the pixel: sharp, with steps along bright edges"),
    ("GAUSSIAN", "Gaussian", "A bell of the width below: soft edges"),
    ("BLACKMAN_HARRIS", "Blackman-Harris", "A bell that ends at the width below, as in Cycles by default"),
)
BAKES = (
    ("COMBINED", "Combined", "All light that leaves the surface"),
    ("AO", "Ambient Occlusion", "How much of the hemisphere is free, within the world's distance"),
    ("POSITION", "Position", "Place in the world; needs few samples"),
    ("NORMAL", "Normal", "Shading normal, with textures and bumps; needs few samples"),
    ("UV", "UV", "The active UV map; needs few samples"),
    ("ROUGHNESS", "Roughness", "Mean roughness of what reflects; needs few samples"),
    ("EMIT", "Emit", "Light that the surface emits itself; needs few samples"),
    ("ENVIRONMENT", "Environment", "The world in the direction of each point, seen from the world's centre"),
    ("DIFFUSE", "Diffuse", "Light that is reflected diffusely, or its colour"),
    ("GLOSSY", "Glossy", "Light that is reflected as gloss, or its colour"),
    ("TRANSMISSION", "Transmission", "Light that comes through the surface, or its colour"),
)
BOUNCES = ("diffuse_bounces", "glossy_bounces", "transmission_bounces")
ALL_BOUNCES = 1024
"""A limit of one kind of bounce that is none."""
OVERRIDES = ("reflectivity", "transparency", "ior", "exponent", "ambient")
SAME_NAME = (
    "samples depth transparent_depth seed time_limit noise_target adaptive clamp_direct clamp_indirect filter_width "
    "exposure tile"
).split()


def _tell(group, _):
    """Tell Rendered shading of a setting that a script changed; Blender does so for its own buttons only."""
    if not group.id_data.is_evaluated:
        group.id_data.update_tag()


def _override(name):
    description = f"Give every material the same {name}"
    return BoolProperty(name=f"Override {name}", description=description, default=False, update=_tell)


def _bounces(kind, what):
    return IntProperty(
        name=f"{kind} Bounces",
        description=f"{what} along a path, as in Cycles; {ALL_BOUNCES} leaves all to the depth. "
        "A small number loses light (too dark) and saves time",
        default=ALL_BOUNCES,
        min=0,
        max=ALL_BOUNCES,
        update=_tell,
    )


class ZrakaSceneSettings(bpy.types.PropertyGroup):
    """How a scene is rendered: ``scene.zraka``."""

    method: EnumProperty(name="Method", description="How light is simulated", items=METHODS, default="PATHTRACE")
    samples: IntProperty(
        name="Samples",
        description="Samples of every pixel. Four times as many halve the noise and take four times as long",
        default=128,
        min=1,
        soft_max=4096,
        update=_tell,
    )
    viewport_samples: IntProperty(
        name="Viewport Samples",
        description="Samples of every pixel in Rendered shading. Four times as many halve the noise that is left; "
        "the first pictures come as soon with any number",
        default=64,
        min=1,
        soft_max=1024,
        update=_tell,
    )
    viewport_noise_target: FloatProperty(
        name="Viewport Noise Target",
        description="Refine Rendered shading until the estimated relative error is below this; 0 takes all samples. "
        "Half the error takes four times the time",
        default=0.0,
        min=0.0,
        soft_max=0.2,
        precision=4,
        update=_tell,
    )
    depth: IntProperty(
        name="Depth",
        description="Hits along a path: 1 sees direct light only, Blender's N bounces are N + 1. "
        "A small depth loses indirect light (too dark) and saves time",
        default=8,
        min=1,
        max=65536,
        soft_max=64,
        update=_tell,
    )
    diffuse_bounces: _bounces("Diffuse", "Diffuse reflections")
    glossy_bounces: _bounces("Glossy", "Glossy reflections and mirror rays")
    transmission_bounces: _bounces("Transmission", "Passages through glass and what is translucent")
    transparent_depth: IntProperty(
        name="Transparent Depth",
        description="Transparent surfaces a ray may pass straight through; beyond them is black. "
        "They cost time only where they stand one behind another",
        default=8,
        min=0,
        max=65536,
        soft_max=64,
        update=_tell,
    )
    bake_type: EnumProperty(
        name="Bake Type",
        description="What is baked into the active image texture",
        items=BAKES,
        default="COMBINED",
    )
    seed: IntProperty(
        name="Seed",
        description="Number that chooses the noise: the same seed gives the same picture, at no cost",
        default=0,
        min=0,
        update=_tell,
    )
    time_limit: FloatProperty(
        name="Time Limit",
        description="Seconds after which rendering stops, whatever noise is left; 0 is no limit",
        default=0.0,
        min=0.0,
        soft_max=3600.0,
        step=100,
        precision=1,
        update=_tell,
    )
    noise_target: FloatProperty(
        name="Noise Target",
        description="Stop when the estimated relative error is below this, e.g. 0.02 for 2%; 0 takes all samples. "
        "Half the error takes four times the time",
        default=0.0,
        min=0.0,
        soft_max=0.2,
        precision=4,
        update=_tell,
    )
    adaptive: BoolProperty(
        name="Adaptive",
        description="Give pixels that are noisier than others more of the samples, which are then the mean of all. "
        "Lowers the error where much of the picture is smooth; where it is noisy all over, nothing is gained",
        default=False,
        update=_tell,
    )
    clamp_direct: FloatProperty(
        name="Clamp Direct",
        description="Largest value of one sample of direct light: fewer bright dots, but light is lost; 0 is off",
        default=0.0,
        min=0.0,
        soft_max=100.0,
        update=_tell,
    )
    clamp_indirect: FloatProperty(
        name="Clamp Indirect",
        description="Largest value of one sample of indirect light: fewer bright dots, but light is lost; 0 is off",
        default=0.0,
        min=0.0,
        soft_max=100.0,
        update=_tell,
    )
    pixel_filter: EnumProperty(
        name="Pixel Filter",
        description="How a pixel weighs what is seen in and around it; no filter takes longer than another",
        items=FILTERS,
        default="BLACKMAN_HARRIS",
        update=_tell,
    )
    filter_width: FloatProperty(
        name="Width",
        description="Width of the pixel filter in pixels: wider is softer. The box is always one pixel wide",
        default=1.5,
        min=0.01,
        max=10.0,
        update=_tell,
    )
    exposure: FloatProperty(
        name="Exposure",
        description="Factor of all light in the picture; a number of 2 is twice as bright. It costs nothing and "
        "leaves the relative error as it is",
        default=1.0,
        min=0.0,
        soft_max=10.0,
        update=_tell,
    )
    film_transparent_glass: BoolProperty(
        name="Transparent Glass",
        description="See what is behind a transparent film through glass too: alpha is what the glass leaves of it, "
        "and only what mirrors in the glass is light. It costs little",
        default=False,
        update=_tell,
    )
    film_transparent_roughness: FloatProperty(
        name="Roughness Threshold",
        description="Glass that is rougher shows the world as light instead of what is behind the film",
        default=0.1,
        min=0.0,
        max=1.0,
        update=_tell,
    )
    tile: IntProperty(
        name="Tile Size",
        description="Side in pixels of the squares in which pixels are traced: rays of neighbours meet the same "
        "things. It changes no picture, and time little",
        default=32,
        min=1,
        max=4096,
        soft_min=8,
        soft_max=512,
        update=_tell,
    )
    use_error_table: BoolProperty(
        name="Table Beside Frames",
        description="Write a table beside the frames of an animation (name_error.csv): seconds, samples, estimated "
        "error of each frame, and what ended it. It costs nothing",
        default=True,
    )
    took_over: BoolProperty(
        name="Taken Over from Cycles",
        description="Whether these settings were Cycles' first",
        default=False,
        options={"HIDDEN"},
        update=_tell,
    )
    use_reflectivity: _override("reflectivity")
    reflectivity: FloatProperty(
        name="Reflectivity",
        description="Share k_s of the mirror ray in every material; 0 sends none and is fastest",
        default=0.0,
        min=0.0,
        max=1.0,
        update=_tell,
    )
    use_transparency: _override("transparency")
    transparency: FloatProperty(
        name="Transparency",
        description="Share k_t of the refracted ray in every material; 0 sends none and is fastest",
        default=0.0,
        min=0.0,
        max=1.0,
        update=_tell,
    )
    use_ior: _override("IOR")
    ior: FloatProperty(
        name="IOR",
        description="Index of refraction of every material; it turns the refracted ray, at no cost",
        default=1.5,
        min=1.0,
        soft_max=3.0,
        update=_tell,
    )
    use_exponent: _override("exponent")
    exponent: FloatProperty(
        name="Exponent",
        description="Phong exponent of every material: large is a small highlight; it costs nothing",
        default=50.0,
        min=0.0,
        soft_max=1000.0,
        update=_tell,
    )
    use_ambient: _override("ambient light")
    ambient: FloatProperty(
        name="Ambient",
        description="Light that reaches every point alike, in place of the world's; it costs nothing",
        default=0.1,
        min=0.0,
        soft_max=1.0,
        update=_tell,
    )


class ZrakaObjectSettings(bpy.types.PropertyGroup):
    """What an object is to Zraka: ``object.zraka``."""

    plane: BoolProperty(
        name="Zraka Plane",
        description="Render this empty as an infinite plane through its origin, its front along its Z axis",
        default=False,
        update=_tell,
    )
    plane_material: PointerProperty(
        name="Material", description="Material of the plane", type=bpy.types.Material, update=_tell
    )


def settings_of(scene, **overrides):
    """Read `core.settings.Settings` from a scene.

    Parameters
    ----------
    scene : bpy.types.Scene
    **overrides
        Fields of `Settings` that do not come from the scene; None means that it does.
    """
    group = scene.zraka
    chosen = {name: getattr(group, name) for name in SAME_NAME}
    limits = {name: getattr(group, name) for name in BOUNCES}
    chosen |= {name: UNLIMITED if limit >= ALL_BOUNCES else limit for name, limit in limits.items()}
    chosen["method"], chosen["pixel_filter"] = group.method.lower(), group.pixel_filter.lower()
    fixed = scene.render.threads_mode == "FIXED"
    chosen["threads"] = scene.render.threads if fixed else preferred_threads()
    chosen["processes"] = preferred_processes()
    chosen["shown"] = not bpy.app.background
    chosen["transparent_film"] = scene.render.film_transparent
    chosen["transparent_glass"] = group.film_transparent_glass
    chosen["transparent_roughness"] = round(group.film_transparent_roughness, 6)  # float32 in Blender
    chosen |= {name: getattr(group, name) for name in OVERRIDES if getattr(group, f"use_{name}")}
    chosen |= {name: value for name, value in overrides.items() if value is not None}
    return Settings(**chosen)


CLASSES = (ZrakaSceneSettings, ZrakaObjectSettings)


def register():
    """Add ``scene.zraka`` and ``object.zraka``."""
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.Scene.zraka = PointerProperty(name="Zraka", type=ZrakaSceneSettings)
    bpy.types.Object.zraka = PointerProperty(name="Zraka", type=ZrakaObjectSettings)


def unregister():
    """Remove them."""
    del bpy.types.Object.zraka
    del bpy.types.Scene.zraka
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
