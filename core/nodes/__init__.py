# SPDX-License-Identifier: GPL-3.0-or-later
"""Shader-node operations over lanes, by name. Closures stand in `closures`."""

from . import checker, convert, coordinates, environment, image, mapping

OPERATIONS = {
    name: operation
    for family in (convert, coordinates, mapping, checker, image, environment)
    for name, operation in family.OPERATIONS.items()
}
