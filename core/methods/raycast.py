# SPDX-License-Identifier: GPL-3.0-or-later
"""Ray casting: the local model with a shadow ray to every light."""

from __future__ import annotations

from .local import LocalModel


class RayCast(LocalModel):
    """The nearest hit and hard shadows."""
