# SPDX-License-Identifier: GPL-3.0-or-later
"""Cryptomatte: what covers which share of a pixel, as layers of ranked pairs of id and coverage.

An id is the hash of a name, stored in the bits of a float. Source: Friedman and Jones, "Fully automatic ID mattes with
support for motion blur and transparency", SIGGRAPH 2015, and the Cryptomatte specification, version 1.2.0.
"""

from __future__ import annotations

import json

import numpy as np

_MASK = 0xFFFFFFFF


def matte_names(compiled, scene, options):
    """Names by object, material and asset number, as Cycles gives them, by matte."""
    described = {id(m) for x in scene.instances for m in x.materials}
    described |= {id(x.material) for x in (*scene.spheres, *scene.curves, *scene.planes)}
    objects = [x.name for x in scene.objects]
    return {
        "crypto_object": objects,
        "crypto_material": [m.name if id(m) in described else "default_surface" for m in compiled.geometry.materials],
        "crypto_asset": [options.assets.get(name, name) for name in objects],
    }


def name_hash(name):
    """MurmurHash3 (32 bits, seed 0) of a name in UTF-8."""
    data = name.encode()
    h, whole = 0, len(data) & ~3
    for start in range(0, whole, 4):
        h ^= _scrambled(int.from_bytes(data[start : start + 4], "little"))
        h = (_rotated(h, 13) * 5 + 0xE6546B64) & _MASK
    h ^= _scrambled(int.from_bytes(data[whole:], "little"))  # nothing left scrambles to 0
    h ^= len(data)
    for shift, factor in ((16, 0x85EBCA6B), (13, 0xC2B2AE35)):
        h = ((h ^ h >> shift) * factor) & _MASK
    return h ^ h >> 16


def _scrambled(word):
    return _rotated(word * 0xCC9E2D51 & _MASK, 15) * 0x1B873593 & _MASK


def _rotated(x, bits):
    return (x << bits | x >> (32 - bits)) & _MASK


def name_id(name):
    """The hash of a name with an exponent that makes it a finite, normal float."""
    h = name_hash(name)
    return h ^ 1 << 23 if h >> 23 & 255 in (0, 255) else h


def metadata(layer, names):
    """The fields that a file needs for names to be found again.

    Parameters
    ----------
    layer : str
        Name of the layer with its pass, e.g. ``"ViewLayer.CryptoObject"``.
    names : iterable of str

    Returns
    -------
    dict of str to str
    """
    prefix = f"cryptomatte/{name_hash(layer):08x}"[:19] + "/"
    manifest = {name: f"{name_id(name):08x}" for name in names}
    fields = {"name": layer, "hash": "MurmurHash3_32", "conversion": "uint32_to_float32"}
    fields["manifest"] = json.dumps(manifest, separators=(",", ":"), ensure_ascii=False)
    return {prefix + key: value for key, value in fields.items()}


def ranked(number, weight, ids, layers):
    """Layers of a picture.

    Parameters
    ----------
    number : (S, P) int
        What each of S samples of P pixels met, a row of `ids`.
    weight : (S, P) float32
        How much of the sample it covers; 0 where nothing was met.
    ids : (K,) uint32
        Equal ids count as one.
    layers : int
        Of two ranks each.

    Returns
    -------
    (4 · layers, P) float32
        Rows id, coverage, id, coverage..., the largest coverage first.
    """
    out = np.zeros((4 * layers, number.shape[1]), np.float32)
    found = ids[number]
    alone = (found == found[0]).all(axis=0)  # most pixels show one thing
    coverage = weight.mean(axis=0)
    first = np.flatnonzero(alone & (coverage > 0))
    out[0, first], out[1, first] = found[0, first].view(np.float32), coverage[first]
    rest = np.flatnonzero(~alone)
    out[:, rest] = _ranked(found[:, rest], weight[:, rest], layers)
    return out


def _ranked(found, weight, layers):
    """The layers of pixels by the ids (S, P) that their samples met."""
    samples, pixels = found.shape
    out = np.zeros((4 * layers, pixels), np.float32)
    pixel = np.tile(np.arange(pixels, dtype=np.uint64), samples)
    met = np.flatnonzero(weight.reshape(-1) > 0)
    key = pixel[met] << np.uint64(32) | found.reshape(-1)[met].astype(np.uint64)
    key, owner = np.unique(key, return_inverse=True)
    coverage = (np.bincount(owner, weight.reshape(-1)[met], key.size) / samples).astype(np.float32)
    pixel = (key >> np.uint64(32)).astype(np.intp)
    order = np.lexsort((-coverage, pixel))
    rank = np.arange(order.size) - np.searchsorted(pixel, pixel[order])
    order, rank = order[rank < 2 * layers], rank[rank < 2 * layers]
    out[2 * rank, pixel[order]] = key[order].astype(np.uint32).view(np.float32)
    out[2 * rank + 1, pixel[order]] = coverage[order]
    return out
