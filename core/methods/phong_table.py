# SPDX-License-Identifier: GPL-3.0-or-later
"""Phong parameters of materials that look the same from everywhere, found once instead of at each hit."""

from __future__ import annotations

import numpy as np

from ..arena import Arena
from ..bsdf.phong import PhongParameters, phong_parameters
from ..compile.angular import view_context

_MOST_MATERIALS = 256  # more are computed at each hit, not for each angle
_FEW_PRIMITIVES = 4096  # a table of so many stays in the cache


class PhongTable:
    """Parameters by material, or by primitive.

    Parameters
    ----------
    columns : PhongParameters
        Of M materials: (3, M), (M,).
    material : (P,) int
        Of the primitives.
    """

    def __init__(self, columns, material):
        self._material = material
        if material.size <= _FEW_PRIMITIVES:
            columns = [None if c is None else np.ascontiguousarray(c[..., material]) for c in columns]
            self._material = None
        *shading, k_s, k_t, eta, _ = columns
        self._shading = [(c, bool((c == c[..., :1]).all())) for c in shading]
        self._beyond = k_s, k_t, eta

    def at(self, prim, goes_on, arena):
        """`PhongParameters` of lanes that hit `prim` (N,); (·, 1) where all materials have the same.

        k_s, k_t and eta, which are there where rays go on (`goes_on`), have all lanes.
        """
        number = arena.empty(prim.size, np.intp)  # numpy copies other indices at each call
        np.copyto(number, prim)
        if self._material is not None:
            np.copyto(number, arena.take(self._material, number))
        of_shading = [c[..., :1].copy() if same else arena.take(c, number) for c, same in self._shading]
        return PhongParameters(*of_shading, *((arena.take(c, number) if goes_on else None) for c in self._beyond))


def phong_table(scene):
    """The `PhongTable` of a CompiledScene's materials; None where some depend on the place or on who looks."""
    materials, programs = scene.materials, scene.materials.programs
    count = len(materials.program_of)
    smooth = len(scene.geometry.normals) > 0
    if not 0 < count <= _MOST_MATERIALS or not all(p.follows_angle(smooth) for p in programs):
        return None
    context = view_context(1)
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):  # as where lanes are shaded
        columns = [_of_material(materials, m, context) for m in range(count)]
    if any(column is None for column in columns):
        return None
    columns = (np.stack(rows, axis=-1) for rows in list(zip(*columns, strict=True))[:-1])
    return PhongTable(PhongParameters(*columns), scene.geometry.material)


def _of_material(materials, m, context):
    """Parameters (3,) and () of material number `m`; None where they differ by the angle or the side of view."""
    number = materials.program_of[m]
    program, material = materials.programs[number], np.full(context.count, m, np.int32)
    arena, surface = Arena(1 << 16), context.surface
    lobes = program.lobes_over(context, materials.constants(number, "scatter", material, arena))
    straight = None
    if program.transparency is not None:
        constants = materials.constants(number, "transparency", material, arena)
        straight = program.transparency.run(context, constants)["T"]
    found = phong_parameters(lobes, surface.ns, surface.wo, straight, arena)[:-1]
    if any((values != values[..., :1]).any() for values in found):  # also where one is no number
        return None
    return PhongParameters(*(values[..., 0].copy() for values in found))
