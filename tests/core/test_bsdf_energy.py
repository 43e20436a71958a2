# SPDX-License-Identifier: GPL-3.0-or-later
from __future__ import annotations

import numpy as np
import pytest

from zraka.core.arena import Arena
from zraka.core.bsdf import energy, lookup

RNG = np.random.default_rng(1)
MU, ALPHA, ETA = (RNG.uniform(low, high, 50).astype(np.float32) for low, high in ((0, 1), (0, 1), (1.1, 2.5)))
LOOKUPS = {
    "reflection": lambda mu, alpha, eta: energy.reflection(mu, alpha, Arena()),
    "glass": lambda mu, alpha, eta: energy.glass(mu, alpha, eta, None, Arena()),
    "schlick": lambda mu, alpha, eta: (energy.schlick(mu, alpha, eta, Arena()),),
}


@pytest.mark.parametrize("name", LOOKUPS)
@pytest.mark.parametrize("varies", [(True, True), (True, False), (False, True), (False, False)])
def test_a_lane_alone_gets_what_it_gets_among_others(name, varies):
    """To the last bit: else pictures would depend on chunks."""
    alpha, eta = (a if v else a[:1] for a, v in zip((ALPHA, ETA), varies, strict=True))
    together = LOOKUPS[name](MU, alpha, eta)
    for k in range(MU.size):
        one = (a[k : k + 1] if a.size > 1 else a for a in (MU, alpha, eta))
        for alone, whole in zip(LOOKUPS[name](*one), together, strict=True):
            assert alone[0] == (whole[k] if whole.size > 1 else whole[0])


@pytest.mark.parametrize("constant", [True, False])
def test_two_coordinates_round_alike_for_one_lane_and_for_many(constant):
    tables = RNG.random((2, 5, 7), np.float32)
    y = ALPHA[:1] if constant else ALPHA
    together = lookup.bilinear(tables, y, MU, Arena())
    for k in range(MU.size):
        alone = lookup.bilinear(tables, y if constant else y[k : k + 1], MU[k : k + 1], Arena())
        assert [a[0] for a in alone] == [whole[k] for whole in together]
