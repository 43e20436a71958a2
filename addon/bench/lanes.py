# SPDX-License-Identifier: GPL-3.0-or-later
"""What each material program costs at a hit: ``python -m zraka.addon.bench.lanes`` prints the table of
docs/performance.md.

One thread's CPU time in nanoseconds a lane, the best of several runs: setting the lobes up (nodes included), choosing
between them, evaluating them for a given light, sampling them.
"""

from __future__ import annotations

import argparse
import sys
import time

import numpy as np

from ...core import scene as description
from ...core.accel import Hits
from ...core.arena import Arena
from ...core.compile.scene import compile_scene
from ...core.diagnostics import Diagnostics
from ...core.methods.wavefront import surface_context
from ...core.report.table import table
from ...core.scene import Link, Node
from ...core.settings import Settings

LANES, RUNS = 1 << 16, 7
_COLOR = (0.8, 0.5, 0.2)
_COLUMNS = ("set-up", "choice", "evaluation", "sampling", "all")


def materials():
    """Materials by what the table calls them."""
    rng = np.random.default_rng(1)
    image = description.Image("Noise", rng.integers(0, 255, (512, 512, 4), np.uint8))
    picture, noise = Node("image", {}, {"image": image}), Node("noise")
    return {
        "Diffuse": _plain("diffuse", color=_COLOR),
        "Diffuse, rough": _plain("diffuse", color=_COLOR, roughness=0.5),
        "Diffuse, image": _textured("diffuse", picture, color="color"),
        "Glossy, GGX": _plain("glossy", {"distribution": "GGX"}, color=_COLOR, roughness=0.3),
        "Glossy, multiscatter": _plain("glossy", {"distribution": "MULTI_GGX"}, color=_COLOR, roughness=0.3),
        "Glossy, anisotropic": _plain("glossy", color=_COLOR, roughness=0.3, anisotropy=0.5),
        "Metallic": _plain("metallic", roughness=0.3),
        "Glass": _plain("glass", color=_COLOR, roughness=0.0, ior=1.5),
        "Glass, rough": _plain("glass", {"distribution": "MULTI_GGX"}, color=_COLOR, roughness=0.3, ior=1.5),
        "Sheen": _plain("sheen", color=_COLOR),
        "Toon": _plain("toon", color=_COLOR),
        "Hair": _plain("hair", color=_COLOR),
        "Principled Hair": _plain("principled_hair", {"parametrization": "COLOR"}, color=_COLOR),
        "Principled": _plain("principled", base_color=_COLOR),
        "Principled, image as colour": _textured("principled", picture, base_color="color"),
        "Principled, image as roughness": _textured("principled", picture, roughness="alpha"),
        "Principled, metallic": _plain("principled", base_color=_COLOR, metallic=1.0),
        "Principled, transmission": _plain("principled", base_color=_COLOR, transmission_weight=1.0, roughness=0.2),
        "Principled, coat and sheen": _plain("principled", base_color=_COLOR, coat_weight=1.0, sheen_weight=0.5),
        "Principled, thin film": _plain("principled", base_color=_COLOR, thin_film_thickness=400.0),
        "Principled, normal map": _with_normal_map(picture),
        "Diffuse, noise": _textured("diffuse", noise, color="color"),
        "Diffuse, Voronoi": _textured("diffuse", Node("voronoi"), color="color"),
        "Diffuse, brick": _textured("diffuse", Node("brick"), color="color"),
        "Diffuse, checker": _textured("diffuse", Node("checker"), color="color"),
        "Diffuse, ambient occlusion": _textured("diffuse", Node("ambient_occlusion"), color="color"),
    }


def _plain(op, properties=None, **inputs):
    return description.Material(op, (Node(op, inputs, properties or {}),), 0)


def _textured(op, node, **outputs):
    """A shader whose inputs are outputs of `node`."""
    return description.Material(op, (node, Node(op, {name: Link(0, o) for name, o in outputs.items()})), 1)


def _with_normal_map(picture):
    turned = Node("normal_map", {"color": Link(0, "color")})
    shader = Node("principled", {"base_color": _COLOR, "normal": Link(1, "normal")})
    return description.Material("normal map", (picture, turned, shader), 2)


def costs(material, lanes=LANES, runs=RUNS):
    """Nanoseconds a lane of one material's steps, a dict by `_COLUMNS`."""
    compiled = compile_scene(_scene(material), Settings(width=8, height=8), Diagnostics())
    surface, wi, u = _hits(compiled, lanes)
    program, arena = compiled.materials.programs[0], Arena()
    rows = np.take(compiled.geometry.material, surface.prim)
    best = dict.fromkeys(_COLUMNS, np.inf)
    for _ in range(runs):
        with arena.frame():
            clock = [time.thread_time_ns()]
            constants = compiled.materials.constants(0, "scatter", rows, arena)
            entries = program.lobes_over(surface_context(surface, compiled.geometry, arena), constants)
            clock.append(time.thread_time_ns())
            shares = program.mixture.shares(entries, surface, arena)
            clock.append(time.thread_time_ns())
            if program.mixture.is_smooth:
                program.mixture.eval_pdf(entries, surface, wi, arena, shares)
            clock.append(time.thread_time_ns())
            program.mixture.sample(entries, surface, u[2], u[0], u[1], arena, shares)
            clock.append(time.thread_time_ns())
        spent = [*np.diff(clock), clock[-1] - clock[0]]
        best = {name: min(best[name], ns / lanes) for name, ns in zip(_COLUMNS, spent, strict=True)}
    return best


def _scene(material):
    corners = np.float32([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])
    uv = np.float32([[0, 0], [1, 0], [1, 1], [0, 0], [1, 1], [0, 1]])
    mesh = description.Mesh(corners, np.int32([[0, 1, 2], [0, 2, 3]]), uvs={"UVMap": uv})
    return description.Scene(description.Camera(), (description.Instance(mesh, materials=(material,)),))


def _hits(compiled, lanes):
    """The `Surface` of random points seen from random directions, directions to lights, random numbers."""
    rng = np.random.default_rng(2)
    u, v = rng.random((2, lanes), np.float32)
    u, v = np.where(u + v > 1, 1 - u, u), np.where(u + v > 1, 1 - v, v)
    wo, wi = (_upper(rng, lanes) for _ in range(2))
    prim = rng.integers(0, 2, lanes).astype(np.int32)
    t = np.ones(lanes, np.float32)
    surface = compiled.interact(Hits(t, prim, u, v), wo, -wo, Arena(1 << 26))
    return surface, wi, rng.random((3, lanes), np.float32)


def _upper(rng, lanes):
    w = rng.normal(size=(3, lanes)).astype(np.float32)
    w[2] = np.abs(w[2])
    return w / np.sqrt((w * w).sum(axis=0))


def main():
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[2])
    parser.add_argument("names", nargs="*", help="parts of the names of materials; all by default")
    wanted = parser.parse_args().names
    rows = []
    for name, material in materials().items():
        if not wanted or any(part.lower() in name.lower() for part in wanted):
            rows.append([name, *(f"{ns:.0f}" for ns in costs(material).values())])
    sys.stdout.write(table(["material, ns a lane", *_COLUMNS], rows) + "\n")


if __name__ == "__main__":
    main()
