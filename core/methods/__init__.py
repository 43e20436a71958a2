# SPDX-License-Identifier: GPL-3.0-or-later
"""The four methods, by name."""

import functools

from ..compile.features import Feature
from .catchers import Catchers
from .clear_glass import ClearGlass
from .light_passes import LightPasses, summed
from .local_visibility import VisibilityPhong, VisibilityRayCast, VisibilityRayTrace
from .pathtrace import PathTrace
from .phong import Phong
from .raycast import RayCast
from .raytrace import RayTrace
from .visibility import VisibilityPathTrace

METHODS = {"phong": Phong, "raycast": RayCast, "raytrace": RayTrace, "pathtrace": PathTrace}
_VISIBILITY_METHODS = {
    "phong": VisibilityPhong,
    "raycast": VisibilityRayCast,
    "raytrace": VisibilityRayTrace,
    "pathtrace": VisibilityPathTrace,
}


def method_of(compiled, settings):
    """The method that `settings` name, as the features of the compiled scene need it."""
    features = compiled.features
    method = (_VISIBILITY_METHODS if Feature.VISIBILITY in features else METHODS)[settings.method]
    if settings.method != "pathtrace":
        return method(compiled, settings)
    glass = (ClearGlass,) if Feature.CLEAR_GLASS in features else ()
    passes = (LightPasses,) if summed(settings) else ()
    if Feature.CATCHERS not in features:
        return _composed(method, *glass, *passes)(compiled, settings)
    whole = _composed(method, *glass, *passes, Catchers)(compiled, settings)
    if compiled.visibility.among_catchers is not None:
        whole.alone = _composed(method, *glass)(compiled.of_catchers(), settings)
    return whole


@functools.cache
def _composed(method, *parts):
    """`method` with the mixins `parts`, of which the first is asked first."""
    return type("".join(part.__name__ for part in (*parts, method)), (*parts, method), {}) if parts else method
