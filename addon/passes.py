# SPDX-License-Identifier: GPL-3.0-or-later
"""The passes a view layer asks for: one list, used to register them and to write them.

Names, channels and meanings are Cycles' of the same Blender, so that links of the compositor stay. What Zraka adds is
switched on in ``view_layer.zraka`` (`addon/view_layer.py`).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import bpy
import numpy as np

from ..core.settings import AOV_COLOR, AOV_VALUE, Guides
from .export.versions import blends_features, moves_background

UNKNOWN = 1e10
"""The error of a pixel with too few samples to tell; as far away as Blender's nothing."""

_FALLOFF_ENUMS = {"QUADRATIC", "LINEAR", "INVERSE_QUADRATIC"}
_MOST_RANKS = 16
# Guides that the exposure brightens.
_LIGHT = {f"{kind}_{part}" for kind in ("diffuse", "glossy", "transmission") for part in ("direct", "indirect")}
_OF_PATHS = _LIGHT | {"ambient_occlusion"}  # those that path tracing alone renders
_LIGHT |= {"emission", "environment"}

# Switch of the view layer, name since Blender 5.0, name before, channels, kind, guide; None where it stays empty.
_SWITCHED = (
    ("use_pass_z", "Depth", "Depth", "Z", "VALUE", "depth"),
    ("use_pass_mist", "Mist", "Mist", "Z", "VALUE", "mist"),
    ("use_pass_position", "Position", "Position", "XYZ", "VECTOR", "position"),
    ("use_pass_normal", "Normal", "Normal", "XYZ", "VECTOR", "normal"),
    ("use_pass_vector", "Vector", "Vector", "XYZW", "VECTOR", "vector"),
    ("use_pass_uv", "UV", "UV", "UVA", "VECTOR", "uv"),
    ("use_pass_object_index", "Object Index", "IndexOB", "X", "VALUE", "object_index"),
    ("use_pass_material_index", "Material Index", "IndexMA", "X", "VALUE", "material_index"),
    ("use_pass_diffuse_direct", "Diffuse Direct", "DiffDir", "RGB", "COLOR", "diffuse_direct"),
    ("use_pass_diffuse_indirect", "Diffuse Indirect", "DiffInd", "RGB", "COLOR", "diffuse_indirect"),
    ("use_pass_diffuse_color", "Diffuse Color", "DiffCol", "RGB", "COLOR", "diffuse_color"),
    ("use_pass_glossy_direct", "Glossy Direct", "GlossDir", "RGB", "COLOR", "glossy_direct"),
    ("use_pass_glossy_indirect", "Glossy Indirect", "GlossInd", "RGB", "COLOR", "glossy_indirect"),
    ("use_pass_glossy_color", "Glossy Color", "GlossCol", "RGB", "COLOR", "glossy_color"),
    ("use_pass_transmission_direct", "Transmission Direct", "TransDir", "RGB", "COLOR", "transmission_direct"),
    ("use_pass_transmission_indirect", "Transmission Indirect", "TransInd", "RGB", "COLOR", "transmission_indirect"),
    ("use_pass_transmission_color", "Transmission Color", "TransCol", "RGB", "COLOR", "transmission_color"),
    ("use_pass_emit", "Emission", "Emit", "RGB", "COLOR", "emission"),
    ("use_pass_environment", "Environment", "Env", "RGB", "COLOR", "environment"),
    ("use_pass_ambient_occlusion", "Ambient Occlusion", "AO", "RGB", "COLOR", "ambient_occlusion"),
)
_MATTES = (
    ("use_pass_cryptomatte_object", "CryptoObject", "crypto_object"),
    ("use_pass_cryptomatte_material", "CryptoMaterial", "crypto_material"),
    ("use_pass_cryptomatte_asset", "CryptoAsset", "crypto_asset"),
)
# First Blender that has the pass, name, channels, kind, guide.
_DENOISING = (
    ((4, 2), "Denoising Normal", "XYZ", "VECTOR", "denoising_normal"),
    ((4, 2), "Denoising Albedo", "RGB", "COLOR", "denoising_albedo"),
    ((4, 2), "Denoising Depth", "Z", "VALUE", "denoising_depth"),
    ((5, 2), "Denoising Specular Albedo", "RGB", "COLOR", "denoising_specular"),
    ((5, 2), "Denoising Roughness", "X", "VALUE", "denoising_roughness"),
)
# Switches that Blender keeps for other engines, or for data of old files; Cycles has no such passes either.
_NOT_YET = {
    "use_pass_subsurface_direct": "Subsurface Direct",
    "use_pass_subsurface_indirect": "Subsurface Indirect",
    "use_pass_subsurface_color": "Subsurface Color",
    "use_pass_shadow": "Shadow",
}


