# SPDX-License-Identifier: GPL-3.0-or-later
"""Shader-node operations over lanes, by name. Closures stand in `closures`."""

from . import checker, convert, coordinates, image

OPERATIONS = {
    name: operation
    for family in (convert, coordinates, checker, image)
    for name, operation in family.OPERATIONS.items()
}
