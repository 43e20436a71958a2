# SPDX-License-Identifier: GPL-3.0-or-later
"""What the groups of materials gave, side by side."""

from __future__ import annotations

import numpy as np


def joined(parts, groups, arena):
    """Directs of all groups in one array; None when no group has any."""
    found = [p for p in parts if p is not None]
    if not found:
        return None
    out = arena.empty((*found[0].shape[:-1], groups[-1][2]))
    for part, (_, start, stop) in zip(parts, groups, strict=True):
        out[..., start:stop] = 0 if part is None else part
    return out


def joined_samples(parts, groups, arena):
    """BSDF samples of all groups in one; lanes of a group without get weight 0."""
    found = [p for p in parts if p is not None]
    if not found:
        return None
    count = groups[-1][2]
    wi, weight, pdf = arena.zeros((3, count)), arena.zeros((3, count)), arena.zeros(count)
    flags = None if found[0].flags is None else arena.zeros(count, np.uint8)
    diffuse = None if found[0].diffuse is None else arena.zeros((3, count))
    for part, (_, start, stop) in zip(parts, groups, strict=True):
        if part is None:
            continue
        wi[:, start:stop], weight[:, start:stop], pdf[start:stop] = part.wi, part.weight, part.pdf
        if flags is not None:
            flags[start:stop] = part.flags
        if diffuse is not None:
            diffuse[:, start:stop] = part.diffuse
    return type(found[0])(wi, weight, pdf, flags=flags, diffuse=diffuse)
