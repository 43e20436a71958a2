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
CELL, LABEL = 240, 20


def rendered(scene, method):
    """Path of the picture of `scene` by `method`, rendered now."""
    path = ROOT / "renders" / f"{scene}-{method}.png"
    command = [sys.executable, "-m", "zraka", "render", ROOT / "sample_blends" / f"{scene}.blend"]
    options = ["--method", method, "--samples", str(METHODS[method]), "--output", path]
    subprocess.run([*map(str, command), *map(str, options)], check=True, cwd=ROOT)
    return path


def main():
    """Write docs/figures/methods.png."""
    (ROOT / "renders").mkdir(exist_ok=True)
    sheet = oiio.ImageBuf(oiio.ImageSpec(CELL * len(METHODS), (CELL + LABEL) * len(SCENES), 3, oiio.UINT8))
    algo.fill(sheet, (1.0, 1.0, 1.0))
    for row, scene in enumerate(SCENES):
        for column, method in enumerate(METHODS):
            x, y = column * CELL, row * (CELL + LABEL)
            picture = algo.fit(
                oiio.ImageBuf(str(rendered(scene, method))), roi=oiio.ROI(0, CELL - 4, 0, CELL - 4, 0, 1, 0, 3)
            )
            size = picture.spec()
            algo.paste(sheet, x + (CELL - size.width) // 2, y + LABEL + (CELL - size.height) // 2, 0, 0, picture)
            algo.render_text(sheet, x + 4, y + LABEL - 5, f"{scene}, {method}", 13, textcolor=(0.2, 0.2, 0.2))
    target = ROOT / "docs" / "figures" / "methods.jpg"
    target.parent.mkdir(exist_ok=True)
    sheet.write(str(target))


if __name__ == "__main__":
    main()
