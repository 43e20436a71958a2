# SPDX-License-Identifier: GPL-3.0-or-later
"""Directions to rectangles: uniform in the solid angle where they look large, else from uniform points.

Source of the former: Urena, Fajardo and King, "An Area-Preserving Parametrization for Spherical Rectangles", EGSR 2013.
There the rectangle lies at z = -height of a frame around the point that looks, between the *edges* x0, x1, y0, y1.
"""

from __future__ import annotations

import math

import numpy as np

from ..limits import at_least, at_most
from ..sampling.warp import square_to_uniform_disk_concentric
from ..vecmath import dot, with_sign
from .base import NEAREST_SQUARED, normalize_length, rows_at, rows_of

# Area over squared distance to the centre above which the solid angle is sampled. Uniform points cost a third of the
# time; their greater variance matters where a light fills the view.
_LARGE = 0.3
# Below this solid angle (sr) float32 loses it among the four angles.
_SMALLEST = 0.01
_FLATTEST = 1e-4  # height over the sum of the half sides
_TINY = 1e-30
_ARCSINE = (-0.0012624911, 0.0066700901, -0.0170881256, 0.0308918810, -0.0501743046, 0.0889789874, -0.2145988016)
_ARCSINE += (1.5707963050,)


class Rectangles:
    """Rectangles, or the ellipses inscribed in them, to which directions are sampled.

    An ellipse that looks large is sampled by rejecting what falls beside it.

    Parameters
    ----------
    center, x, y, normal : (3, count)
        `x`, `y`, `normal` are orthonormal.
    half : (2, count)
        Half the side lengths along `x` and `y`.
    round_ : (count,) bool, optional
        Which are ellipses.
    both_sides : bool
        Whether they are seen from behind too.

    Attributes
    ----------
    count : int
    area : (count,) float64
    spread : (count,) float64
        Mean squared distance of their points from their centres.
    """

    def __init__(self, center, x, y, normal, half, round_=None, both_sides=False):
        half = np.asarray(half, np.float64)
        self.frame = np.ascontiguousarray(np.concatenate([center, x, y, normal, half]), np.float32)
        self._axes = np.ascontiguousarray(np.concatenate([x * half[0], y * half[1]]), np.float32)
        box = 4.0 * half[0] * half[1]
        self._round = np.zeros(box.size, bool) if round_ is None else np.ascontiguousarray(round_, bool)
        self._any_round = bool(self._round.any())
        self.area = box * np.where(self._round, math.pi / 4, 1.0)
        self.spread = (half * half).sum(axis=0) / np.where(self._round, 4.0, 3.0)
        self._area = self.area.astype(np.float32)
        self._near = (box / _LARGE).astype(np.float32)  # squared distance within which a rectangle looks large
        self._both_sides = both_sides
        self.count = box.size

    def box(self):
        """Corners of bounding boxes, (3, count) each."""
        reach = np.abs(self._axes[0:3]) + np.abs(self._axes[3:6])
        return self.frame[0:3] - reach, self.frame[0:3] + reach

    def sample(self, rows, p, u0, u1, arena):
        """A direction to a point of the rectangle.

        Returns
        -------
        wi, distance : (3, N), (N,)
        inverse : (N,)
            1/pdf per solid angle; 0 behind a rectangle that has one side, and beside an ellipse.
        """
        n = p.shape[-1]
        wi, distance, inverse = arena.empty((3, n)), arena.empty(n), arena.empty(n)
        with arena.frame():
            near = self._towards_points(rows, p, u0, u1, wi, distance, inverse, arena)
            if near.size:
                self._towards_view(rows, near, p, u0, u1, (wi, distance, inverse), arena)
        return wi, distance, inverse

    def inverse_density(self, rows, p, wi, distance, arena):
        """1/pdf (N,) with which `sample` draws the directions `wi` from `p` to points at `distance`."""
        n = p.shape[-1]
        inverse = arena.empty(n)
        with arena.frame():
            offset = np.subtract(rows_of(self.frame[0:3], rows, arena), p, out=arena.empty((3, n)))
            near = self._looks_large(rows, offset, arena)
            self._inverse_by_area(rows, wi, distance, inverse, arena)
            if near.size:
                frame = rows_of(self.frame, rows_at(rows, near, arena), arena)
                view = _View(*project(frame, arena.take(p, near), arena), arena)
                large = np.flatnonzero(_is_large(frame, view))
                inverse[near[large]] = self._seen(view, large)
        return inverse

    def crossed(self, rows, o, d, arena):
        """Where rays cross the rectangles from the side that is seen: lanes (n,) and distances (n,)."""
        n = o.shape[-1]
        with arena.frame():
            frame, axes = rows_of(self.frame, rows, arena), rows_of(self._axes, rows, arena)
            offset = np.subtract(frame[0:3], o, out=arena.empty((3, n)))
            height, cosine = dot(frame[9:12], offset, arena), dot(frame[9:12], d, arena)
            t = np.abs(cosine, out=arena.empty(n))
            np.copysign(at_least(t, 1e-12, t), cosine, out=t)
            np.divide(height, t, out=t)
            hit = np.greater(t, 0.0, out=arena.empty(n, bool))
            if not self._both_sides:
                hit &= cosine < 0.0
            reach, along, s = arena.zeros(n), arena.empty(n), arena.empty(n)
            for i in range(2):
                dot(axes[3 * i : 3 * i + 3], d, arena, out=along)
                np.multiply(along, t, out=along)
                np.subtract(along, dot(axes[3 * i : 3 * i + 3], offset, arena, out=s), out=along)
                half = frame[12 + i]
                np.divide(along, half * half, out=along)
                np.multiply(along, along, out=along)
                hit &= along <= 1.0
                np.add(reach, along, out=reach)
            if self._any_round:
                hit &= (reach <= 1.0) | ~rows_of(self._round, rows, arena)
            lanes = np.flatnonzero(hit)
            distance = t[lanes]
        return lanes, distance

    def _towards_points(self, rows, p, u0, u1, wi, distance, inverse, arena):
        """Write directions to uniform points; return the lanes to which the rectangle looks large."""
        n = u0.shape[-1]
        x, y, t = arena.empty(n), arena.empty(n), arena.empty(n)
        np.subtract(np.multiply(u0, 2.0, out=x), 1.0, out=x)
        np.subtract(np.multiply(u1, 2.0, out=y), 1.0, out=y)
        if self._any_round:
            disk, round_ = square_to_uniform_disk_concentric(u0, u1, arena), rows_of(self._round, rows, arena)
            np.copyto(x, disk[0], where=round_)
            np.copyto(y, disk[1], where=round_)
        axes = rows_of(self._axes, rows, arena)
        np.subtract(rows_of(self.frame[0:3], rows, arena), p, out=wi)
        near = self._looks_large(rows, wi, arena)
        for i in range(3):
            np.add(wi[i], np.multiply(axes[i], x, out=t), out=wi[i])
            np.add(wi[i], np.multiply(axes[3 + i], y, out=t), out=wi[i])
        normalize_length(wi, distance, arena)
        self._inverse_by_area(rows, wi, distance, inverse, arena)
        return near

    def _towards_view(self, rows, near, p, u0, u1, out, arena):
        """Replace the directions of the lanes `near` by ones uniform in the solid angle."""
        everywhere = near.size == p.shape[-1]
        if not everywhere:
            rows, p, u0, u1 = rows_at(rows, near, arena), *(arena.take(a, near) for a in (p, u0, u1))
        frame = rows_of(self.frame, rows, arena)
        view = _View(*project(frame, p, arena), arena)
        x, y = view.sample(u0, u1, arena)
        wi, distance = arena.empty((3, near.size)), arena.empty(near.size)
        _direction(frame, x, y, view.height, wi, distance, arena)
        large = _is_large(frame, view)
        angle = self._seen(view)
        if self._any_round:
            beside = ~self._covers(rows, frame, view.edges, x, y, arena)
            np.copyto(angle, 0.0, where=beside)
        columns = zip((*out[0], *out[1:]), (*wi, distance, angle), strict=True)
        if everywhere:
            for whole, part in columns:
                np.copyto(whole, part, where=large)
            return
        kept = np.flatnonzero(large)
        where = near if kept.size == near.size else near[kept]
        for whole, part in columns:
            whole[where] = part if where is near else arena.take(part, kept)

    def _seen(self, view, lanes=slice(None)):
        """Solid angles of the views `lanes`, 0 of those from behind a rectangle that has one side."""
        if self._both_sides:
            return view.angle[lanes]
        return np.where(view.height[lanes] > 0.0, view.angle[lanes], np.float32(0.0))

    def _looks_large(self, rows, offset, arena):
        """Lanes near the centre, which lies at `offset` (3, N) from the point that looks."""
        with arena.frame():
            squared = dot(offset, offset, arena)
            return np.flatnonzero(np.less(squared, rows_of(self._near, rows, arena)))

    def _inverse_by_area(self, rows, wi, distance, out, arena):
        """Write area·cosθ/distance², 1/pdf of uniform points."""
        with arena.frame():
            dot(rows_of(self.frame[9:12], rows, arena), wi, arena, out=out)
            if self._both_sides:
                np.abs(out, out=out)
            else:
                at_least(np.negative(out, out=out), 0.0, out)
            np.multiply(out, rows_of(self._area, rows, arena), out=out)
            squared = np.multiply(distance, distance, out=arena.empty(distance.shape))
            np.divide(out, at_least(squared, NEAREST_SQUARED, squared), out=out)

    def _covers(self, rows, frame, edges, x, y, arena):
        """Whether points of the rectangle are no corners beside an ellipse, (N,) bool."""
        with arena.frame():
            n = x.shape[-1]
            reach, s = arena.zeros(n), arena.empty(n)
            for i, v in enumerate((x, y)):
                np.add(edges[2 * i], edges[2 * i + 1], out=s)
                np.multiply(s, -0.5, out=s)
                np.add(s, v, out=s)
                np.divide(s, frame[12 + i], out=s)
                np.multiply(s, s, out=s)
                np.add(reach, s, out=reach)
            return (reach <= 1.0 + 1e-5) | ~rows_of(self._round, rows, arena)


