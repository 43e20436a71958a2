# SPDX-License-Identifier: GPL-3.0-or-later
"""Solid angle of rectangles and directions uniform in it.

Source: Urena, Fajardo and King, "An Area-Preserving Parametrization for Spherical Rectangles", EGSR 2013. The
rectangle lies at z = -height of a frame around the point that looks, between the *edges* x0, x1, y0, y1.
"""

from __future__ import annotations

import math

import numpy as np

from ..vecmath import dot

_TINY = 1e-30
_ARCSINE = (-0.0012624911, 0.0066700901, -0.0170881256, 0.0308918810, -0.0501743046, 0.0889789874, -0.2145988016)
_ARCSINE += (1.5707963050,)


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


def solid_angle(edges, height, arena):
    """Solid angles, (N,), right to 1e-6 sr.

    The spherical excess of four angles acos(-s_i s_j) of neighbouring sides is the sum of the asin(s_i s_j).
    """
    out = arena.zeros(height.shape)
    with arena.frame():
        sides, excess = _sides(edges, height, arena), arena.empty(height.shape)
        for i in range(4):
            np.add(out, _excess(sides, i, excess, arena), out=out)
    return out


def sample_rectangle(edges, height, angle, u0, u1, arena):
    """Points x, y (N,) of the rectangles whose directions are uniform in the solid angles `angle`."""
    n = u0.shape[-1]
    x0, x1, y0, y1 = edges
    x, y = arena.empty(n), arena.empty(n)
    with arena.frame():
        sides = _sides(edges, height, arena)
        b0, b1 = sides[0], sides[2]
        turn, t = arena.empty(n), arena.empty(n)
        # the azimuth that cuts the share u0 off the area
        np.multiply(u0, angle, out=turn)
        np.add(turn, math.pi, out=turn)
        np.subtract(turn, _excess(sides, 2, t, arena), out=turn)
        np.subtract(turn, _excess(sides, 3, t, arena), out=turn)
        np.cos(turn, out=x)
        np.multiply(x, b0, out=x)
        np.subtract(x, b1, out=x)
        np.sin(turn, out=turn)
        np.copysign(np.maximum(np.abs(turn, out=t), 1e-12, out=t), turn, out=turn)
        np.divide(x, turn, out=x)  # its tangent, without the part of b0
        # x = height·sign(f)/sqrt(f² + b0² - 1)
        np.multiply(x, x, out=t)
        np.add(t, np.multiply(b0, b0, out=turn), out=t)
        np.subtract(t, 1.0, out=t)
        np.sqrt(np.maximum(t, 1e-14, out=t), out=t)
        np.divide(height, t, out=t)
        np.copysign(t, x, out=x)
        np.clip(x, x0, x1, out=x)
        # along y, uniform in the sine of the elevation
        d2, h = arena.empty(n), arena.empty(n)
        np.add(np.multiply(x, x, out=d2), np.multiply(height, height, out=t), out=d2)
        _sine(y0, d2, h)
        _sine(y1, d2, t)
        np.subtract(t, h, out=t)
        np.multiply(t, u1, out=t)
        np.add(h, t, out=h)
        np.subtract(1.0, np.multiply(h, h, out=t), out=t)
        np.sqrt(np.maximum(t, 1e-14, out=t), out=t)
        np.multiply(h, np.sqrt(d2, out=d2), out=y)
        np.divide(y, t, out=y)
        np.clip(y, y0, y1, out=y)
    return x, y


def _sides(edges, height, arena):
    """The z components of the inward normals of the planes through the sides -y, +x, +y, -x, (4, N)."""
    x0, x1, y0, y1 = edges
    sides = arena.empty((4, height.shape[-1]))
    with arena.frame():
        h2 = np.multiply(height, height, out=arena.empty(height.shape))
        for i, edge in enumerate((y0, x1, y1, x0)):
            _sine(edge, h2, sides[i])
    np.negative(sides[0], out=sides[0])
    np.negative(sides[3], out=sides[3])
    return sides


def _excess(sides, i, out, arena):
    """By how much the angle between sides `i` and `i + 1` exceeds a right one, asin(s_i s_j).

    A polynomial, since numpy's arcsin takes three times as long; its error is below 1e-7, less than that of the
    product. Source: Abramowitz and Stegun, "Handbook of Mathematical Functions", 4.4.46.
    """
    with arena.frame():
        x, magnitude = arena.empty(out.shape), arena.empty(out.shape)
        np.multiply(sides[i], sides[(i + 1) % 4], out=x)
        np.minimum(np.abs(x, out=magnitude), 1.0, out=magnitude)
        np.multiply(magnitude, _ARCSINE[0], out=out)
        for c in _ARCSINE[1:-1]:
            np.multiply(np.add(out, c, out=out), magnitude, out=out)
        np.add(out, _ARCSINE[-1], out=out)
        np.sqrt(np.subtract(1.0, magnitude, out=magnitude), out=magnitude)
        np.multiply(out, magnitude, out=out)
        np.subtract(0.5 * math.pi, out, out=out)
        return np.copysign(out, x, out=out)


def _sine(a, b2, out):
    """Sine a / sqrt(a² + b²)."""
    np.multiply(a, a, out=out)
    np.add(out, b2, out=out)
    np.sqrt(np.maximum(out, _TINY, out=out), out=out)
    return np.divide(a, out, out=out)
