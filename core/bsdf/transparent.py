# SPDX-License-Identifier: GPL-3.0-or-later
"""Straight passage: the surface is not there, but for its colour."""

from __future__ import annotations

import numpy as np

from .base import Lobe, LobeSample

flags = Lobe.TRANSMISSION | Lobe.DELTA | Lobe.STRAIGHT


def sample(params, n, wo, uc, u0, u1, arena):
    """The direction in which the ray already travels."""
    wi = arena.empty(wo.shape)
    np.negative(wo, out=wi)
    return LobeSample(wi, 1.0, arena.full(wo.shape[-1], np.inf))


def albedo(params, n, wo, arena):
    """1: all passes."""
    return 1.0
