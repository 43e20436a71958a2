# SPDX-License-Identifier: GPL-3.0-or-later
"""Plain Phong shading, the local baseline: every light reaches every surface that faces it."""

from __future__ import annotations

from .local import LocalModel


class Phong(LocalModel):
    """The local model without shadows."""

    shadows = False
