# SPDX-License-Identifier: GPL-3.0-or-later
"""Cycles as a reference: the same file rendered by both engines with the same light transport, and how far they agree.

As a program: ``python tests/reference.py sample_blends/cornell.blend --samples 1024`` prints the agreement of a file.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import numpy as np

from zraka.addon.bench.engines import open_blend, picture
from zraka.core.report.error import agreement, block_means, misfit, power

ENGINES = ("ZRAKA", "CYCLES")


def pictures(scene, engine, samples, runs=2):
    """`runs` independent renders that together took `samples` samples, (runs, H, W, 3)."""
    return np.stack([picture(scene, engine, samples // runs, seed) for seed in range(1, runs + 1)])


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


__all__ = ["agreement", "block_means", "misfit", "open_blend", "picture", "pictures", "power"]

if __name__ == "__main__":
    main()
