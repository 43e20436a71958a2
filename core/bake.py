# SPDX-License-Identifier: GPL-3.0-or-later
"""Baking: what is rendered at given points of surfaces, the texels of a picture, instead of through a camera."""

from __future__ import annotations

import copy
from dataclasses import dataclass, replace

import numpy as np

from .geometry import CORNERS
from .methods.bake import COLORS, bake_method
from .render import render
from .spaces import View

KINDS = ("combined", *COLORS, "ao", "normal", "emit", "position", "uv", "roughness", "environment")

_MOST_FACTS = 64  # samples of what needs no light
_TILE = 1024  # texels in a row that are traced together
_INWARDS = 1e-5  # least barycentric coordinate: on an edge, or in a corner, rays would start in the next wall


@dataclass(frozen=True)
class Bake:
    """What is baked.

    Parameters
    ----------
    kind : str
        One of `KINDS`.
    parts : frozenset of str
        Of combined light: "direct", "indirect", "emit", "diffuse", "glossy", "transmission". Of light by lobe:
        "direct", "indirect", and "color", without which the light is divided by the surface's colour; "color" alone is
        the colour.
    distance : float
        How far what occludes may be.
    view : Viewer, optional
        Who sees the surfaces; None is from straight above each point.
    """

    kind: str
    parts: frozenset[str] = frozenset()
    distance: float = 10.0
    view: Viewer | None = None

    def __post_init__(self):
        if self.kind not in KINDS:
            raise ValueError(f"unknown kind of bake {self.kind!r}; choose one of {', '.join(KINDS)}")

    @property
    def traces_paths(self):
        """Whether light is to be found."""
        return self.kind == "combined" or (self.kind in COLORS and bool(self.parts & {"direct", "indirect"}))


@dataclass(frozen=True, eq=False)
class Viewer:
    """A camera that looks at points: its `place` (3,) relative to the geometry's origin, or direction.

    `towards` gives directions (3, N) from points `p` (3, N), of any length.
    """

    place: np.ndarray | None
    backwards: np.ndarray

    @classmethod
    def of(cls, camera, origin):
        """That of a `core.scene.Camera`; `origin` is the geometry's."""
        matrix = np.asarray(camera.transform, np.float64)
        parallel = camera.projection == "ORTHOGRAPHIC"
        place = None if parallel else (matrix[:3, 3] - origin).astype(np.float32)
        return cls(place, matrix[:3, 2].astype(np.float32))

    def towards(self, p):
        """Directions (3, N) to the camera, not of unit length."""
        if self.place is None:
            return np.broadcast_to(self.backwards[:, None], p.shape)
        return self.place[:, None] - p


@dataclass(frozen=True, eq=False)
class BakePoints:
    """Points of triangles, and how barycentrics change over their texels.

    Parameters
    ----------
    prim : (P,) int32
        Primitives, all of them triangles.
    u, v : (P,) float32
        The point is ``(1 - u - v) v0 + u v1 + v v2``.
    du, dv : (2, P) float32
        Change of `u` and of `v` from one texel to the next, to the right and upwards.
    """

    prim: np.ndarray
    u: np.ndarray
    v: np.ndarray
    du: np.ndarray
    dv: np.ndarray

    def at(self, number, jitter):
        """Barycentrics (N,), (N,) of places `jitter` (2, N) in [0, 1) in the texels of the points `number` (N,).

        What would fall beside the triangle is brought nearer to the point, as far on both sides of it, so that what
        changes evenly over the triangle keeps its mean.
        """
        x, y = jitter - np.float32(0.5)
        u, v = self.u[number], self.v[number]
        along_u = self.du[0, number] * x + self.du[1, number] * y
        along_v = self.dv[0, number] * x + self.dv[1, number] * y
        share = np.ones_like(u)
        for left, step in ((u, along_u), (v, along_v), (1 - u - v, along_u + along_v)):
            np.minimum(share, np.maximum(left, 0) / np.maximum(np.abs(step), np.float32(1e-20)), out=share)
        return _off_edges(u + share * along_u, v + share * along_v)


def points_of(compiled, number, triangle, u, v, du, dv):
    """Points of an instance of a mesh.

    Parameters
    ----------
    compiled : CompiledScene
    number : int
        Of the instance in the scene.
    triangle : (P,) int
        Numbers in its mesh.
    u, v, du, dv
        As of `BakePoints`, by the order of corners in the mesh.

    Returns
    -------
    points : BakePoints
    found : (P,) bool
        Which of those asked for they are: triangles without area are no longer there.
    """
    geometry, instance = compiled.geometry, compiled.described.instances[number]
    own = np.flatnonzero(geometry.object[: geometry.triangle_count] == number).astype(np.int32)
    table = np.full(len(instance.mesh.triangles), -1, np.int32)
    table[np.arange(own.size) if geometry.own_number is None else geometry.own_number[own]] = own
    valid = (triangle >= 0) & (triangle < len(table))
    prim = np.where(valid, table[np.where(valid, triangle, 0)], -1) if len(table) else np.full(len(triangle), -1)
    found = prim >= 0
    u, v, du, dv = (np.ascontiguousarray(a[..., found], np.float32) for a in (u, v, du, dv))
    if np.linalg.det(np.asarray(instance.transform, np.float64)[:3, :3]) < 0:
        u, v, du, dv = v, u, dv, du  # mirroring exchanges the second and third corner
    return BakePoints(prim[found].astype(np.int32), u, v, du, dv), found


