# SPDX-License-Identifier: GPL-3.0-or-later
"""Interference at a thin transparent film over a dielectric or a metal.

`thickness` is in nm, `film` the film's index relative to the medium outside. The light that is reflected at the film's
two faces is summed as Airy did, for both polarisations, and turned into colours by the Fourier transform of the eye's
response instead of wave by wave. The table of that transform is `thin_film.npz`, made by
`tests/addon/nodes/make_thin_film.py`.

Sources: Belcour and Barla, "A Practical Extension to Microfacet Theory for the Modeling of Varying Iridescence",
SIGGRAPH 2017; Born and Wolf, "Principles of Optics", 7th ed., 14.4.1, for the phases of metals; what Cycles does beyond
(films below 1 nm fade out, the series ends after the third term, tinted reflectances).
"""

from __future__ import annotations

import functools
import os

import numpy as np

from ..vecmath import turned
from . import fresnel, lookup

THINNEST = 0.1
"""nm; what is not thicker is no film."""

_TERMS = 3
_TINY = 1e-20


def over_dielectric(cosine, eta, film, thickness, arena, fitted=False):
    """Reflectance (3, N) of a film over a dielectric of relative index `eta`, at cosines (N,) from outside.

    With `fitted`, the eye's response is a sum of Gaussians and films below 30 nm fade out, as before Blender 5.0.
    """
    film = _faded(film, thickness, 30.0 if fitted else 1.0)
    seen = _fitted_sensitivity if fitted else _sensitivity
    upper, cos_film, total = _interface(cosine, film)
    lower, _, total_below = _interface(cos_film, eta / film)
    path = 2.0 * film * thickness * cos_film
    out = arena.zeros((3, cosine.size))
    for above, below in zip(upper, lower, strict=True):
        # Each face turns the wave by 0 or π, the sign of its amplitude; from within, the upper face by the opposite.
        sign = np.where((above >= 0.0) == (below >= 0.0), np.float32(-1.0), np.float32(1.0))
        out += _airy(np.square(above), np.square(below), path, (sign, np.zeros_like(sign)), arena, seen)
    np.multiply(out, 0.5, out=out)
    np.copyto(out, 1.0, where=total | total_below)
    return np.clip(out, 0.0, 1.0, out=out)


def over_metal(cosine, n, k, film, thickness, arena, f82=None):
    """Reflectance (3, N) of a film over a metal of index n + ik, (3, ·) each.

    With `f82` (3, ·), the metal's reflectance at 82°, its face reflects as the F82 curve through that and its own value
    at normal incidence; the phases stay those of n and k.
    """
    film = _faded(film, thickness)
    upper, cos_film, total = _interface(cosine, film)
    n, k = n / film, k / film  # of the metal seen from within the film
    lower, phases = _metal_interface(cos_film, n, k)
    if f82 is not None:
        square = k * k
        f0 = (np.square(n - 1.0) + square) / (np.square(n + 1.0) + square)
        curve = fresnel.f82_tint(cos_film, f0, drop_through(f0, f82), arena)
        lower = (curve, curve)
    path = 2.0 * film * thickness * cos_film
    out = arena.zeros((3, cosine.size))
    for above, below, (real, imaginary) in zip(upper, lower, phases, strict=True):
        sign = np.where(above >= 0.0, np.float32(-1.0), np.float32(1.0))
        out += _airy(np.square(above), below, path, (sign * real, sign * imaginary), arena)
    np.multiply(out, 0.5, out=out)
    np.copyto(out, 1.0, where=total)
    return np.clip(out, 0.0, 1.0, out=out)


def tinted(reflectance, f0, eta):
    """Carry a coloured `reflectance` (3, N) over to the tinted value `f0` at normal incidence: as F/F0 grows to 1.

    Source: Cycles' generalised Schlick Fresnel with a film.
    """
    real = fresnel.f0_from_ior(eta)
    share = np.clip((1.0 - reflectance) / np.maximum(1.0 - real, _TINY), 0.0, 1.0)
    factor = 1.0 + share * (f0 / np.maximum(real, 1e-5) - 1.0)
    keep = (real > 1e-5) & (reflectance < 1.0).any(axis=0)
    return np.multiply(reflectance, np.where(keep, factor, np.float32(1.0)))


def drop_through(f0, f82):
    """Coefficient B of `fresnel.f82_tint` whose curve passes through `f82` at cosθ = 1/7."""
    schlick_there = f0 + (1.0 - f0) * (6 / 7) ** 5
    return (schlick_there - f82) * (7.0 / (6 / 7) ** 6)


def index_of(f0, f82):
    """(n, k) of a metal from its reflectance at normal incidence and at 82°.

    Source: Gulbrandsen, "Artist Friendly Metallic Fresnel", JCGT 3(4), 2014, with `f82` in the place of its edge tint.
    """
    r = np.minimum(f0, 0.999)
    root = np.sqrt(r)
    most = (1.0 + root) / (1.0 - root)
    n = most + ((1.0 - r) / (1.0 + r) - most) * f82
    k2 = (r * np.square(n + 1.0) - np.square(n - 1.0)) / (1.0 - r)
    return n, np.sqrt(np.maximum(k2, 0.0))


def _faded(film, thickness, least=1.0):
    """The film's index, which below `least` nm goes over into the outside's."""
    t = np.clip(thickness / least, 0.0, 1.0)
    return 1.0 + (np.maximum(film, 1e-5) - 1.0) * (t * t * (3.0 - 2.0 * t))


