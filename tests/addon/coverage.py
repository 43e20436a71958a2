# SPDX-License-Identifier: GPL-3.0-or-later
"""The measured rows of docs/coverage.md: every case of every kind beside Cycles.

``python -m zraka.tests.addon.coverage`` measures all, a quarter of an hour; names of sections (``lights``, ``lamps``,
``camera``, ``visibility``, ``bounces``, ``worlds``, ``motion``, ``geometry``, ``lenses``, ``large``, ``classic``)
choose some. Rows stand between ``<!-- section -->`` and ``<!-- /section -->``; what is written around them stays.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import bpy

import zraka

from . import (
    bounce_cases,
    camera_cases,
    catcher_cases,
    classic_cases,
    geometry_cases,
    lamp_cases,
    large_cases,
    lens_cases,
    light_cases,
    motion_cases,
    visibility_cases,
    world_cases,
)

PAGE = Path(__file__).resolve().parents[2] / "docs" / "coverage.md"


def pixels(share, most, unit=""):
    """Words for how many pixels agree, and how far they differ."""
    who = f"{100 * share:.2f}% of pixels" if share < 1 else "all pixels"
    return f"{who} within {max(most, 1e-6):.0e}{unit}"


def percent(value):
    """Words for a relative difference, rounded up where nothing would be left."""
    return f"{100 * value:.2g}%" if value >= 1e-4 else "below 0.01%"


def of_geometry(scene, case):
    """Difference and note of a case of geometry."""
    share, most, _ = geometry_cases.measure(scene, case)
    return pixels(share, most), case.note


def of_camera(scene, case):
    """Of a camera."""
    share, most, _ = camera_cases.measure(scene, case)
    return "position: " + pixels(share, most, " m"), ""


def of_light(scene, case):
    """Of a light's irradiance."""
    form, theirs, both = map(percent, light_cases.measure(scene, case))
    return both, f"{form} from the closed form, Cycles {theirs}"


def of_lamp(scene, case):
    """Of a lamp with nodes."""
    return percent(lamp_cases.measure(scene, case)), case.note


def of_visibility(scene, case):
    """Of who sees what."""
    return percent(visibility_cases.measure(case)[0]), case.note


def of_bounces(scene, case):
    """Of limits of bounces."""
    return percent(bounce_cases.measure(case)[0]), case.note


def of_world(scene, case):
    """Of a world."""
    return percent(world_cases.measure(scene, case)[0]), case.note


def of_lens(scene, case):
    """Of depth of field."""
    same, mean = lens_cases.measure(scene, case)
    return (
        f"{100 * same:.0f}% of blocks within 2% of Cycles; difference of the means {percent(abs(mean - 1))}",
        case.note,
    )


def of_motion(scene, case):
    """Of what moves."""
    same, _, mean = motion_cases.measure(scene, case)
    against = "the mean of Cycles' stills" if case.stills else "Cycles"
    words = f"{100 * same:.0f}% of blocks within 2% of {against}; difference of the means {percent(abs(mean - 1))}"
    return words, case.note


def of_large(scene, case):
    """Of what is large."""
    return large_cases.measure(case), case.note


def of_classic(scene, case):
    """Of the classic methods on the other sections' scenes."""
    found = classic_cases.measure(scene, case)
    note = f"[{case.meaning}](classic.md#{case.meaning})"
    if max(found.black.values()) >= 0.005:
        note += "; black " + ", ".join(f"{100 * share:.0f}%" for share in found.black.values())
    said = dict.fromkeys(message for messages in found.messages.values() for message in messages)
    note += "".join(f"; “{sentence}”" for sentence in said)
    return ", ".join(f"{value:.2f}" for value in found.means.values()), note


SECTIONS = {
    "camera": (camera_cases.CASES, of_camera),
    "lenses": (lens_cases.CASES, of_lens),
    "lights": (light_cases.CASES, of_light),
    "bounces": (bounce_cases.CASES, of_bounces),
    "lamps": (lamp_cases.CASES, of_lamp),
    "worlds": (world_cases.CASES, of_world),
    "visibility": (visibility_cases.CASES + catcher_cases.CASES, of_visibility),
    "motion": (motion_cases.CASES, of_motion),
    "geometry": (geometry_cases.CASES, of_geometry),
    "large": (large_cases.CASES, of_large),
    "classic": (classic_cases.CASES, of_classic),
}


def fresh():
    """An empty file's scene."""
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    return bpy.context.scene


def rows(name):
    """The rows of a section; one that this Blender cannot make is left out."""
    cases, measured = SECTIONS[name]
    for case in cases:
        if bpy.app.version >= getattr(case, "since", (4, 2)):
            difference, note = measured(fresh(), case)
            yield f"| {case.item} | yes | {difference} | {note} |"


def write(name, lines):
    """Put the rows of a section into the page."""
    begin, end = f"<!-- {name} -->\n", f"<!-- /{name} -->"
    before, rest = PAGE.read_text(encoding="utf-8").split(begin)
    PAGE.write_text(before + begin + "\n".join(lines) + "\n" + end + rest.split(end)[1], encoding="utf-8")


def main():
    """Measure and write."""
    parser = argparse.ArgumentParser(description=main.__doc__)
    parser.add_argument("sections", nargs="*", metavar="SECTION")
    zraka.register()
    for name in parser.parse_args().sections or SECTIONS:
        lines = []
        for line in rows(name):
            lines.append(line)
            print(line, file=sys.stderr, flush=True)
        write(name, lines)


if __name__ == "__main__":
    main()
