# SPDX-License-Identifier: GPL-3.0-or-later
"""Fresnel reflectance of dielectrics and metals, and its averages over the hemisphere.

`cosine` (N,) is measured from the normal or half vector and lies in [0, 1]; `eta` is η_t/η_i, (N,) or (1,).
"""

from __future__ import annotations

import numpy as np

from ..limits import at_least, within

_LEAST_COSINE = 1e-7  # keeps total reflection total where the cosine vanishes


def dielectric(cosine, eta, arena):
    """Exact reflectance of unpolarised light and the cosine of the refracted direction, (N,) each.

    Total internal reflection gives 1 and a cosine of 0, without a branch. cos²θ_t is formed as
    (cos² + (η - 1)(η + 1))/η², which stays exact as η goes to 1. Source: PBRT, 4th ed., 9.3.5.
    """
    n = max(cosine.size, eta.size)
    reflectance, cos_t = arena.empty(n), arena.empty(n)
    with arena.frame():
        rise, square = arena.empty(eta.shape), arena.empty(eta.shape)
        c, g, t = arena.empty(n), arena.empty(n), arena.empty(n)
        np.subtract(eta, 1.0, out=rise)
        np.add(eta, 1.0, out=square)
        np.multiply(rise, square, out=rise)
        np.multiply(eta, eta, out=square)
        at_least(cosine, _LEAST_COSINE, c)
        np.multiply(c, c, out=g)
        np.add(g, rise, out=g)
        at_least(g, 0.0, g)
        np.sqrt(g, out=g)
        np.divide(g, eta, out=cos_t)
        np.add(c, g, out=t)  # perpendicular: (c - η c_t)/(c + η c_t)
        np.subtract(c, g, out=reflectance)
        np.divide(reflectance, t, out=reflectance)
        np.multiply(c, square, out=c)  # parallel: (η c - c_t)/(η c + c_t)
        np.add(c, g, out=t)
        np.subtract(c, g, out=c)
        np.divide(c, t, out=c)
        np.multiply(reflectance, reflectance, out=reflectance)
        np.multiply(c, c, out=c)
        np.add(reflectance, c, out=reflectance)
        np.multiply(reflectance, 0.5, out=reflectance)
    return reflectance, cos_t


def interpolation(reflectance, eta, arena, out=None):
    """Where `reflectance` lies between its value at normal incidence (0) and 1 (1), (N,).

    It carries the exact curve over to an F0 that was tinted: F = mix(F0, 1, s). Source: behaviour of Cycles'
    generalised Schlick Fresnel.
    """
    if out is None:
        out = arena.empty(reflectance.shape)
    f0 = f0_from_ior(eta)
    np.subtract(reflectance, f0, out=out)
    np.divide(out, 1.0 - f0, out=out)
    return within(out, 0.0, 1.0, out)


def mix_to_white(f0, s, arena):
    """F0 + (1 - F0) s, with `f0` (N,), (1,), (3, N) or (3, 1)."""
    rest = np.subtract(1.0, f0)
    out = arena.empty(np.broadcast_shapes(f0.shape, s.shape))
    np.multiply(rest, s, out=out)
    return np.add(out, f0, out=out)


def schlick(cosine, f0, arena):
    """Schlick's F0 + (1 - F0)(1 - cosθ)⁵. Source: Schlick, Computer Graphics Forum 13(3), 1994."""
    return mix_to_white(f0, _fifth_power(cosine, arena), arena)


def f82_drop(f0, tint):
    """Coefficient B of `f82_tint`, of the shape of `f0` and `tint`.

    At cosθ = 1/7 the reflectance shall be `tint` times Schlick's: F_S - B c (1 - c)⁶ = tint F_S.
    Source: Kutz, Hašan and Edmondson, "Novel Aspects of the Adobe Standard Material", 2021.
    """
    schlick_there = f0 + (1.0 - f0) * (6 / 7) ** 5
    return schlick_there * (1.0 - tint) * (7.0 / (6 / 7) ** 6)


def f82_tint(cosine, f0, drop, arena):
    """Reflectance of a metal, (3, N): Schlick's less `drop` · cosθ (1 - cosθ)⁶, clamped to [0, 1]."""
    s = _fifth_power(cosine, arena)
    out = mix_to_white(f0, s, arena)
    if drop.any():
        with arena.frame():
            t, loss = arena.empty(cosine.shape), arena.empty(out.shape)
            np.subtract(1.0, cosine, out=t)
            np.multiply(t, s, out=t)
            np.multiply(t, cosine, out=t)
            np.multiply(drop, t, out=loss)
            np.subtract(out, loss, out=out)
        within(out, 0.0, 1.0, out)
    return out


def _fifth_power(cosine, arena):
    """(1 - cosine)⁵."""
    out = arena.empty(cosine.shape)
    with arena.frame():
        t = arena.empty(cosine.shape)
        np.subtract(1.0, cosine, out=t)
        np.multiply(t, t, out=out)
        np.multiply(out, out, out=out)
        np.multiply(out, t, out=out)
    return out


def f0_from_ior(ior):
    """Reflectance at normal incidence, ((η - 1)/(η + 1))²."""
    r = (ior - 1.0) / (ior + 1.0)
    return r * r


def ior_from_f0(f0):
    """Relative index above 1 that reflects `f0` at normal incidence; `f0` is kept below 0.99."""
    root = np.sqrt(np.clip(f0, 0.0, 0.99))
    return (1.0 + root) / (1.0 - root)


def dielectric_average(eta):
    """∫ 2 cosθ F(cosθ, η) dcosθ over [0, 1]. Source: the fit of Kulla and Conty, SIGGRAPH course 2017."""
    above = (eta - 1.0) / (4.08567 + 1.00071 * eta)
    below = 0.997118 + eta * (0.1014 - eta * (0.965241 + eta * 0.130607))
    return np.where(eta < 1.0, below, above)


def f82_average(f0, drop):
    """∫ 2 cosθ F dcosθ of `f82_tint`, in closed form: mix(F0, 1, 1/21) - B/126."""
    return f0 + (1.0 - f0) / 21.0 - drop / 126.0
