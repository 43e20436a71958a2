# SPDX-License-Identifier: GPL-3.0-or-later
"""What the user must be told: each message once, with how often and where it occurred."""

from __future__ import annotations

import threading


class SceneError(ValueError):
    """The scene or a setting cannot be rendered; the message is one sentence that names the thing and the remedy."""


class Diagnostics:
    """Warnings, each said once.

    Examples
    --------
    >>> d = Diagnostics()
    >>> d.warn("node 'Noise Texture' is not supported; its default is used", "material 'Wood'")
    >>> d.messages()
    ["node 'Noise Texture' is not supported; its default is used (material 'Wood')"]
    """

    def __init__(self):
        self._places: dict[str, dict[str, int]] = {}
        self._lock = threading.Lock()

    def warn(self, message, place="", count=1):
        """Note `message`; the same one at several places becomes one line."""
        with self._lock:
            places = self._places.setdefault(message, {})
            places[place] = places.get(place, 0) + count

    def messages(self):
        """One line a message, in the order of first occurrence."""
        return [message + _where(places) for message, places in self._places.items()]


def _where(places):
    named = [p for p in places if p]
    total = sum(places.values())
    text = ", ".join(named[:3]) + (f" and {len(named) - 3} more" if len(named) > 3 else "")
    if total > max(len(named), 1):
        text += f"{', ' if text else ''}{total} times"
    return f" ({text})" if text else ""
