# SPDX-License-Identifier: GPL-3.0-or-later
"""What arguments of the command line may be, each a type of argparse."""

from __future__ import annotations

import argparse
import math
import re

from ...core.settings import METHODS


def whole(least, most=2**31 - 1):
    """Make a parser of whole numbers from `least` to `most`."""

    def whole_number(text):
        try:
            value = int(text)
        except ValueError:
            raise argparse.ArgumentTypeError(f"{text!r} is not a whole number") from None
        if not least <= value <= most:
            raise argparse.ArgumentTypeError(f"{value} is not between {least} and {most}")
        return value

    return whole_number


def seconds(text):
    """Parse a time, finite and not negative."""
    try:
        value = float(text)
    except ValueError:
        value = -1.0
    if not (value >= 0 and math.isfinite(value)):
        raise argparse.ArgumentTypeError(f"{text!r} is not a number of seconds")
    return value


def size(text):
    """Parse ``WIDTHxHEIGHT`` in pixels."""
    found = re.fullmatch(r"(\d+)[xX×](\d+)", text)
    sides = tuple(int(side) for side in found.groups()) if found else (0, 0)
    if not all(1 <= side <= 65536 for side in sides):
        raise argparse.ArgumentTypeError(f"bad size {text!r}; write WIDTHxHEIGHT in pixels, e.g. 640x480")
    return sides


def methods(text):
    """Parse a list of methods, separated by commas."""
    names = tuple(dict.fromkeys(name.strip() for name in text.split(",")))
    for name in names:
        if name not in METHODS:
            raise argparse.ArgumentTypeError(f"unknown method {name!r}; choose from {', '.join(METHODS)}")
    return names
