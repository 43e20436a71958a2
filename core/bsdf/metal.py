# SPDX-License-Identifier: GPL-3.0-or-later
"""Fresnel curves of metals with optical constants or a thin film, and dielectrics with one, for reflecting lobes.

Parameters: `n`, `k` (3, ·) of a metal's complex index; `f0`, `tint` of the F82-tint curve as of `conductor`; `eta`,
`f0` as of `dielectric`; with a film `film` (its index) and `thickness` (nm), (N,) or (1,), and `film_fitted` where the
film is that of `thin_film`'s older response. All give (3, N).
"""

from __future__ import annotations

import numpy as np

from . import fresnel, glossy, thin_film


def physical(params, cosine, arena):
    """A metal of index n + ik."""
    return thin_film.conductor(cosine, params["n"], params["k"])


def physical_film(params, cosine, arena):
    """The same under a film."""
    return thin_film.over_metal(cosine, params["n"], params["k"], params["film"], params["thickness"], arena)


def f82_film(params, cosine, arena):
    """An F82-tint metal under a film, its index guessed from the curve."""
    f0 = params["f0"]
    edge = f82_at_edge(f0, fresnel.f82_drop(f0, params["tint"]))
    n, k = thin_film.index_of(f0, edge)
    return thin_film.over_metal(cosine, n, k, params["film"], params["thickness"], arena, f82=edge)


def dielectric_film(params, cosine, arena):
    """A dielectric's surface under a film."""
    film = params["film"], params["thickness"], arena, "film_fitted" in params
    reflected = thin_film.over_dielectric(cosine, params["eta"], *film)
    return thin_film.tinted(reflected, params["f0"], params["eta"])


def physical_average(n, k):
    """∫ 2 cosθ F dcosθ, by the F82 curve through the values at 0° and 82°. Source: Cycles."""
    f0 = thin_film.conductor(np.ones(1, np.float32), n, k)
    edge = thin_film.conductor(np.full(1, 1 / 7, np.float32), n, k)
    return np.clip(fresnel.f82_average(f0, thin_film.drop_through(f0, edge)), 0.0, 1.0)


def f82_at_edge(f0, drop):
    """The F82 curve's value at cosθ = 1/7."""
    schlick_there = f0 + (1.0 - f0) * (6 / 7) ** 5
    return np.clip(schlick_there - drop * ((6 / 7) ** 6 / 7.0), 0.0, 1.0)


def lobes(reflectance):
    """(GGX lobe, mirror) of a Fresnel curve."""
    return _LOBES[reflectance]


def _pair(reflectance):
    body = {"reflectance": staticmethod(reflectance), "__doc__": reflectance.__doc__}
    return type("Rough", (glossy.Rough,), body), type("Mirror", (glossy.Mirror,), body)


_LOBES = {curve: _pair(curve) for curve in (physical, physical_film, f82_film, dielectric_film)}
