# SPDX-License-Identifier: GPL-3.0-or-later
"""A fibre of coloured glass: the Principled Hair BSDF of Chiang et al.

Four lobes: what the surface reflects (R), what passes through (TT), what is reflected once inside (TRT), and the rest.
Each is a product of a longitudinal function M(θ_o, θ_i), which the tilt of the fibre's scales shifts, of an azimuthal
one N(φ), which follows from where the fibre was hit, and of an attenuation A by Fresnel's law and absorption. f·cosθ is
the sum over the lobes of A M N, the density the same sum with A's share of the energy.

Parameters, (N,) or (1,): `tangent` (3, N), unit, along the fibre; `h` in [-1, 1], the sine of the angle between view
and normal as seen along the fibre; `sigma` (3, ·) absorption by radius; `roughness`, `radial`, `coat` as the user gives
them (`coat` narrows R); `tilt` of the scales, radians; `ior`.

Source: Chiang et al., "A Practical and Controllable Hair and Fur Model for Production Path Tracing", Computer Graphics
Forum 35(2), 2016; Marschner et al. 2003; d'Eon et al. 2011 for M; the fits of roughness to variance by Cycles.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from .. import vecmath
from ..vecmath import cross, dot, normalize
from . import fresnel
from .base import Lobe, LobeSample

flags = Lobe.REFLECTION | Lobe.TRANSMISSION | Lobe.GLOSSY

_LOBES = 4
_LEAST, _MOST = 0.001, 1.0  # roughness
_LUMINANCE = np.float32([[0.2126], [0.7152], [0.0722]])
_LEAST_COLOR = 1e-12
_EUMELANIN = np.float32([[0.506], [0.841], [1.653]])
_PHEOMELANIN = np.float32([[0.343], [0.733], [1.924]])


def sigma_of_color(color, radial):
    """Absorption with which a fibre of radial roughness `radial` reflects `color` in all, (3, ·)."""
    root = np.log(np.maximum(color, _LEAST_COLOR)) / _albedo_scale(radial)
    return root * root


def sigma_of_melanin(melanin, redness):
    """Absorption of `melanin`, 0 to 1 as the eye sees it, of which the share `redness` is pheomelanin, (3, ·)."""
    amount = -np.log(np.maximum(1.0 - melanin, 1e-4))
    return amount * (1.0 - redness) * _EUMELANIN + amount * redness * _PHEOMELANIN


def sample(params, n, wo, uc, u0, u1, arena):
    """A direction of one of the four lobes, which `uc` chooses, weighed by all."""
    count = u0.shape[-1]
    wi, weight, pdf = arena.empty((3, count)), arena.empty((3, count)), arena.empty(count)
    with arena.frame():
        fibre = _fibre(params, wo, arena)
        lobe, rest = _chosen(fibre.shares, uc)
        variance = np.choose(lobe, _broadcast(fibre.longitudinal, count))
        sine_o = np.choose(lobe, _broadcast(fibre.sine, count))
        cosine_o = np.choose(lobe, _broadcast(fibre.cosine, count))
        # Source: d'Eon et al., "Importance Sampling for Physically-Based Hair Fiber Models", 2013.
        rest = np.maximum(rest, 1e-5)
        c = 1.0 + variance * np.log(rest + (1.0 - rest) * np.exp(-2.0 / variance))
        sine_i = -c * sine_o + _other(c) * np.cos(2.0 * math.pi * u1) * cosine_o
        sine_i = np.clip(sine_i, -1.0, 1.0)
        spread = _logistic_of(u0, fibre.scale)
        phi = np.where(lobe == _LOBES - 1, 2.0 * math.pi * u0, _turn(lobe, fibre.gamma_o, fibre.gamma_t) + spread)
        f, density = _sum(fibre, sine_i, phi, count)
        cosine_i, phi_i = _other(sine_i), phi - math.pi / 2  # the view lies at -π/2 of the basis
        local = arena.empty((3, count))
        np.multiply(cosine_i, np.cos(phi_i), out=local[0])
        np.multiply(cosine_i, np.sin(phi_i), out=local[1])
        np.copyto(local[2], sine_i)
        np.copyto(wi, vecmath.to_world(local, fibre.y, fibre.z, fibre.x, arena))
        normalize(wi, arena, out=wi)
        kept = np.isfinite(density) & (density > 1e-12)
        np.copyto(pdf, np.where(kept, density, 0.0))
        np.copyto(weight, np.where(kept, f / np.where(kept, density, 1.0), 0.0))
    return LobeSample(wi, weight, pdf)


def eval_pdf(params, n, wo, wi, arena):
    """f·cosθ (3, N) and the density."""
    count = vecmath.lanes(wo, wi)
    f, pdf = arena.empty((3, count)), arena.empty(count)
    with arena.frame():
        fibre = _fibre(params, wo, arena)
        sine_i = np.clip(dot(fibre.x, wi, arena), -1.0, 1.0)
        phi = np.arctan2(dot(fibre.z, wi, arena), dot(fibre.y, wi, arena)) + math.pi / 2
        value, density = _sum(fibre, sine_i, phi, count)
        np.copyto(f, value)
        np.copyto(pdf, density)
    return f, pdf


def albedo(params, n, wo, arena):
    """About what the fibre sends on in all, (3, N): an estimate."""
    cosine_o = _other(np.clip(dot(wo, params["tangent"], arena), -1.0, 1.0))
    reflected, _ = fresnel.dielectric(cosine_o * _other(params["h"]), params["ior"], arena)
    scale = _albedo_scale(np.clip(params["radial"], _LEAST, _MOST))
    return np.minimum(np.exp(-np.sqrt(params["sigma"]) * scale) + reflected, 1.0)


def split(params, cosine, arena):
    """What the classic methods take it for: reflection of its colour."""
    scale = _albedo_scale(np.clip(params["radial"], _LEAST, _MOST))
    return np.exp(-np.sqrt(params["sigma"]) * scale), 0.0, None, None


def _albedo_scale(radial):
    """Chiang's fit of how absorption becomes albedo (2016, eq. 9)."""
    return ((((0.245 * radial + 5.574) * radial - 10.73) * radial + 2.532) * radial - 0.215) * radial + 5.969


