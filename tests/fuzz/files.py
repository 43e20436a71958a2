# SPDX-License-Identifier: GPL-3.0-or-later
"""Random bytes and broken files, where the command line expects a .blend or a picture."""

from __future__ import annotations

import contextlib
import io
import tempfile
import warnings
from pathlib import Path

import numpy as np
import OpenImageIO as oiio

from zraka.addon import cli
from zraka.core.diagnostics import Diagnostics
from zraka.core.nodes.image_loader import load
from zraka.core.scene import Image

from .check import Broken
from .numbers import Numbers

BLENDS = sorted((Path(__file__).resolve().parents[2] / "sample_blends").glob("*.blend"))
PICTURES = (".png", ".exr", ".jpg", ".hdr", ".tif", ".bmp", ".tga")


def check_file(seed):
    """A picture, or for each sixth seed a .blend, that is broken in some way."""
    numbers = Numbers(seed)
    with tempfile.TemporaryDirectory() as folder:
        if seed % 6 == 0:
            check_blend(numbers, Path(folder))
        else:
            check_picture(numbers, Path(folder))


def check_picture(numbers, folder):
    """The loader of textures gives finite texels, or magenta and says so."""
    path = folder / f"picture{numbers.choice(PICTURES)}"
    path.write_bytes(spoilt(numbers, _picture(numbers, path)))
    space = numbers.choice(("sRGB", "Non-Color", "Linear Rec.709", "Filmic Log"))
    image = Image("broken", filepath=str(path), colorspace=space, alpha_mode=numbers.choice(("AUTO", "PREMUL", "NONE")))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        texels = load(image, Diagnostics(), "material 'm'")
    if texels.nbytes > 1 << 28:
        raise Broken(f"a file of {path.stat().st_size} bytes takes {texels.nbytes} bytes")


def check_blend(numbers, folder):
    """The command line says one sentence, or renders; Blender itself may crash on no such file."""
    path = folder / "broken.blend"
    kind = numbers.rng.random()
    if kind < 0.4:
        data = numbers.rng.bytes(numbers.count(5000))
        data = (b"BLENDER-v405" + data) if numbers.chance(0.5) else data
    else:  # changed bytes within a file make Blender crash, which is not ours to mend: cut ones alone
        whole = numbers.choice(BLENDS).read_bytes()
        data = whole[: int(numbers.rng.integers(len(whole)))]
    path.write_bytes(data)
    words, picture = io.StringIO(), folder / "out.png"
    command = ["render", str(path), "--size", "4x3", "--samples", "1", "--threads", "1", "--output", str(picture)]
    with contextlib.redirect_stderr(words), contextlib.redirect_stdout(io.StringIO()):
        try:
            code = cli.main(command)
        except SystemExit as error:
            code = error.code
    said = words.getvalue()
    if "Traceback" in said or (code not in (0, None) and "zraka: " not in said):
        raise Broken(f"exit code {code}: {said[-300:]}")


def spoilt(numbers, data):
    """`data` cut off, with other bytes in it, or nothing but random bytes."""
    kind = numbers.rng.random()
    if kind < 0.15:
        return numbers.rng.bytes(numbers.count(3000))
    data = bytearray(data)
    if kind < 0.6:
        data = data[: int(numbers.rng.integers(len(data) + 1))]
    if kind > 0.45 and data:
        for _ in range(1 + numbers.count(20)):
            first = 0 if numbers.chance(0.3) else min(40, len(data) - 1)
            data[int(numbers.rng.integers(first, len(data)))] = int(numbers.rng.integers(256))
    return bytes(data)


def _picture(numbers, path):
    """Bytes of a whole picture of the kind that `path` is named for."""
    height, width = 1 + numbers.count(20), 1 + numbers.count(20)
    channels = 3 if path.suffix in (".jpg", ".hdr", ".bmp") else numbers.choice((1, 3, 4))
    pixels = numbers.rng.random((height, width, channels)).astype(np.float32)
    kind = {".exr": "half", ".hdr": "float"}.get(path.suffix, "uint8")
    output = oiio.ImageOutput.create(str(path))
    output.open(str(path), oiio.ImageSpec(width, height, channels, kind))
    output.write_image(pixels)
    output.close()
    return path.read_bytes()
