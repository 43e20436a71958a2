# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes that depend on the angle under which a surface is seen: Fresnel and Layer Weight.

Source: Blender manual, "Fresnel Node", "Layer Weight Node"; Cycles for the blend's exponent.
"""

from __future__ import annotations

import numpy as np

from ..vecmath import dot
from . import spaces
from .base import Operation

_LEAST = 1e-5  # of an index of refraction


def _cosine(context, inputs):
    n = inputs["normal"] if "normal" in inputs else spaces.shading_normal(context)
    cosine = dot(n, spaces.incoming(context), context.arena)
    return np.abs(cosine, out=cosine)


def dielectric(cosine, eta):
    """Share (N,) of unpolarized light that a dielectric reflects; 1 where all is.

    Parameters
    ----------
    cosine : (N,)
        Of the angle to the normal, not negative.
    eta : (N,) or (1,)
        Index of the far side over the near side's.
    """
    root = np.square(eta) - 1 + np.square(cosine)
    inside = np.sqrt(np.maximum(root, 0))
    parallel = np.square(eta) * cosine
    across = (cosine - inside) / np.maximum(cosine + inside, 1e-30)
    along = (parallel - inside) / np.maximum(parallel + inside, 1e-30)
    return np.where(root > 0, 0.5 * (np.square(across) + np.square(along)), np.float32(1))


def _front(context):
    return np.ones(1, bool) if context.surface is None else context.surface.front


def _fresnel(context, inputs, properties):
    ior = np.maximum(inputs["ior"], np.float32(_LEAST))
    return {"fac": dielectric(_cosine(context, inputs), np.where(_front(context), ior, 1 / ior))}


def _layer_weight(context, inputs, properties):
    blend, cosine = inputs["blend"], _cosine(context, inputs)
    eta = np.maximum(1 - blend, np.float32(_LEAST))
    fresnel = dielectric(cosine, np.where(_front(context), 1 / eta, eta))
    limited = np.clip(blend, 0, 1 - _LEAST)
    exponent = np.where(limited < 0.5, 2 * limited, 0.5 / (1 - limited))
    exponent = np.where(blend == 0.5, np.float32(1), exponent)
    return {"fresnel": fresnel, "facing": 1 - np.power(cosine, exponent)}


OPERATIONS = {
    "fresnel": Operation(_fresnel, {"ior": 1.5, "normal": None}, foldable=False),
    "layer_weight": Operation(_layer_weight, {"blend": 0.5, "normal": None}, foldable=False),
}
