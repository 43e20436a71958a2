# SPDX-License-Identifier: GPL-3.0-or-later
"""What all shader nodes that scatter, emit or let light pass share."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from ..bsdf import microfacet, tangents
from ..bsdf.shading_normal import lifted_normal
from ..vecmath import dot
from .geometry import lookup_tangent

SUBSURFACE = "subsurface scattering is approximated by diffuse reflection; no light wanders below the surface"

RAW_NORMAL = "raw_normal"
"""Input of `Closure.build` besides its own: the shading normal before it was raised, where it may have been."""

UNTURNED_NORMAL = "unturned_normal"
"""Another: the shading normal as it was before a node turned it, where one did."""

_ABOVE_ONE = "a colour above 1 is an albedo above 1: more light leaves the surface than arrives"


def _no_lobes(constants, properties):
    return {}


@dataclass(frozen=True, eq=False)
class Closure:
    """One kind of shader node.

    Parameters
    ----------
    name : str
    inputs : mapping of str to float, tuple or None
        Defaults; None for an input that only counts when it is linked.
    lobes : callable
        ``lobes(constants, properties) -> {layer: lobe}``, decided by the inputs that are constant.
    build : callable, optional
        ``build(context, inputs, lobes, properties) -> [(lobe, weight, params, n)]`` over lanes.
    used : callable, optional
        ``used(lobes)`` gives the names of the inputs that `build` reads; without it, it reads all.
    emission, transparency : tuple of str
        Inputs whose product is emitted, or passes straight through; "1-x" is the complement of x.
    cover : callable, optional
        ``cover(constants, properties)`` gives an operation and its inputs, by which what is emitted is multiplied, or
        None.
    is_holdout : bool
        Whether it cuts a hole into the picture.
    notes : callable, optional
        ``notes(constants, linked, properties)`` yields sentences that the user is told.
    by_angle : callable, optional
        ``by_angle(lobes, inputs)`` tells whether `build` asks the surface for nothing but the cosine between its normal
        and the view, and its side. Then it is tabulated where the inputs are constant.
    color : str
        The input that may vary nevertheless.
    """

    name: str
    inputs: Mapping
    lobes: Callable = _no_lobes
    build: Callable | None = None
    used: Callable | None = None
    emission: tuple = ()
    cover: Callable | None = None
    transparency: tuple = ()
    is_holdout: bool = False
    notes: Callable | None = None
    by_angle: Callable | None = None
    color: str = "color"

    def diagnose(self, constants, linked, properties, diagnostics, place):
        """Name what the node asks for and does not get."""
        for sentence in self.notes(constants, linked, properties) if self.notes else ():
            diagnostics.warn(sentence, place)
        if self.build and self.color in constants and float(np.max(constants[self.color])) > 1.0:
            diagnostics.warn(_ABOVE_ONE, place)


def is_never(constants, name, value=0.0):
    """Whether an input is constant and not above `value`."""
    return name in constants and float(np.max(constants[name])) <= value


def is_black(constants):
    """Whether the node's colour is constant and zero."""
    return is_never(constants, "color")


def is_smooth(constants):
    """Whether a roughness is constant and so small that the lobe is a mirror."""
    return "roughness" in constants and float(np.max(constants["roughness"])) ** 2 <= microfacet.SMOOTH_ALPHA


def alpha_of(inputs, name="roughness"):
    """Width of the microfacets' slopes, the square of Blender's roughness."""
    return np.square(np.clip(inputs[name], 0, 1))


def facing(context):
    """Cosine between view and shading normal, (N,), at least 0."""
    return np.maximum(dot(context.surface.ns, context.surface.wo, context.arena), 0)


def on_strands(context):
    """Lanes (N,) bool that are hair, None where the scene has none."""
    geometry = context.geometry
    return geometry.on_strand(context.surface.prim) if geometry is not None and geometry.segment_count else None


def raised_normal(context, n):
    """`lifted_normal` of the normals `n` (3, N), save on hair, whose normals stay as they are, as in Cycles."""
    s, hair = context.surface, on_strands(context)
    lifted = lifted_normal(n, s.ng, s.wo, context.arena)
    if hair is not None and lifted is not n:
        np.copyto(lifted, n, where=hair)
    return lifted


def relative_index(context, ior):
    """`ior` kept above 0, and the relative index seen from the viewer's side."""
    ior = np.maximum(ior, 1e-5)
    return ior, np.where(context.surface.front, ior, 1 / ior)


def stretched(context, inputs, stretch, turns):
    """Parameters of anisotropic facets: wider by `stretch` along the tangent, which is turned by `turns` circles."""
    n, arena = context.surface.ns, context.arena
    tangent = inputs.get("tangent")
    if tangent is None:
        tangent = lookup_tangent(context)
    if turns.size > 1 or turns.any():
        tangent = tangents.rotated(tangent, n, turns, arena)
    return {"stretch": stretch, "tangent": tangent}