def _interface(cosine, eta):
    """Amplitudes (s, p) reflected at an interface of index `eta`, the cosine beyond, and where all is reflected.

    Signs are those of a wave that meets a denser medium at normal incidence with r_p > 0.
    """
    beyond2 = (eta * eta - 1.0) + cosine * cosine
    total = beyond2 <= 0.0
    scaled = np.sqrt(np.maximum(beyond2, 0.0))  # η cosθt
    cos_t = scaled / eta
    s = (cosine - scaled) / np.maximum(cosine + scaled, _TINY)
    p = (eta * cosine - cos_t) / np.maximum(eta * cosine + cos_t, _TINY)
    return (s, p), cos_t, total


def _metal_interface(cosine, n, k):
    """Reflectances and phase factors (cos, sin), each a pair of s and p, of (3, N).

    With a + ib = sqrt((n + ik)² - sin²θ).
    """
    square = n * n - k * k
    twice = 2.0 * n * k
    t1 = square - (1.0 - cosine * cosine)
    t2 = np.sqrt(t1 * t1 + twice * twice)
    a = np.sqrt(np.maximum(0.5 * (t2 + t1), 0.0))
    b = np.sqrt(np.maximum(0.5 * (t2 - t1), 0.0))
    rest = b * b
    s = (np.square(cosine - a) + rest) / np.maximum(np.square(cosine + a) + rest, _TINY)
    x, y = square * cosine, twice * cosine
    p = (np.square(x - a) + np.square(y - b)) / np.maximum(np.square(x + a) + np.square(y + b), _TINY)
    both = a * a + rest
    phase_s = _unit(cosine * cosine - both, -2.0 * cosine * b)
    phase_p = _unit(np.square((n * n + k * k) * cosine) - both, 2.0 * cosine * (twice * a - square * b))
    return (s, p), (phase_s, phase_p)


def conductor(cosine, n, k):
    """Reflectance (3, N) of unpolarised light by a metal of index n + ik."""
    (s, p), _ = _metal_interface(cosine, n, k)
    return 0.5 * (s + p)


def _unit(real, imaginary):
    """A complex number of length 1; 1 for zero."""
    length = np.sqrt(real * real + imaginary * imaginary)
    safe = np.maximum(length, _TINY)
    return np.where(length > 0.0, real / safe, np.float32(1.0)), imaginary / safe


def _airy(upper, lower, path, phase, arena, seen=None):
    """Reflectance (3, N) of one polarisation.

    Parameters
    ----------
    upper, lower : (N,) or (3, N)
        Reflectances of the faces.
    path : (N,)
        Difference of the optical paths, nm.
    phase : pair of (N,) or (3, N)
        exp(i φ) of the turns at both faces.
    seen : callable, optional
        Sensitivity to the paths, in the place of the table.
    """
    seen = seen or _sensitivity
    through = 1.0 - upper
    both = upper * lower
    root = np.sqrt(both)
    inner = through * through * lower / np.maximum(1.0 - both, _TINY)
    real, imaginary = phase
    sum_real, sum_imaginary = real, imaginary
    total = arena.zeros((3, path.size))
    coefficient = inner - through
    for term in range(1, _TERMS + 1):
        coefficient = coefficient * root
        seen_real, seen_imaginary = seen(path * float(term), arena)
        total += 2.0 * coefficient * (sum_real * seen_real + sum_imaginary * seen_imaginary)
        sum_real, sum_imaginary = (
            sum_real * real - sum_imaginary * imaginary,
            sum_real * imaginary + sum_imaginary * real,
        )
    total += inner + upper
    return total


@functools.cache
def _table():
    """The transform, (2, 3, K) float32, and its reach in nm."""
    with np.load(os.path.join(os.path.dirname(__file__), "thin_film.npz")) as stored:
        table = stored["sensitivity"]
        return table, float(stored["step"]) * (table.shape[-1] - 1)


def _sensitivity(path, arena):
    """Real and imaginary part of what is seen of waves that differ by `path` nm, (3, N) each."""
    table, reach = _table()
    at = path * (1.0 / reach)
    return tuple(np.stack([lookup.linear(row, at, arena) for row in part]) for part in table)


# Gaussians of wave numbers that make up X, Y, Z and X's second hump: height, centre and variance.
# Source: Belcour and Barla 2017, supplemental material; the result is divided by the integral of Y.
_GAUSSIANS = (
    (0, 5.4856e-13, 1.6810e6, 4.3278e9),
    (1, 4.4201e-13, 1.7953e6, 9.3046e9),
    (2, 5.2481e-13, 2.2084e6, 6.6121e9),
    (0, 9.7470e-14, 2.2399e6, 4.5282e9),
)
_INTEGRAL = 1.0685e-7
_FROM_WHITE = np.array(  # XYZ, white being (1, 1, 1), to Rec.709
    [
        (3.080399, -1.537383, -0.543016),
        (-0.921223, 1.875968, 0.045256),
        (0.052874, -0.203977, 1.151103),
    ],
    np.float32,
)


def _fitted_sensitivity(path, arena):
    """As `_sensitivity`, by the fit; for waves turned by 0 or π alone, so that it has no imaginary part."""
    phase = path * np.float32(2e-9 * np.pi)
    square = phase * phase
    xyz = arena.zeros((3, path.size))
    for row, height, centre, variance in _GAUSSIANS:
        scale = height * (2.0 * np.pi * variance) ** 0.5 / _INTEGRAL
        xyz[row] += np.cos(centre * phase) * np.exp(-variance * square) * np.float32(scale)
    return turned(_FROM_WHITE, xyz), np.zeros((3, 1), np.float32)