# -- the four lobes ----------------------------------------------------------------------------------------------------


class _Fibre(NamedTuple):
    """All that does not depend on the direction of the light.

    x, y, z: basis, x along the fibre and z away from the viewer; sine, cosine: of θ_o, shifted by the scales' tilt, of
    each lobe; longitudinal: variance of each lobe; scale: of the azimuthal logistic; gamma_o, gamma_t: angles of the
    ray across the fibre outside and inside; attenuations: (3, ·) of each lobe; shares: of the energy.
    """

    x: np.ndarray
    y: np.ndarray
    z: np.ndarray
    sine: tuple
    cosine: tuple
    longitudinal: tuple
    scale: np.ndarray
    gamma_o: np.ndarray
    gamma_t: np.ndarray
    attenuations: tuple
    shares: tuple


def _fibre(params, wo, arena):
    x, eta, h = params["tangent"], params["ior"], np.clip(params["h"], -1.0, 1.0)
    y = cross(x, wo, arena)
    normalize(y, arena, out=y)
    z = cross(x, y, arena)
    sine_o = np.clip(dot(x, wo, arena), -1.0, 1.0)
    cosine_o = _other(sine_o)
    sine_t = np.clip(sine_o / eta, -1.0, 1.0)
    sine_gamma_t = np.clip(h * cosine_o / np.sqrt(np.maximum(eta * eta - sine_o * sine_o, 1e-8)), -1.0, 1.0)
    passed = np.exp(-params["sigma"] * (2.0 * _other(sine_gamma_t) / np.maximum(_other(sine_t), 1e-4)))
    reflected, _ = fresnel.dielectric(cosine_o * _other(h), eta, arena)
    attenuations = _attenuations(reflected, passed)
    energies = [(a * _LUMINANCE).sum(axis=0) for a in attenuations]
    total = np.maximum(sum(energies), 1e-20)
    sine, cosine = _tilted(sine_o, cosine_o, -params["tilt"])
    roughness, radial = (np.clip(params[name], _LEAST, _MOST) for name in ("roughness", "radial"))
    v = _variance(roughness)
    first = _variance(np.clip((1.0 - np.clip(params["coat"], 0.0, 1.0)) * roughness, _LEAST, _MOST))
    scale = (0.265 * radial + 1.194 * radial**2 + 5.372 * radial**22) * math.sqrt(math.pi / 8)
    return _Fibre(
        x,
        y,
        z,
        sine,
        cosine,
        (first, 0.25 * v, 4.0 * v, 4.0 * v),
        scale,
        np.arcsin(h),
        np.arcsin(sine_gamma_t),
        attenuations,
        tuple(e / total for e in energies),
    )


def _variance(roughness):
    return np.square(0.726 * roughness + 0.812 * roughness**2 + 3.7 * roughness**20)


def _attenuations(reflected, passed):
    """A of R, TT, TRT and of all that follows, a geometric series."""
    inside = passed * reflected
    through = np.square(1.0 - reflected) * passed
    second = through * inside
    return reflected, through, second, second * inside / np.maximum(1.0 - inside, 1e-6)