@dataclass(frozen=True)
class Pass:
    """One of Blender's render passes.

    Parameters
    ----------
    name : str
        Blender's name.
    channels : str
        One letter a channel, e.g. ``"RGBA"``.
    kind : {"COLOR", "VECTOR", "VALUE"}
    read : callable, optional
        From a `core.film.Film` and its settings to what makes a slice of rows, (rows, W, len(channels)) float32, row 0
        at the bottom.
    guide : str
        Name of a picture of `core.methods.guides` or `core.methods.light_passes`, whose rows from `first` on it shows.
        Without one and without `read` the pass stays empty.
    """

    name: str
    channels: str
    kind: str
    read: Callable | None = None
    guide: str = ""
    first: int = 0

    @property
    def is_empty(self):
        """Whether there is nothing to show yet."""
        return self.read is None and not self.guide


def passes_of(view_layer):
    """Generate the passes of `view_layer` that Zraka renders."""
    yield Pass("Combined", "RGBA", "COLOR", lambda film, settings: film.image)
    renamed = bpy.app.version >= (5, 0)
    for switch, name, old_name, channels, kind, guide in _SWITCHED:
        if getattr(view_layer, switch, False):
            yield Pass(name if renamed else old_name, channels, kind, guide=guide or "")
    for switch, name, guide in _MATTES:
        if getattr(view_layer, switch, False):
            for layer in range((_ranks(view_layer) + 1) // 2):
                # Lower case, so that files keep these numbers as they are.
                yield Pass(f"{name}{layer:02d}", "rgba", "COLOR", guide=guide, first=4 * layer)
    yield from _own_passes(getattr(view_layer, "zraka", None))
    for aov in getattr(view_layer, "aovs", ()):
        if aov.is_valid:
            if aov.type == "VALUE":
                yield Pass(aov.name, "X", "VALUE", guide=AOV_VALUE + aov.name)
            else:
                yield Pass(aov.name, "RGBA", "COLOR", guide=AOV_COLOR + aov.name)


def _own_passes(settings):
    """Those that Blender has no switch for."""
    if getattr(settings, "use_pass_sample_count", False):
        yield Pass("Debug Sample Count", "X", "VALUE", _sample_count)
    if getattr(settings, "use_pass_error", False):
        yield Pass("Error", "X", "VALUE", _error)
    if getattr(settings, "use_pass_denoising", False):
        for first, name, channels, kind, guide in _DENOISING:
            if bpy.app.version >= first:
                yield Pass(name, channels, kind, guide=guide)


def shows_errors(view_layer):
    """Whether a pass shows the error of each pixel."""
    return any(p.read is _error for p in passes_of(view_layer))


def _ranks(view_layer):
    return min(view_layer.pass_cryptomatte_depth, _MOST_RANKS)


def _sample_count(film, settings):
    """Share of the samples asked for, as Cycles tells it."""
    return (film.counts() / np.float32(settings.samples)).reshape(film.height, film.width, 1).__getitem__


def _error(film, settings):
    """Estimated standard error of the luminance."""
    return np.minimum(film.pixel_error(), UNKNOWN)[..., None].__getitem__


# -- Blender's side ----------------------------------------------------------------------------------------------------


def register_passes(engine, scene, view_layer):
    """Tell Blender which passes there will be."""
    for p in passes_of(view_layer):
        engine.register_pass(scene, view_layer, p.name, len(p.channels), p.channels, p.kind)


def guides_of(depsgraph):
    """`core.settings.Guides`: what the passes of a view layer need beside the picture."""
    scene, view_layer = depsgraph.scene_eval, depsgraph.view_layer_eval
    names = frozenset(p.guide for p in passes_of(view_layer) if p.guide)
    if not names:
        return Guides()
    world = getattr(view_layer, "world_override", None) or scene.world
    mist = (0.0, 100.0, "LINEAR")  # Cycles' own, where there is no world
    if world is not None:
        settings = world.mist_settings
        mist = settings.start, settings.depth, settings.falloff
    indices = {o.name: o.pass_index for o in depsgraph.objects} if "object_index" in names else {}
    assets = {o.name: _topmost(o).name for o in depsgraph.objects} if "crypto_asset" in names else {}
    return Guides(
        names=names,
        alpha_threshold=view_layer.pass_alpha_threshold,
        mist_start=mist[0],
        mist_depth=mist[1],
        ambient_distance=math.inf if world is None else world.light_settings.distance,
        mist_falloff=mist[2] if mist[2] in _FALLOFF_ENUMS else "QUADRATIC",
        levels=_ranks(view_layer),
        blends=blends_features(),
        moves_background=moves_background(),
        indices=indices,
        assets=assets,
    )


def _topmost(obj):
    while obj.parent is not None:
        obj = obj.parent
    return obj


def readers_of(film, view_layer, settings=None, guides=None):
    """What makes rows of the passes' pictures, by name.

    Parameters
    ----------
    settings : core.settings.Settings, optional
        None is for the picture alone, as one of many on the way.
    guides : mapping of str to (C, H·W) float32, optional
        What was made of them.

    Returns
    -------
    dict of str to callable
        From a slice of rows to (rows, W, C) float32.
    """
    found = {}
    for p in passes_of(view_layer):
        if p.name == "Combined" or (p.read is not None and settings is not None):
            found[p.name] = p.read(film, settings)
        elif p.guide in (guides or {}):
            exposure = settings.exposure if p.guide in _LIGHT else 1
            picture = guides[p.guide][p.first : p.first + len(p.channels)]
            found[p.name] = partial(_guide_rows, picture.reshape(-1, film.height, film.width), exposure)
        elif settings is not None and (p.is_empty or guides is not None):
            # Blender fills some with numbers that are not black.
            found[p.name] = np.broadcast_to(np.float32(0), (film.height, film.width, len(p.channels))).__getitem__
    return found


def _guide_rows(picture, exposure, rows):
    part = np.moveaxis(picture[:, rows], 0, -1)
    return part if exposure == 1 else part * exposure


def write_passes(readers, rows, render_layer):
    """Copy `rows` of what `readers_of` gave into the passes of Blender's `render_layer`, which holds just these.

    With stereo views, the same goes into each.
    """
    for name, read in readers.items():
        # Flat float32 is the only way in that does not convert number by number.
        pixels = np.ascontiguousarray(read(rows), dtype=np.float32).reshape(-1)
        for target in render_layer.passes:
            if target.name == name:
                target.rect.foreach_set(pixels)


def write_metadata(result, view_layer, names):
    """Tell the files' readers what the ids of the mattes stand for; `names` are lists by guide."""
    from ..core.methods.cryptomatte import metadata

    for switch, name, guide in _MATTES:
        if getattr(view_layer, switch, False) and guide in names:
            for field, value in metadata(f"{view_layer.name}.{name}", dict.fromkeys(names[guide])).items():
                result.stamp_data_add_field(field, value)


def missing_passes(render_layer, view_layer, method="pathtrace"):
    """Name the passes that Blender expects or the user has switched on, and Zraka does not render by `method`."""
    rendered = list(passes_of(view_layer))
    expected = {p.name for p in render_layer.passes} - {p.name for p in rendered}
    unlit = set() if method == "pathtrace" else _OF_PATHS
    empty = {p.name for p in rendered if p.is_empty or p.guide in unlit}
    return sorted(expected | empty | {name for switch, name in _NOT_YET.items() if getattr(view_layer, switch, False)})
