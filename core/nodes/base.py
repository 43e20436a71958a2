# SPDX-License-Identifier: GPL-3.0-or-later
"""What all shader-node operations share.

An operation reads its inputs by name, as float32 arrays `(N,)`, `(3, N)` or constants `(1,)`, `(3, 1)`, and returns a
mapping of outputs. `Context` gives it what depends on the lanes: scratch memory and the hit.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np


class Ray(NamedTuple):
    """The rays that met the lanes of a program, for the Light Path node.

    Each field is one number for all lanes or an array (N,): flags are 0 or 1, depths count the hits before. `length` is
    the distance from the ray's origin; None stands for a ray that comes from the camera.
    """

    camera: float = 0.0
    shadow: float = 0.0
    diffuse: float = 0.0
    glossy: float = 0.0
    singular: float = 0.0
    reflection: float = 0.0
    transmission: float = 0.0
    length: np.ndarray | None = None
    depth: float = 0.0
    diffuse_depth: float = 0.0
    glossy_depth: float = 0.0
    transmission_depth: float = 0.0
    transparent_depth: float = 0.0

    def at(self, lanes):
        """The rays of some lanes, an index or a slice."""
        return Ray(*(c[..., lanes] if getattr(c, "ndim", 0) and c.shape[-1] > 1 else c for c in self))


CAMERA_RAY = Ray(camera=1.0)
SCATTERED_RAY = Ray(depth=1.0)
SHADOW_RAY = Ray(shadow=1.0, depth=1.0)


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
        Whether environment textures are read through small copies, in which no bright texel is missed, and the suns of
        skies are left out.
    ray : Ray
        What met the lanes.
    view : View, optional
        The camera, where there is no geometry that knows it.
    unmoved : object, optional
        The surface as it was, where the lanes have been moved aside (`core.nodes.displaced`).
    step : (float, float)
        By how many footprints they have been moved along the two axes.
    """

    arena: object
    count: int
    surface: object = None
    geometry: object = None
    direction: object = None
    averaged: bool = False
    ray: Ray = CAMERA_RAY
    view: object = None
    unmoved: object = None
    step: tuple[float, float] = (0.0, 0.0)

    def in_place(self):
        """The context of the lanes where they were before they were moved aside."""
        return self if self.unmoved is None else replace(self, surface=self.unmoved, unmoved=None)

    def at(self, lanes):
        """The context of some lanes, a slice or numbers (N,)."""
        surface, ray = (None if s is None else _Part(s, lanes) for s in (self.surface, self.ray))
        direction = None if self.direction is None else self.direction[:, lanes]
        count = lanes.stop - lanes.start if isinstance(lanes, slice) else lanes.size
        return replace(self, count=count, surface=surface, ray=ray, direction=direction)


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
        ``prepare(properties, diagnostics, place) -> properties`` once at compile, e.g. to read an image. Its
        properties have the names of the node's outputs that are linked, ``"linked"``.
    unsupported : mapping of str to str
        Outputs, and inputs left unlinked, that are not honoured yet, with what the user is told.
    displaced : str
        Name of an input that the operation also wants one and two steps aside, as ``<name>_x`` and ``<name>_y``: the
        compiler runs what the input depends on again at these points (`core.nodes.displaced`). The steps are
        `footprint` times the property ``"width"``.
    """

    run: Callable
    inputs: Mapping[str, float | tuple] = field(default_factory=dict)
    foldable: bool = True
    prepare: Callable | None = None
    unsupported: Mapping[str, str] = field(default_factory=dict)
    displaced: str = ""


class _Part:
    """Some lanes of a surface or of rays; a column is taken when it is first read."""

    def __init__(self, whole, lanes):
        self._whole, self._at = whole, lanes

    def __getattr__(self, name):
        column = getattr(self._whole, name)
        if getattr(column, "ndim", 0) and column.shape[-1] > 1:  # what is one for all lanes stays
            column = column[..., self._at] if isinstance(self._at, slice) else np.take(column, self._at, axis=-1)
        setattr(self, name, column)
        return column

    def _replace(self, **columns):
        """The same lanes with other columns, as of a NamedTuple."""
        part = _Part(self._whole, self._at)
        part.__dict__.update(self.__dict__ | columns)
        return part


class Outputs(Mapping):
    """Outputs of an operation, each computed the first time it is read: a noise's colour costs three times its factor.

    Parameters
    ----------
    makers : mapping of str to callable
        ``maker(*arguments) -> array`` of each output.
    """

    def __init__(self, makers, *arguments):
        self._makers, self._arguments = makers, arguments
        self._values = {}

    def __getitem__(self, name):
        if name not in self._values:
            self._values[name] = self._makers[name](*self._arguments)
        return self._values[name]

    def __iter__(self):
        return iter(self._makers)

    def __len__(self):
        return len(self._makers)


_SAFE = 1e38  # numbers below it are finite in float32


def as_vector(value):
    """A Python number or tuple as (1,) or (3, 1) float32."""
    if isinstance(value, float) and abs(value) < _SAFE:
        return np.array((value,), np.float32)
    if isinstance(value, tuple) and len(value) == 3 and max(map(abs, value)) < _SAFE:
        return np.array([(v,) for v in value], np.float32)
    with np.errstate(over="ignore"):  # which takes longer than all the rest
        a = np.asarray(value, np.float32)
    return a.reshape(1) if a.ndim == 0 else a[:3].reshape(3, 1).copy()
