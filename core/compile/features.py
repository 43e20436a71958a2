# SPDX-License-Identifier: GPL-3.0-or-later
"""What a scene needs, and so what the methods leave out."""

from __future__ import annotations

import enum

_ASK_FOR_RAYS = frozenset(["light_path", "bevel"])


class Feature(enum.Flag):
    """A stage that some scenes do without."""

    ENVIRONMENT = enum.auto()  # light from infinity
    DIRECT_LIGHT = enum.auto()  # lights that can be sampled
    EMISSIVE_SURFACES = enum.auto()
    LAMPS = enum.auto()  # lights with an extent that scattered rays can meet
    SCATTERING = enum.auto()  # surfaces that are not black
    REFRACTION = enum.auto()
    TRANSPARENCY = enum.auto()
    TEXTURES = enum.auto()
    SMOOTH_NORMALS = enum.auto()
    SPHERES = enum.auto()
    PLANES = enum.auto()
    SEVERAL_PROGRAMS = enum.auto()
    CLAMP = enum.auto()
    FAR_CLIP = enum.auto()
    LIGHT_PATH = enum.auto()  # shaders that ask what kind of ray met them
    CLEAR_GLASS = enum.auto()  # glass through which a transparent film is seen
    VISIBILITY = enum.auto()  # objects and lights that not every ray sees, or every object is lit by
    BOUNCE_LIMITS = enum.auto()  # paths that a limit of one kind of bounce ends
    CATCHERS = enum.auto()  # shadow catchers

    @classmethod
    def all(cls):
        """Every feature."""
        return ~cls(0)


def features_of(geometry, materials, lights, camera, settings):
    """The features that a compiled scene and its settings need."""
    programs = materials.programs
    needed = {
        Feature.ENVIRONMENT: not lights.environment.is_black,
        Feature.DIRECT_LIGHT: lights.sampler.count > 0,
        Feature.EMISSIVE_SURFACES: any(e is not None for e in materials.emission),
        Feature.LAMPS: lights.lamps.count > 0,
        Feature.SCATTERING: any(p.closures for p in programs),
        Feature.REFRACTION: any(p.mixture.refracts for p in programs),
        Feature.TRANSPARENCY: any(p.transparency is not None for p in programs),
        Feature.TEXTURES: any(not p.scatter.is_constant for p in programs),
        Feature.SMOOTH_NORMALS: len(geometry.normals) > 0,
        Feature.SPHERES: geometry.sphere_count > 0,
        Feature.PLANES: geometry.plane_count > 0,
        Feature.SEVERAL_PROGRAMS: len(programs) > 1,
        Feature.CLAMP: settings.clamp_direct > 0 or settings.clamp_indirect > 0,
        Feature.FAR_CLIP: camera.has_far,
        Feature.BOUNCE_LIMITS: settings.limits_kinds,
        Feature.CLEAR_GLASS: sees_film_through_glass(settings) and any(p.mixture.refracts for p in programs),
        Feature.LIGHT_PATH: lights.environment.by_ray
        or any(p.operations & _ASK_FOR_RAYS for p in programs)
        or any(getattr(kind, "by_ray", False) for kind in lights.sampler.kinds),
    }
    found = Feature(0)
    for feature, is_needed in needed.items():
        if is_needed:
            found |= feature
    return found


def sees_film_through_glass(settings):
    """Whether `settings` ask for it."""
    return settings.method == "pathtrace" and settings.transparent_film and settings.transparent_glass


def names(features):
    """Lower-case names, in the order of definition."""
    return [f.name.lower() for f in Feature if f in features]