class _View:
    """Rectangles as seen from points: `edges` (4, N), `height` (N,) and the solid `angle` (N,), right to 1e-6 sr.

    The solid angle is the spherical excess of four angles acos(-s_i s_j) of neighbouring sides: the sum of the
    asin(s_i s_j). The s are the z components of the inward normals of the planes through the sides -y, +x, +y, -x.
    """

    def __init__(self, edges, height, arena):
        n = height.shape[-1]
        self.edges, self.height = edges, height
        self.angle, self._sides, self._rest = arena.empty(n), arena.empty((4, n)), arena.empty(n)
        x0, x1, y0, y1 = edges
        np.negative(y0, out=self._sides[0])
        np.copyto(self._sides[1], x1)
        np.copyto(self._sides[2], y1)
        np.negative(x0, out=self._sides[3])
        with arena.frame():
            h2 = np.multiply(height, height, out=arena.empty(n))
            _sine(self._sides, h2, arena, out=self._sides)
            excess = _excess(self._sides, arena)
            np.add(excess[2], excess[3], out=self._rest)
            np.add(excess[0], excess[1], out=self.angle)
            np.add(self.angle, self._rest, out=self.angle)

    def sample(self, u0, u1, arena):
        """Points x, y (N,) of the rectangles whose directions are uniform in the solid angle."""
        n = u0.shape[-1]
        x, y = arena.empty(n), arena.empty(n)
        with arena.frame():
            self._sample_x(u0, x, arena)
            self._sample_y(u1, x, y, arena)
        return x, y

    def _sample_x(self, u0, x, arena):
        n, b0, b1 = u0.shape[-1], self._sides[0], self._sides[2]
        turn, sine, t = arena.empty(n), arena.empty(n), arena.empty(n)
        # the azimuth that cuts the share u0 off the area
        np.subtract(np.multiply(u0, self.angle, out=turn), self._rest, out=turn)  # less π: signs of both turn around
        np.cos(turn, out=x)
        np.sin(turn, out=sine)
        np.add(np.multiply(x, b0, out=x), b1, out=x)
        with_sign(at_least(np.abs(sine, out=t), 1e-12, t), sine)
        np.divide(x, sine, out=x)  # its tangent, without the part of b0
        # x = height·sign(f)/sqrt(f² + b0² - 1)
        np.multiply(x, x, out=t)
        np.add(t, np.multiply(b0, b0, out=sine), out=t)
        np.subtract(t, 1.0, out=t)
        np.sqrt(at_least(t, 1e-14, t), out=t)
        np.divide(self.height, t, out=t)
        np.copysign(t, x, out=x)
        np.maximum(np.minimum(x, self.edges[1], out=x), self.edges[0], out=x)

    def _sample_y(self, u1, x, y, arena):
        """Uniform in the sine of the elevation."""
        n, (y0, y1) = u1.shape[-1], self.edges[2:]
        d2, h, t = arena.empty(n), arena.empty(n), arena.empty(n)
        np.multiply(self.height, self.height, out=t)
        np.add(np.multiply(x, x, out=d2), t, out=d2)
        _sine(y0, d2, arena, out=h)
        _sine(y1, d2, arena, out=t)
        np.subtract(t, h, out=t)
        np.multiply(t, u1, out=t)
        np.add(h, t, out=h)
        np.subtract(1.0, np.multiply(h, h, out=t), out=t)
        np.sqrt(at_least(t, 1e-14, t), out=t)
        np.multiply(h, np.sqrt(d2, out=d2), out=y)
        np.divide(y, t, out=y)
        np.maximum(np.minimum(y, y1, out=y), y0, out=y)


