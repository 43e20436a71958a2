# SPDX-License-Identifier: GPL-3.0-or-later
"""Cycles as a reference: the same file rendered by both engines with the same light transport, and how far they agree.

As a program: ``python tests/reference.py sample_blends/cornell.blend --samples 1024`` prints the agreement of a file.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from pathlib import Path

import bpy
import numpy as np
import OpenImageIO as oiio

import zraka
from zraka.addon import headless

ENGINES = ("ZRAKA", "CYCLES")


def open_blend(path, percentage=100):
    """Open a file, drawn `percentage` of its size, and return its scene."""
    zraka.register()
    with headless.quiet():
        bpy.ops.wm.open_mainfile(filepath=str(path), load_ui=False)
    scene = bpy.context.scene
    scene.render.resolution_percentage = percentage
    return scene


def match(scene):
    """Set Cycles to what `scene.zraka` says, and switch off whatever is not plain unbiased path tracing."""
    cycles, group, render = scene.cycles, scene.zraka, scene.render
    group.method, group.clamp_direct, group.clamp_indirect, group.noise_target = "PATHTRACE", 0.0, 0.0, 0.0
    cycles.device, cycles.samples, cycles.seed = "CPU", group.samples, group.seed
    cycles.use_adaptive_sampling = cycles.use_denoising = cycles.use_animated_seed = False
    for kind in ("max", "diffuse", "glossy", "transmission"):
        setattr(cycles, f"{kind}_bounces", group.depth - 1)
    cycles.transparent_max_bounces = group.transparent_depth
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0.0
    cycles.blur_glossy, cycles.light_sampling_threshold = 0.0, 0.0
    cycles.caustics_reflective = cycles.caustics_refractive = True
    cycles.pixel_filter_type, cycles.filter_width, cycles.film_exposure = "BOX", 1.0, 1.0
    cycles.time_limit = 0.0
    render.use_compositing = render.use_sequencer = render.use_motion_blur = False


def picture(scene, engine, samples, seed):
    """Render with `engine`.

    Returns
    -------
    (H, W, 3) float32
        Linear, scene-referred; row 0 is the top row.
    """
    scene.zraka.samples, scene.zraka.seed = samples, seed
    match(scene)
    scene.render.engine = engine
    kind = scene.render.image_settings
    if hasattr(kind, "media_type"):  # Blender 5
        kind.media_type = "IMAGE"
    kind.file_format, kind.color_mode, kind.color_depth = "OPEN_EXR", "RGB", "32"
    with tempfile.TemporaryDirectory() as folder:
        scene.render.filepath = str(Path(folder) / "picture.exr")
        with headless.quiet():
            bpy.ops.render.render(write_still=True)
        return oiio.ImageBuf(scene.render.filepath).get_pixels(oiio.FLOAT)[..., :3]


def pictures(scene, engine, samples, runs=2):
    """`runs` independent renders that together took `samples` samples, (runs, H, W, 3)."""
    return np.stack([picture(scene, engine, samples // runs, seed) for seed in range(1, runs + 1)])


def block_means(runs, size=8):
    """Mean of every `size` × `size` block of pixels, and its standard error.

    Parameters
    ----------
    runs : (R, H, W, C)
        Independent renders, at least two. What does not fill a block is left out.

    Returns
    -------
    mean, error : (H // size, W // size, C) float64
        The error is that of the mean over all runs. Two runs say little about one block, so the variance is averaged
        over the block and its neighbours.
    """
    count, height, width, channels = runs.shape
    rows, columns = height // size, width // size
    whole = runs[:, : rows * size, : columns * size].astype(np.float64)
    blocks = whole.reshape(count, rows, size, columns, size, channels).mean(axis=(2, 4))
    variance = blocks.var(axis=0, ddof=1) / count
    padded = np.pad(variance, ((1, 1), (1, 1), (0, 0)), mode="edge")
    around = [padded[i : i + rows, j : j + columns] for i in range(3) for j in range(3)]
    return blocks.mean(axis=0), np.sqrt(np.mean(around, axis=0))


def misfit(ours, theirs, tolerance=0.02, sigmas=3.0):
    """By how much blocks differ beyond what is allowed, (rows, columns): at most 1 agrees.

    Allowed are `tolerance` of the reference and `sigmas` standard errors of the difference. A block is as good as its
    worst channel; a channel below a thousandth of the picture's mean counts as that bright.
    """
    (a, error_a), (b, error_b) = block_means(ours), block_means(theirs)
    scale = np.maximum(np.abs(b), 1e-3 * b.mean())
    return (np.abs(a - b) / (tolerance * scale + sigmas * np.hypot(error_a, error_b))).max(axis=-1)


def agreement(ours, theirs, tolerance=0.02, sigmas=3.0):
    """Share of blocks that agree, see `misfit`; independent renders of both, (R, H, W, C)."""
    return float((misfit(ours, theirs, tolerance, sigmas) <= 1.0).mean())


def power(ours, theirs, shift=1.05, tolerance=0.02, sigmas=3.0):
    """Share of blocks that would be told apart if ours were `shift` times as bright: what an agreement is worth."""
    return 1.0 - agreement(np.asarray(ours) * shift, theirs, tolerance, sigmas)


def main():
    """Compare the engines on files and print one line for each."""
    parser = argparse.ArgumentParser(description=main.__doc__)
    parser.add_argument("files", nargs="+", type=Path)
    parser.add_argument("--samples", type=int, default=1024)
    parser.add_argument("--percentage", type=int, default=100)
    parser.add_argument("--runs", type=int, default=4)
    parser.add_argument("--keep", type=Path, help="folder for the pictures and the misfit, as .npz")
    args = parser.parse_args()
    for path in args.files:
        scene, seconds, both = open_blend(path, args.percentage), {}, {}
        for engine in ENGINES:
            started = time.perf_counter()
            both[engine] = pictures(scene, engine, args.samples, args.runs)
            seconds[engine] = time.perf_counter() - started
        ours, theirs = both["ZRAKA"], both["CYCLES"]
        print(
            f"{path.stem}: {agreement(ours, theirs):.2%} of the blocks agree, "
            f"{power(ours, theirs):.1%} would tell a shift of 5%; mean {ours.mean() / theirs.mean():.4f} of Cycles'; "
            f"{seconds['ZRAKA']:.0f} s against {seconds['CYCLES']:.0f} s"
        )
        if args.keep:
            np.savez(args.keep / f"{path.stem}.npz", misfit=misfit(ours, theirs), **both)


if __name__ == "__main__":
    main()
