# SPDX-License-Identifier: GPL-3.0-or-later
"""Statistical tests of samplers: each returns a p-value, compared with `sidak(level, tests)`.

Samplers are compared with their densities by counting directions in the cells of (cosθ, φ) and by integrating the
density over the same cells. Lost samples are a cell of their own: a density may integrate to less than one.
"""

from __future__ import annotations

import numpy as np
from scipy import stats

from zraka.core.arena import Arena

LEVEL = 1e-3
_CHUNK = 1 << 16


def sidak(level, tests):
    """Level of each of `tests` independent tests such that one of them fails by chance with probability `level`."""
    return 1.0 - (1.0 - level) ** (1.0 / tests)


def chi_square(observed, expected, least=5.0):
    """p-value of counts against expected counts; cells that expect fewer than `least` are pooled."""
    observed, expected = np.ravel(observed).astype(float), np.ravel(expected).astype(float)
    order = np.argsort(expected)
    observed, expected = observed[order], expected[order]
    pooled = np.searchsorted(np.cumsum(expected), least) + 1
    pooled = max(pooled, np.searchsorted(expected, least))
    pooled = min(pooled, expected.size - 1)
    o = np.append(observed[:pooled].sum(), observed[pooled:])
    e = np.append(expected[:pooled].sum(), expected[pooled:])
    if e[0] == 0.0:
        if o[0] > 0:
            return 0.0  # samples where none are expected
        o, e = o[1:], e[1:]
    statistic = ((o - e) ** 2 / e).sum()
    return float(stats.chi2.sf(statistic, max(o.size - 1, 1)))


def t_test(values, truth):
    """p-value of the mean of independent `values` being `truth`."""
    values = np.asarray(values, np.float64)
    error = values.std(ddof=1) / np.sqrt(values.size)
    if error == 0.0:
        return float(values[0] == truth)
    return float(2.0 * stats.t.sf(abs(values.mean() - truth) / error, values.size - 1))


def sphere_counts(wi, alive, shape):
    """Counts of unit vectors (3, N) in `shape` cells of (cosθ, φ), and of those that are not `alive`, (cells + 1,)."""
    rows = np.clip(((wi[2] + 1) / 2 * shape[0]).astype(int), 0, shape[0] - 1)
    phi = np.arctan2(wi[1], wi[0]) / (2 * np.pi) % 1.0
    columns = np.clip((phi * shape[1]).astype(int), 0, shape[1] - 1)
    counts = np.bincount((rows * shape[1] + columns)[alive], minlength=shape[0] * shape[1])
    return np.append(counts, np.count_nonzero(~alive))


def sphere_integral(density, shape, fine):
    """∫ density over each of the cells, by the midpoint rule on `fine` × `fine` points a cell, (cells,) float64.

    ``density(wi (3, n)) -> (n,)``.
    """
    rows, columns = shape[0] * fine, shape[1] * fine
    z = ((np.arange(rows) + 0.5) / rows * 2 - 1)[:, None]
    phi = ((np.arange(columns) + 0.5) / columns * 2 * np.pi)[None, :]
    r = np.sqrt(1 - z * z)
    wi = np.stack(np.broadcast_arrays(r * np.cos(phi), r * np.sin(phi), z)).reshape(3, -1).astype(np.float32)
    values = np.empty(wi.shape[1])
    for start in range(0, wi.shape[1], _CHUNK):
        part = slice(start, start + _CHUNK)
        values[part] = density(np.ascontiguousarray(wi[:, part]))
    values *= 4 * np.pi / values.size
    return values.reshape(shape[0], fine, shape[1], fine).sum(axis=(1, 3)).ravel()


def check_sampler(sample, density, count, shape=(32, 64), fine=12, seed=0):
    """p-value that directions of `sample` follow `density`.

    Parameters
    ----------
    sample : callable
        ``sample(u (3, n), arena) -> (wi (3, n), pdf (n,))``, pdf 0 for lost samples.
    density : callable
        ``density(wi (3, n), arena) -> (n,)``.
    """
    arena = Arena()
    u = np.random.default_rng(seed).random((3, count), np.float32)

    def dense(wi):
        with arena.frame():
            return np.array(density(wi, arena))

    with arena.frame():
        wi, pdf = sample(u, arena)
        observed = sphere_counts(wi, pdf > 0.0, shape)
    expected = sphere_integral(dense, shape, fine) * count
    lost = count - expected.sum()
    if abs(lost) < 0.005 * count:  # not told apart from the error of the integral
        return chi_square(observed[:-1], expected)
    return chi_square(observed, np.append(expected, max(lost, 0.0)))