def project(frame, p, arena):
    """Rectangles as seen from `p` (3, N).

    Parameters
    ----------
    frame : (14, N) or (14, 1)
        Centre, unit x, y and normal, half sizes.

    Returns
    -------
    edges : (4, N)
        x0, x1, y0, y1 relative to `p`.
    height : (N,)
        Of `p` above the rectangle's plane, along the normal.
    """
    n = p.shape[-1]
    edges, height = arena.empty((4, n)), arena.empty(n)
    with arena.frame():
        offset = np.subtract(p, frame[0:3], out=arena.empty((3, n)))
        dot(offset, frame[9:12], arena, out=height)
        along = arena.empty(n)
        for i in range(2):
            dot(offset, frame[3 + 3 * i : 6 + 3 * i], arena, out=along)
            np.negative(along, out=along)
            np.subtract(along, frame[12 + i], out=edges[2 * i])
            np.add(along, frame[12 + i], out=edges[2 * i + 1])
    return edges, height


def _is_large(frame, view):
    """Whether the solid angle is sampled, (N,) bool.

    Not of points in the rectangle's own plane: rounding decides on which side they lie, and so between nothing and a
    whole hemisphere of light.
    """
    return (view.angle > _SMALLEST) & (np.abs(view.height) > _FLATTEST * (frame[12] + frame[13]))


