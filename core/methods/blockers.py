# SPDX-License-Identifier: GPL-3.0-or-later
"""What casts shadows, where that depends on the light."""

from __future__ import annotations

from contextlib import contextmanager


def casters(scene, worker):
    """What the shadow rays that `worker` casts now are asked against."""
    return scene.visibility.shadow if worker.casters is None else worker.casters


@contextmanager
def shaded_by(accel, worker):
    """Let `accel` cast the shadows that `worker` asks for."""
    worker.casters = accel
    try:
        yield
    finally:
        worker.casters = None
