# SPDX-License-Identifier: GPL-3.0-or-later
"""The three classic methods on every scene of docs/coverage.md, beside direct light: Cycles' and path tracing's.

What each light and material means to them stands in docs/classic.md.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import bpy
import numpy as np

from zraka.addon.bench.engines import match, operate, watched

from . import (
    bounce_cases,
    camera_cases,
    catcher_cases,
    geometry_cases,
    lamp_cases,
    lens_cases,
    light_cases,
    motion_cases,
    visibility_cases,
    world_cases,
)
from .geometry_scenes import shows

METHODS = ("PHONG", "RAYCAST", "RAYTRACE")
FAINT = 1e-3  # of the brightest that direct light makes: as good as black
LIT = 0.1  # of the same: what must not be black
SAMPLES = 16


@dataclass(frozen=True)
class Case:
    """``build(scene)`` makes the scene of a case of another section and returns it; `meaning` is docs/classic.md's."""

    item: str
    build: Callable
    meaning: str


@dataclass(frozen=True)
class Found:
    """What a case's pictures are by method.

    `means` are of the brightest channel, over that of path tracing's direct light; `black` are shares of the pixels
    that direct light makes bright, in Cycles too; `messages` are as they were said.
    """

    means: dict
    black: dict
    messages: dict


def of_geometry(case, scene):
    """Of geometry."""
    geometry_cases.prepare(scene)
    case.build(scene)
    if case.shown:
        scene.view_layers[0].material_override = shows(*geometry_cases.POSITION)
    return scene


def of_visibility(case, _):
    """Of who sees what."""
    scene = visibility_cases.room()
    case.setup(bpy.data.objects)
    case.change(bpy.data.objects, scene)
    return scene


def of_bounces(case, _):
    """Of limits of bounces."""
    scene = bounce_cases.room()
    case.setup()
    bounce_cases.set_limits(scene, case.limits)
    return scene


def of_motion(case, scene):
    """Of what moves."""
    motion_cases.tiles(scene)
    case.move(scene)
    return scene


def of_lens(case, scene):
    """Of depth of field."""
    lens_cases.squares(scene)
    lens_cases.set_lens(scene, case)
    return scene


def of_others(module, case, scene):
    """Of a module that has a builder of its own."""
    build = module.set_up if module is camera_cases else module.build
    build(scene, case)
    return scene


BUILDERS = {
    camera_cases: (of_others, "cameras-and-motion"),
    lens_cases: (of_lens, "cameras-and-motion"),
    light_cases: (of_others, "lights"),
    bounce_cases: (of_bounces, "max-bounces"),
    lamp_cases: (of_others, "lights"),
    world_cases: (of_others, "lights"),
    visibility_cases: (of_visibility, "lights"),
    catcher_cases: (of_visibility, "materials"),
    motion_cases: (of_motion, "cameras-and-motion"),
    geometry_cases: (of_geometry, "materials"),
}


def builder(module):
    """``build(case, scene)`` of a module's cases."""
    build, _ = BUILDERS[module]
    return partial(of_others, module) if build is of_others else build


CASES = tuple(
    Case(case.item, partial(builder(module), case), meaning)
    for module, (_, meaning) in BUILDERS.items()
    for case in module.CASES
    if bpy.app.version >= getattr(case, "since", (4, 2))
)


def picture(scene, method, samples=SAMPLES):
    """The scene by a method, and what was said."""
    scene.zraka.method, scene.zraka.samples = method, samples
    with watched() as seen:
        shown, _ = operate(scene, "ZRAKA")
    return shown, seen.messages


def direct_light(scene):
    """Path tracing's and Cycles' picture of direct light; shadow catchers are objects like others, as here."""
    scene.zraka.samples, scene.zraka.depth = SAMPLES, 1
    match(scene)
    catchers = [o for o in scene.objects if o.is_shadow_catcher]
    for caught in catchers:
        caught.is_shadow_catcher = False
    pictures = picture(scene, "PATHTRACE")[0], operate(scene, "CYCLES")[0]
    for caught in catchers:
        caught.is_shadow_catcher = True
    return pictures


def brightness(picture):
    """(H, W): the brightest channel; light may be negative."""
    return np.abs(picture).max(axis=-1)


def measure(scene, case):
    """`Found` of a case."""
    scene = case.build(scene)
    traced, theirs = direct_light(scene)
    bright = brightness(traced)
    most = bright.max()
    lit = np.minimum(bright, brightness(theirs)) > LIT * most
    if not lit.any():
        raise AssertionError(f"{case.item}: direct light shows nothing ({most}, {brightness(theirs).max()})")
    scene.zraka.depth = 4
    means, black, messages = {}, {}, {}
    for method in METHODS:
        shown, messages[method] = picture(scene, method)
        if not np.isfinite(shown).all():
            raise AssertionError(f"{case.item}: not finite by {method}")
        means[method] = float(brightness(shown).mean() / bright.mean())
        black[method] = float((brightness(shown) < FAINT * most)[lit].mean())
    return Found(means, black, messages)
