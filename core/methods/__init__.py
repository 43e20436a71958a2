# SPDX-License-Identifier: GPL-3.0-or-later
"""The four methods, by name."""

from ..compile.features import Feature
from .light_passes import LightPassTrace, VisibilityLightPassTrace, summed
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
    methods = _VISIBILITY_METHODS if Feature.VISIBILITY in compiled.features else METHODS
    if summed(settings):
        method = VisibilityLightPassTrace if Feature.VISIBILITY in compiled.features else LightPassTrace
        return method(compiled, settings)
    return methods[settings.method](compiled, settings)
