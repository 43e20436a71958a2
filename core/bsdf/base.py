# SPDX-License-Identifier: GPL-3.0-or-later
"""What all scattering models share. Their contract is in docs/design.md, "A scattering model"."""

from __future__ import annotations

import enum
from typing import NamedTuple

import numpy as np


class Lobe(enum.Flag):
    """What a lobe does."""

    REFLECTION = enum.auto()
    TRANSMISSION = enum.auto()
    DIFFUSE = enum.auto()
    GLOSSY = enum.auto()
    DELTA = enum.auto()
    STRAIGHT = enum.auto()  # passes on unbent: not a hit, `transparent_depth` counts it
    CLEAR = enum.auto()  # of a sample: smooth enough for the film to be seen through (`core.methods.clear_glass`)


class LobeSample(NamedTuple):
    """A sampled direction; `weight` is f·|cos|/pdf without the lobe's colour, `pdf` is inf for delta lobes."""

    wi: np.ndarray
    weight: np.ndarray | float
    pdf: np.ndarray
    eta: np.ndarray | None = None


class BSDFSample(NamedTuple):
    """A sampled direction of a whole surface.

    wi (3, N); weight (3, N) = f·|cos|/pdf with colours; pdf (N,), inf for delta lobes; eta (N,) or None;
    straight (N,) bool or None: lanes that passed through unbent; flags (N,) uint8 or None: value of the chosen lobe's
    flags; diffuse (3, N) or None: the diffuse lobes' share of the weight.
    """

    wi: np.ndarray
    weight: np.ndarray
    pdf: np.ndarray
    eta: np.ndarray | None = None
    straight: np.ndarray | None = None
    flags: np.ndarray | None = None
    diffuse: np.ndarray | None = None
