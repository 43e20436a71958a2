# SPDX-License-Identifier: GPL-3.0-or-later
"""Who sees what, as tables: trees for kinds of rays, and what shines on whom."""

from __future__ import annotations

import numpy as np

from ..partial import PartialAccel
from ..visibility import LAMP, SEEN_BY_ALL, UNLIMITED, Rays

_OF_SURFACES = Rays.DIFFUSE | Rays.GLOSSY | Rays.TRANSMISSION


class SceneVisibility:
    """Visibility of a compiled scene; with `catchers_only` as if shadow catchers and their lights were alone.

    What may shine is numbered: the lights of the description, then the objects, then the world. Such a number is called
    an *emitter*.

    Attributes
    ----------
    first_object, world : int
        Emitters: the first object, and the world.
    is_plain : bool
        Whether everything is seen by all that Blender's defaults let see it; then nobody needs to ask.
    all : Accel or PartialAccel
        What is there.
    camera, shadow : Accel or PartialAccel
        What camera rays and shadow rays meet.
    scattered : tuple
        What diffuse, glossy and transmission rays meet, in this order.
    holdout_prim : (P + 1,) bool
        Primitives that are holes to the camera, as `CompiledScene.emissive_prim`; None where there are none.
    catcher_prim : (P + 1,) bool
        Primitives that catch shadows, in the same way.
    among_catchers : SceneVisibility
        With `catchers_only`; None where there are none.
    rays, max_bounces : (E,) uint8, (E,) int32
        Of each emitter, as `Visibility` has them.
    limited : (E,) bool
        Whether some scattered ray does not get an emitter's light.
    blockers : (E,) int32
        Number in `casters` of what shades an emitter.
    casters : list of Accel or PartialAccel
        The first is `shadow`.
    """

    def __init__(self, scene, geometry, lights, accel, catchers_only=False):
        objects = scene.objects
        of_objects = [o.visibility for o in objects]
        emitters = [light.visibility for light in scene.lights] + of_objects + [scene.world.visibility]
        self.first_object, self.world = len(scene.lights), len(emitters) - 1
        self._geometry, self._accel, self._made = geometry, accel, {}
        self._of_light = lights.emitter
        defaults = [LAMP] * len(scene.lights) + [SEEN_BY_ALL] * (len(objects) + 1)
        self.is_plain = all(_acts_like(v, default) for v, default in zip(emitters, defaults, strict=True))
        self.rays = np.array([v.rays for v in emitters], np.uint8)
        catchers = np.array([v.catcher for v in emitters])
        if catchers_only:
            self.rays[: self.world][~catchers[: self.world]] = 0
        self.max_bounces = np.array([v.max_bounces for v in emitters], np.int32)
        self._object_rays = self.rays[self.first_object : self.world]
        catches = catchers[self.first_object : self.world]
        self.all = self._tree(catches | (not catchers_only))
        self.camera, self.shadow = self._seen_by(Rays.CAMERA), self._seen_by(Rays.SHADOW)
        self.scattered = tuple(self._seen_by(kind) for kind in (Rays.DIFFUSE, Rays.GLOSSY, Rays.TRANSMISSION))
        names = [o.visibility.receives_as or o.name for o in objects]
        self._reach_of, self._reaches = _memberships([v.receivers for v in emitters], names)
        names = [o.visibility.blocks_as or o.name for o in objects]
        self.blockers, shade = _memberships([v.blockers for v in emitters], names)
        casts = (self._object_rays & Rays.SHADOW.value) > 0
        self.casters = [self._tree(row & casts) for row in shade]
        self.limited = (self.rays & _OF_SURFACES.value) != _OF_SURFACES.value
        self.limited |= (self._reach_of > 0) | (self.blockers > 0) | (self.max_bounces < UNLIMITED)
        holds_out = np.array([v.holdout for v in of_objects], bool)
        self.holdout_prim = np.append(holds_out[geometry.object], False) if holds_out.any() else None
        self.catcher_prim = self.among_catchers = None
        if catches.any() and not catchers_only:
            self.catcher_prim = np.append((catches & ~holds_out)[geometry.object], False)
            self.among_catchers = SceneVisibility(scene, geometry, lights, accel, catchers_only=True)

    def emitter_of_light(self, light):
        """Emitter of the lights `light` of the `LightSampler`."""
        return self._of_light[light]

    def emitter_of_prim(self, prim):
        """Emitter of the primitives `prim`."""
        return self.first_object + self._geometry.object[prim]

    def reaches(self, emitter, receiver):
        """Whether the light of `emitter` reaches the object `receiver`; numbers or (N,)."""
        return self._reaches[self._reach_of[emitter], receiver]

    def _seen_by(self, kind):
        return self._tree((self._object_rays & kind.value) > 0)

    def _tree(self, kept):
        """What meets the objects `kept` (O,) bool and no others."""
        if kept.all():
            return self._accel
        key = kept.tobytes()
        if key not in self._made:
            self._made[key] = PartialAccel(self._geometry, kept[self._geometry.object], self._accel.native)
        return self._made[key]


def _acts_like(visibility, default):
    """Whether, whatever its object is called."""
    return visibility is default or (
        (visibility.rays, visibility.receivers, visibility.blockers) == (default.rays, None, None)
        and visibility.max_bounces == UNLIMITED
        and not visibility.holdout
        and visibility.catcher <= default.catcher
    )


def _memberships(sets, names):
    """Each set's row, (E,) int32, and the distinct rows (S, O) bool of who is in it; row 0 is all objects."""
    numbers = {None: 0}
    row_of = np.array([numbers.setdefault(s, len(numbers)) for s in sets], np.int32)
    rows = [[s is None or name in s for name in names] for s in numbers]
    return row_of, np.array(rows, bool).reshape(len(rows), len(names))