def _direction(frame, x, y, height, wi, distance, arena):
    """Unit vectors to the points `x`, `y` of a rectangle's plane, `height` behind its normal, and their distances."""
    with arena.frame():
        t = arena.empty(x.shape)
        for i in range(3):
            np.multiply(frame[3 + i], x, out=wi[i])
            np.add(wi[i], np.multiply(frame[6 + i], y, out=t), out=wi[i])
            np.subtract(wi[i], np.multiply(frame[9 + i], height, out=t), out=wi[i])
    normalize_length(wi, distance, arena)


def _sine(a, b2, arena, out):
    """Sine a / sqrt(a² + b²); `out` may be `a`."""
    with arena.frame():
        length = np.multiply(a, a, out=arena.empty(a.shape))
        np.add(length, b2, out=length)
        np.sqrt(at_least(length, _TINY, length), out=length)
        return np.divide(a, length, out=out)


def _excess(sides, arena):
    """By how much the angle (4, N) between each of `sides` (4, N) and the next exceeds a right one, asin(s_i s_j).

    A polynomial, since numpy's arcsin takes three times as long; its error is below 1e-7, less than that of the
    product. Source: Abramowitz and Stegun, "Handbook of Mathematical Functions", 4.4.46.
    """
    x = arena.empty(sides.shape)
    with arena.frame():
        out, magnitude = arena.empty(sides.shape), arena.empty(sides.shape)
        np.multiply(sides[:3], sides[1:], out=x[:3])
        np.multiply(sides[3], sides[0], out=x[3])
        at_most(np.abs(x, out=magnitude), 1.0, magnitude)
        np.multiply(magnitude, _ARCSINE[0], out=out)
        for c in _ARCSINE[1:-1]:
            np.multiply(np.add(out, c, out=out), magnitude, out=out)
        np.add(out, _ARCSINE[-1], out=out)
        np.sqrt(np.subtract(1.0, magnitude, out=magnitude), out=magnitude)
        np.multiply(out, magnitude, out=out)
        np.subtract(0.5 * math.pi, out, out=out)
        return with_sign(out, x)
