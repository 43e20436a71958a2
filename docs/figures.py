# SPDX-License-Identifier: GPL-3.0-or-later
"""The contact sheet of the README: every sample scene by every method.

    python docs/figures.py

Renders into renders/ through the command line, then pastes the pictures together.
"""

import subprocess
import sys
from pathlib import Path

import OpenImageIO as oiio
from OpenImageIO import ImageBufAlgo as algo

ROOT = Path(__file__).resolve().parent.parent
SCENES = ("cornell", "whitted", "thesis", "room_open", "room_closed", "interior", "many", "spheres")
METHODS = {"phong": 4, "raycast": 4, "raytrace": 4, "pathtrace": 64}  # samples of each
WIDTH, GAP, LABEL = 240, 4, 22


def rendered(scene, method):
    """Path of the picture of `scene` by `method`, rendered now."""
    path = ROOT / "renders" / f"{scene}-{method}.png"
    command = [sys.executable, "-m", "zraka", "render", ROOT / "sample_blends" / f"{scene}.blend"]
    options = ["--method", method, "--samples", str(METHODS[method]), "--output", path]
    subprocess.run([*map(str, command), *map(str, options)], check=True, cwd=ROOT)
    return path


def shrunk(path):
    """The picture at `path`, `WIDTH` pixels wide."""
    picture = oiio.ImageBuf(str(path))
    height = round(WIDTH * picture.spec().height / picture.spec().width)
    return algo.resize(picture, roi=oiio.ROI(0, WIDTH, 0, height, 0, 1, 0, 3))


def main():
    """Write docs/figures/methods.jpg."""
    (ROOT / "renders").mkdir(exist_ok=True)
    rows = [[shrunk(rendered(scene, method)) for method in METHODS] for scene in SCENES]
    heights = [row[0].spec().height + LABEL for row in rows]
    sheet = oiio.ImageBuf(oiio.ImageSpec((WIDTH + GAP) * len(METHODS), sum(heights), 3, oiio.UINT8))
    algo.fill(sheet, (1.0, 1.0, 1.0))
    y = 0
    for scene, row, height in zip(SCENES, rows, heights, strict=True):
        for column, (method, picture) in enumerate(zip(METHODS, row, strict=True)):
            x = column * (WIDTH + GAP)
            algo.render_text(sheet, x + 2, y + LABEL - 5, f"{scene}, {method}", 13, textcolor=(0.2, 0.2, 0.2))
            algo.paste(sheet, x, y + LABEL, 0, 0, picture)
        y += height
    target = ROOT / "docs" / "figures" / "methods.jpg"
    target.parent.mkdir(exist_ok=True)
    sheet.specmod().attribute("Compression", "jpeg:85")
    sheet.write(str(target))


if __name__ == "__main__":
    main()
