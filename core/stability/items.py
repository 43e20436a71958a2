# SPDX-License-Identifier: GPL-3.0-or-later
"""What the grid must cover, item by item, and which axes and scenes do."""

from __future__ import annotations

# Item: names of axes and stiff scenes, or their beginnings.
ITEMS = {
    "scene scale": ("scene scale",),
    "distance of the scene, or of a part, from the origin": ("offset", "distance of another object"),
    "light power": ("light power",),
    "light size": (
        "soft point light, radius",
        "spherical point light, radius",
        "area light, side",
        "emitting",
        "sun, angle",
    ),
    "distance to the light": ("distance to the light",),
    "roughness, across the switch to the ideal lobe": ("roughness",),
    "index of refraction, total reflection": ("index of refraction", "angle inside glass"),
    "albedo": ("albedo",),
    "depth": ("depth",),
    "grazing angles": ("angle of light", "angle of view"),
    "field of view": ("field of view", "half side of a parallel view", "aperture"),
    "resolution": ("size of the picture",),
    "triangles: none, one, slivers, coincident, without area; bad vertices": ("aspect of slivers", "form of the mesh"),
    "number and place of lights": ("number of lights", "place of the light"),
    "textures": ("texture",),
    "emission": ("emission",),
    "animated transforms": ("form of the mesh", "motion", "distance moved", "number of moments"),
    "nested and overlapping glass": ("nested glass",),
    "65,536 lanes of a pixel, 10⁶ samples": ("samples of one pixel",),
    "noise targets": ("noise target",),
    "hair": ("radius of a strand", "length of a strand", "form of strands"),
    "who sees what, light linking": (
        "who sees what",
        "height of a roof",
        "number of lamps with blockers",
    ),
    "stiff scenes": ("stiff",),
}


def rows(report):
    """(item, where, verdict) of each item, as far as `report` tells."""
    verdicts = {}
    for result in report.results:
        verdicts.setdefault(result.axis.name, []).append(result.verdict)
    for finding in report.findings:
        verdicts.setdefault(f"stiff: {finding.stiff.name}", []).append(finding.verdict)
    for item, beginnings in ITEMS.items():
        names = [name for name in verdicts if name.startswith(beginnings)]
        found = [verdict for name in names for verdict in verdicts[name]]
        yield item, "; ".join(names) or "–", _summary(found)


def _summary(found):
    """How many cases passed, and how many did not."""
    if not found:
        return "not run"
    words = [f"{found.count('pass')} pass"]
    words += [f"{found.count(v)} {v}" for v in ("out of range", "fail") if v in found]
    return ", ".join(words)