def _tilted(sine, cosine, angle):
    """Sines and cosines of θ_o as the lobes see it: shifted by -2, 1 and 4 times the tilt, and not."""
    sines, cosines = [], []
    for turns in (-2.0, 1.0, 4.0):
        s, c = np.sin(turns * angle), np.cos(turns * angle)
        sines.append(sine * c + cosine * s)
        cosines.append(np.abs(cosine * c - sine * s))
    return (*sines, sine), (*cosines, cosine)


def _sum(fibre, sine_i, phi, count):
    """Σ A M N (3, N) and Σ share M N (N,)."""
    cosine_i = _other(sine_i)
    f, pdf = np.zeros((3, count), np.float32), np.zeros(count, np.float32)
    for lobe in range(_LOBES):
        value = _longitudinal(sine_i, cosine_i, fibre.sine[lobe], fibre.cosine[lobe], fibre.longitudinal[lobe])
        if lobe < _LOBES - 1:
            value = value * _azimuthal(phi - _turn(lobe, fibre.gamma_o, fibre.gamma_t), fibre.scale)
        else:
            value = value * (0.5 / math.pi)
        f += fibre.attenuations[lobe] * value
        pdf += fibre.shares[lobe] * value
    return f, pdf


def _turn(lobe, gamma_o, gamma_t):
    """φ by which a ray is turned that was reflected inside `lobe` - 1 times."""
    return 2.0 * lobe * gamma_t - 2.0 * gamma_o + lobe * math.pi


def _chosen(shares, uc):
    """Number of the lobe that `uc` falls into, (N,), and `uc` stretched to [0, 1) again."""
    lobe, start = np.zeros(uc.shape, np.int8), np.zeros(uc.shape, np.float32)
    width, end = np.array(np.broadcast_to(shares[0], uc.shape)), shares[0]
    for number in range(1, _LOBES):
        beyond = uc >= end
        np.copyto(lobe, number, where=beyond)
        np.copyto(start, end, where=beyond)
        np.copyto(width, shares[number], where=beyond)
        end = end + shares[number]
    return lobe, np.clip((uc - start) / np.maximum(width, 1e-12), 0.0, 1.0)


# -- functions of one angle --------------------------------------------------------------------------------------------


def _longitudinal(sine_i, cosine_i, sine_o, cosine_o, v):
    """M: von Mises-Fisher across θ, by logarithms, since 1/v reaches 1e6. Source: d'Eon et al. 2011, eq. 7."""
    normaliser = np.log(v) + 1.0 / v + np.log1p(-np.exp(-2.0 / v))
    return np.exp(_log_bessel(cosine_i * cosine_o / v) - sine_i * sine_o / v - normaliser)


def _log_bessel(x):
    """Logarithm of I0(x), x >= 0. Source: Abramowitz and Stegun, 9.8.1 and 9.8.2."""
    t = np.square(np.minimum(x, 3.75) / 3.75)
    small = np.log(_polynomial(t, (0.0045813, 0.0360768, 0.2659732, 1.2067492, 3.0899424, 3.5156229, 1.0)))
    x = np.maximum(x, 3.75)
    t = 3.75 / x
    series = (0.00392377, -0.01647633, 0.02635537, -0.02057706, 0.00916281, -0.00157565, 0.00225319, 0.01328592)
    large = x - 0.5 * np.log(x) + np.log(_polynomial(t, (*series, 0.39894228)))
    return np.where(x > 3.75, large, small)


def _polynomial(x, coefficients):
    out = coefficients[0]
    for c in coefficients[1:]:
        out = out * x + c
    return out


def _azimuthal(phi, scale):
    """N: the logistic distribution of the angle `phi`, cut at ±π."""
    phi = phi - 2.0 * math.pi * np.floor((phi + math.pi) / (2.0 * math.pi))
    e = np.exp(-np.abs(phi) / scale)
    return e / (scale * np.square(1.0 + e) * (1.0 - 2.0 * _below(scale)))


def _logistic_of(u, scale):
    """Angles drawn from the same."""
    below = _below(scale)
    share = np.clip(u * (1.0 - 2.0 * below) + below, 1e-7, 1.0 - 6e-8)
    return np.clip(scale * (np.log(share) - np.log1p(-share)), -math.pi, math.pi)


def _below(scale):
    """Share of the logistic distribution below -π."""
    return 1.0 / (1.0 + np.exp(np.minimum(math.pi / scale, 80.0)))


def _other(x):
    """The cosine that belongs to a sine, or the reverse."""
    return np.sqrt(np.maximum(1.0 - x * x, 0.0))


def _broadcast(values, count):
    return [np.broadcast_to(v, (count,)) for v in values]
