# SPDX-License-Identifier: GPL-3.0-or-later
"""Types and values of sockets, and Blender's conversions between them."""

from __future__ import annotations

from . import versions

_KINDS = {
    "VALUE": "float",
    "INT": "int",
    "BOOLEAN": versions.boolean_kind(),
    "RGBA": "color",
    "VECTOR": "vector",
    "SHADER": "shader",
}
LUMINANCE = (0.2126, 0.7152, 0.0722)


def kind(socket):
    """The socket's type in the core's words, e.g. color; what the core lacks is Blender's own in lower case."""
    return _KINDS.get(socket.type, socket.type.lower())


def name(socket):
    """The socket's identifier in snake case."""
    return socket.identifier.lower().replace(" ", "_")


def constant(socket):
    """The value of the socket: a number or three; None where it has none.

    A vector that is not shown stands for coordinates or a normal; other values count even so, as in Cycles.
    """
    own = kind(socket)
    if own not in ("float", "int", "bool", "color", "vector") or (own == "vector" and socket.hide_value):
        return None
    value = socket.default_value
    if own in ("color", "vector"):
        return tuple(float(v) for v in value[:3])
    return float(value)


def convert(value, source, target, luminance=LUMINANCE):
    """A constant of kind `source` as one of kind `target`: `luminance` of a colour, mean of a vector."""
    if source in ("color", "vector"):
        if target in ("color", "vector"):
            return value
        if source == "vector" and target == "bool":
            return float(any(value))
        weights = luminance if source == "color" else (1 / 3, 1 / 3, 1 / 3)
        value = sum(v * w for v, w in zip(value, weights, strict=True))
    elif target in ("color", "vector"):
        return (value, value, value)
    if target == "int":
        return float(int(value))
    return float(value > 0) if target == "bool" else value
