# SPDX-License-Identifier: GPL-3.0-or-later
"""Whitted's ray tracing: ray casting plus mirror and refracted rays to a depth; depth 1 is ray casting, bit for bit."""

from __future__ import annotations

from .local import LocalModel


class RayTrace(LocalModel):
    """Mirror and refracted rays, breadth first."""

    @property
    def levels(self):
        """The settings' depth."""
        return self.settings.depth
