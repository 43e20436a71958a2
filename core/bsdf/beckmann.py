# SPDX-License-Identifier: GPL-3.0-or-later
"""Beckmann and Spizzichino's microfacet distribution, as `facets` describes distributions.

Slopes of the facets are normally distributed: D = exp(-tan²θ/α²)/(π α² cos⁴θ), anisotropic alike.

Sources: Walter et al., "Microfacet Models for Refraction through Rough Surfaces", EGSR 2007; Heitz and d'Eon,
"Importance Sampling Microfacet-Based BSDFs using the Distribution of Visible Normals", EGSR 2014; Jakob, "An Improved
Visible Normal Sampling Routine for the Beckmann Distribution", 2014; Giles, "Approximating the erfinv function", GPU
Computing Gems 2, 2010.
"""

from __future__ import annotations

import math

import numpy as np

from .. import vecmath

_TINY = 1e-20
_INV_SQRT_PI = 1.0 / math.sqrt(math.pi)
_STEPS = 6  # of Newton's method; each is kept in the bracket
_LARGEST_ERF = 1.0 - 1e-7

# Coefficients of Giles' polynomials in w = -ln(1 - x²), for w < 5 and in sqrt(w) beyond, highest power first.
_NEAR = (
    2.81022636e-08,
    3.43273939e-07,
    -3.5233877e-06,
    -4.39150654e-06,
    0.00021858087,
    -0.00125372503,
    -0.00417768164,
    0.246640727,
    1.50140941,
)
_FAR = (
    -0.000200214257,
    0.000100950558,
    0.00134934322,
    -0.00367342844,
    0.00573950773,
    -0.0076224613,
    0.00943887047,
    1.00167406,
    2.83297682,
)
# Of Abramowitz and Stegun's 7.1.26, in t = 1/(1 + 0.3275911 x), highest power first; errors below 1.5e-7.
_ERFC = (1.061405429, -1.453152027, 1.421413741, -0.284496736, 0.254829592, 0.0)


def density(h, ax, ay, arena):
    """D of unit normals `h` (3, N), 0 below the horizon, (N,)."""
    out = arena.empty(h.shape[-1])
    with arena.frame():
        cos2 = np.maximum(h[2] * h[2], _TINY)
        x, y = h[0] / ax, h[1] / ay
        np.exp(-(x * x + y * y) / cos2, out=out)
        np.divide(out, np.maximum(cos2 * cos2 * (ax * ay * math.pi), _TINY), out=out)
        np.multiply(out, h[2] > 0.0, out=out)
    return out


def projected(w, ax, ay, arena):
    """cosθ/G1 of directions with z >= 0: cosθ (1 + erf a)/2 + q exp(-a²)/(2 sqrt π), q = |(αx x, αy y)|, a = cosθ/q.

    (N,)
    """
    out = arena.empty(w.shape[-1])
    with arena.frame():
        x, y, z = w[0] * ax, w[1] * ay, w[2]
        q = np.sqrt(x * x + y * y)
        a = np.minimum(z, 10.0 * q) / np.maximum(q, _TINY)  # beyond 10 nothing changes
        erfc, gauss = _erfc(a)
        np.multiply(z, 1.0 - 0.5 * erfc, out=out)
        np.copyto(out, z, where=q <= _TINY)
        np.add(out, q * gauss * (0.5 * _INV_SQRT_PI), out=out)
    return out


def sample_visible_normal(wo, ax, ay, u0, u1, arena):
    """Unit normals that `wo` (3, N), z >= 0, sees, in the local frame, (3, N).

    The surface is stretched to α = 1; the slope along the view is found by inverting its distribution, the slope across
    is normal.
    """
    h = arena.empty((3, u0.shape[-1]))
    with arena.frame():
        view = arena.empty(h.shape)
        np.multiply(wo[0], ax, out=view[0])
        np.multiply(wo[1], ay, out=view[1])
        np.copyto(view[2], wo[2])
        vecmath.normalize(view, arena, out=view)
        sine = np.sqrt(view[0] * view[0] + view[1] * view[1])
        flat = sine < 1e-6
        cosine, safe = view[2], np.maximum(sine, 1e-6)
        cos_phi, sin_phi = (
            np.where(flat, np.float32(1.0), view[0] / safe),
            np.where(flat, np.float32(0), view[1] / safe),
        )
        tangent = np.minimum(safe / np.maximum(cosine, 1e-6), 1e6)
        slope_x = _slope_along(tangent, u0)
        slope_y = _inverse_erf(2.0 * u1 - 1.0)
        np.multiply(cos_phi * slope_x - sin_phi * slope_y, -ax, out=h[0])
        np.multiply(sin_phi * slope_x + cos_phi * slope_y, -ay, out=h[1])
        h[2] = 1.0
    return vecmath.normalize(h, arena, out=h)


def _slope_along(tangent, u):
    """Slopes x along the view, whose direction has the given tangent (N,) against the normal: P(x) = u.

    In b = erf x the distribution is (1 + b + k exp(-x²))/(1 + erf a + k exp(-a²)) with k = tanθ/sqrt π, up to a = cotθ
    where facets turn away; it is monotonous, and Newton's method is held in the bracket by bisection.
    """
    a = 1.0 / tangent
    erfc, gauss = _erfc(np.minimum(a, 10.0))
    k = tangent * np.float32(_INV_SQRT_PI)
    end = 1.0 - erfc
    target = u * (1.0 + end + k * gauss)
    low, high = np.full_like(end, -1.0), end.copy()
    # A parabola in b is near exp(-x²).
    near = u * (1.0 + end + k * (1.0 - end * end))
    root = np.sqrt(np.maximum(k * (k - near + 1.0) + 0.25, 0.0))
    b = np.clip(np.where(k > 1e-6, (0.5 - root) / np.maximum(k, 1e-6), near - 1.0), low, high)
    x = _inverse_erf(b)
    for _ in range(_STEPS):
        error = 1.0 + b + k * np.exp(-x * x) - target
        above = error > 0.0
        np.copyto(high, b, where=above)
        np.copyto(low, b, where=~above)
        slope = 1.0 - x * tangent
        step = b - error / np.where(np.abs(slope) > 1e-6, slope, np.float32(1e-6))
        b = np.where((step >= low) & (step <= high), step, 0.5 * (low + high))
        x = _inverse_erf(b)
    return x


def _erfc(x):
    """(1 - erf x, exp(-x²)) of x >= 0."""
    gauss = np.exp(-x * x)
    t = 1.0 / (1.0 + 0.3275911 * x)
    return _polynomial(_ERFC, t) * gauss, gauss


def _inverse_erf(x):
    """Inverse error function, finite at ±1."""
    x = np.clip(x, -_LARGEST_ERF, _LARGEST_ERF)
    w = -np.log((1.0 - x) * (1.0 + x))
    near = _polynomial(_NEAR, np.minimum(w, 5.0) - 2.5)
    far = _polynomial(_FAR, np.sqrt(np.maximum(w, 5.0)) - 3.0)
    return np.where(w < 5.0, near, far) * x


def _polynomial(coefficients, x):
    total = np.full_like(x, coefficients[0])
    for c in coefficients[1:]:
        np.multiply(total, x, out=total)
        np.add(total, np.float32(c), out=total)
    return total
