# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's Blackbody node: the colour of a glowing body, luminance 1.

Source: the fit of Planck's law in Rec.709 from 800 K to 12,000 K in Cycles, `kernel/tables.h` and
`kernel/svm/math_util.h`.
"""

from __future__ import annotations

import numpy as np

from ..vecmath import turned
from .base import Operation
from .working_space import matrix_of

# From each of these temperatures on, K, the row of this number plus one holds.
_STARTS = np.array([965, 1167, 1449, 1902, 3315, 6365], np.float32)
# Red and green: a / T + b T + c.
_RED = np.array(
    [
        (1.61919106e3, -2.05010916e-3, 5.02995757),
        (2.48845471e3, -1.11330907e-3, 3.22621544),
        (3.34143193e3, -4.86551192e-4, 1.76486769),
        (4.09461742e3, -1.27446582e-4, 7.25731635e-1),
        (4.67028036e3, 2.91258199e-5, 1.26703442e-1),
        (4.59509185e3, 2.87495649e-5, 1.50345020e-1),
        (3.78717450e3, 9.35907826e-6, 3.99075871e-1),
    ],
    np.float32,
)
_GREEN = np.array(
    [
        (-4.88999748e2, 6.04330754e-4, -7.55807526e-2),
        (-7.55994277e2, 3.16730098e-4, 4.78306139e-1),
        (-1.02363977e3, 1.20223470e-4, 9.36662319e-1),
        (-1.26571316e3, 4.87340896e-6, 1.27054498),
        (-1.42529332e3, -4.01150431e-5, 1.43972784),
        (-1.17554822e3, -2.16378048e-5, 1.30408023),
        (-5.00799571e2, -4.59832026e-6, 1.09098763),
    ],
    np.float32,
)
# Blue: ((a T + b) T + c) T + d.
_BLUE = np.array(
    [
        (5.96945309e-11, -4.85742887e-8, -9.70622247e-5, -4.07936148e-3),
        (2.40430366e-11, 5.55021075e-8, -1.98503712e-4, 2.89312858e-2),
        (-1.40949732e-11, 1.89878968e-7, -3.56632824e-4, 9.10767778e-2),
        (-3.61460868e-11, 2.84822009e-7, -4.93211319e-4, 1.56723440e-1),
        (-1.97075738e-11, 1.75359352e-7, -2.50542825e-4, -2.22783266e-2),
        (-1.61997957e-13, -1.64216008e-8, 3.86216271e-4, -7.38077418e-1),
        (6.72650283e-13, -2.73078809e-8, 4.24098264e-4, -7.52335691e-1),
    ],
    np.float32,
)
_COLDEST = (800.0, (5.413294490189271, -0.20319390035873933, -0.0822535242887164))
_HOTTEST = (12000.0, (0.8262954810464208, 0.9945080501520986, 1.566307710274283))


def color_of(temperature, out, matrix=None):
    """Colours of temperatures (N,), K, into `out` (3, N); what is outside the gamut is clipped to 0.

    They are Linear Rec.709, or, by `matrix` (3, 3) from there, of another space.
    """
    t = np.clip(np.nan_to_num(temperature), _COLDEST[0], _HOTTEST[0])
    row = np.searchsorted(_STARTS, t, side="right")
    for channel, table in zip(out, (_RED, _GREEN), strict=False):
        a, b, c = table[row].T
        np.add(a / t + b * t, c, out=channel)
    a, b, c, d = _BLUE[row].T
    np.add(((a * t + b) * t + c) * t, d, out=out[2])
    for channel, coldest, hottest in zip(out, _COLDEST[1], _HOTTEST[1], strict=True):
        np.copyto(channel, coldest, where=temperature < _COLDEST[0])
        np.copyto(channel, hottest, where=temperature >= _HOTTEST[0])
    if matrix is not None:
        np.copyto(out, turned(matrix, out))
    return np.maximum(out, 0, out=out)


def _blackbody(context, inputs, properties):
    t = inputs["temperature"]
    return {"color": color_of(t, context.arena.empty((3, t.shape[-1])), matrix_of(properties))}


OPERATIONS = {"blackbody": Operation(_blackbody, {"temperature": 6500.0})}
