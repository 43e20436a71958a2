# SPDX-License-Identifier: GPL-3.0-or-later
"""What all shader-node operations share.

An operation reads its inputs by name, as float32 arrays `(N,)`, `(3, N)` or constants `(1,)`, `(3, 1)`, and returns a
mapping of outputs. `Context` gives it what depends on the lanes: scratch memory and the hit.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np


@dataclass
class Context:
    """Lanes that a program runs on.

    Parameters
    ----------
    arena : Arena
    count : int
        Number of lanes.
    surface : object
        prim, u, v of the hits, their `front`, `wo`, `ns`; None while constants are folded.
    geometry : Geometry or None
    direction : (3, N) float32, optional
        Of a world's lanes, unit: where the light comes from.
    averaged : bool
        Whether environment textures are read through small copies, in which no bright texel is missed.
    """

    arena: object
    count: int
    surface: object = None
    geometry: object = None
    direction: object = None
    averaged: bool = False


@dataclass(frozen=True)
class Operation:
    """One kind of node.

    Parameters
    ----------
    run : callable
        ``run(context, inputs, properties) -> {output name: array}``.
    inputs : mapping of str to float or tuple
        Default of each input; its length tells whether the input is a number or a vector.
    foldable : bool
        Whether constant inputs give constant outputs.
    prepare : callable, optional
        ``prepare(properties, diagnostics, place) -> properties`` once at compile, e.g. to read an image.
    unsupported : mapping of str to str
        Outputs, and inputs left unlinked, that are not honoured yet, with what the user is told.
    """

    run: Callable
    inputs: Mapping[str, float | tuple] = field(default_factory=dict)
    foldable: bool = True
    prepare: Callable | None = None
    unsupported: Mapping[str, str] = field(default_factory=dict)


def as_vector(value):
    """A Python number or tuple as (1,) or (3, 1) float32."""
    a = np.asarray(value, np.float32)
    return a.reshape(1) if a.ndim == 0 else a[:3].reshape(3, 1).copy()