def bake(compiled, points, plan, settings, on_pass=None, cancelled=None):
    """Bake points.

    Parameters
    ----------
    compiled : CompiledScene
        With ``guides.names`` in its settings having "uv" where that is baked.
    points : BakePoints
    plan : Bake
    settings : Settings
        Samples, depth, stopping rules and so on; the frame's size tells nothing. Light is traced in paths, whatever
        the method.
    on_pass, cancelled : callable, optional
        As of `core.render.render`.

    Returns
    -------
    values : (P, 4) float32
        Normals are of the world and have length 1. The fourth is alpha.
    film : Film or None
        That of the light, or of what else was asked for.
    """
    count = points.prim.size
    if count == 0:
        return np.zeros((0, 4), np.float32), None
    settings = replace(
        settings,
        method="pathtrace",
        width=count,
        height=1,
        border=None,
        tile=_TILE,
        transparent_film=False,
        pixel_errors=False,
    )
    seen = _over_texels(compiled, points)
    if not plan.traces_paths:
        return _facts(seen, points, plan, settings, on_pass, cancelled)
    film = render(seen, _for_light(settings, plan), on_pass, cancelled, bake_method(points, plan))
    values = film.image()[0]
    if plan.kind in COLORS and "color" not in plan.parts:
        own, _ = _facts(seen, points, replace(plan, parts=frozenset({"color"})), settings, None, cancelled)
        color = own[:, :3]
        values[:, :3] = np.divide(values[:, :3], color, out=np.zeros_like(color), where=color > 0)
    return values, film


def _for_light(settings, plan):
    """Paths end after the first hit where no indirect light is wanted."""
    depth = settings.depth if "indirect" in plan.parts else 1
    return replace(settings, depth=depth, transparent_film=True)


def _facts(compiled, points, plan, settings, on_pass, cancelled):
    settings = replace(
        settings,
        samples=settings.samples if plan.kind == "ao" else min(settings.samples, _MOST_FACTS),
        exposure=settings.exposure if plan.kind in ("emit", "environment") else 1.0,
        noise_target=settings.noise_target if plan.kind == "ao" else 0.0,
        adaptive=False,
        transparent_film=plan.kind in COLORS,
    )
    film = render(compiled, settings, on_pass, cancelled, bake_method(points, plan))
    values = film.image()[0]
    if plan.kind == "normal":
        length = np.linalg.norm(values[:, :3], axis=1, keepdims=True)
        np.divide(values[:, :3], length, out=values[:, :3], where=length > 0)
    return values, film


# -- texels ------------------------------------------------------------------------------------------------------------


class _TexelView(View):
    """The scene's camera with the footprint of texels, which bumps measure their slopes by.

    Texels are spread evenly over a triangle: `radii` (count of primitives,) is theirs.
    """

    def __init__(self, camera, origin, radii):
        super().__init__(camera, 1, 1, origin)
        self._radii = radii

    def footprint(self, p, prim, arena):
        """That of the primitives `prim` (N,)."""
        return arena.take(self._radii, prim)


def _over_texels(compiled, points):
    """The scene, seen texel by texel instead of pixel by pixel."""
    geometry = compiled.geometry
    a, b, c = (geometry.facets[points.prim][:, k].T for k in CORNERS)
    x, y = ((b - a) * du + (c - a) * dv for du, dv in zip(points.du, points.dv, strict=True))
    own = np.maximum((np.linalg.norm(x, axis=0) + np.linalg.norm(y, axis=0)) / 2, np.float32(1e-20))
    radii = np.full(geometry.count, np.median(own), np.float32)
    radii[points.prim] = own
    seen = copy.copy(compiled)
    seen.geometry = replace(geometry, view=_TexelView(compiled.described.camera, geometry.origin, radii))
    return seen


def _off_edges(u, v):
    """Barycentrics moved inwards from the edges."""
    first, u, v = (np.maximum(w, _INWARDS) for w in (1 - u - v, u, v))
    total = first + u + v
    return u / total, v / total


__all__ = ["KINDS", "Bake", "BakePoints", "Viewer", "bake", "points_of"]
