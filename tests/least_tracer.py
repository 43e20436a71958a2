# SPDX-License-Identifier: GPL-3.0-or-later
"""How little path tracing in numpy may do beside Embree: what share of the time that leaves it (docs/performance.md).

``python tests/least_tracer.py`` traces `cornell` by a tracer for this one scene and by Zraka, by turns, on one process
and on two. The tracer knows grey walls, one rectangular lamp and a fixed epsilon: no weights between ways to sample, no
solid angles, no error bounds, no materials, no filter, no film that tells an error, no Blender.
"""

from __future__ import annotations

import os
import time
from dataclasses import replace

import numpy as np

from zraka.addon import headless
from zraka.addon.bench.engines import match, open_blend, operate, watched
from zraka.addon.bench.scenes import find
from zraka.core.arena import zeros_on_demand
from zraka.core.geometry import NORMAL
from zraka.core.methods.phong_table import phong_table
from zraka.core.methods.wavefront import Worker, add_at, nonzero
from zraka.core.processes import _keep_memory
from zraka.core.render import render
from zraka.core.sampling.sampler import hash_int

SIDE, SAMPLES, TURNS = 512, 16, 5
SQUARE = 32  # pixels along the side of what is traced in a row
EPSILON = np.float32(1e-4)  # by which rays start off a surface
SHORTER = np.float32(0.999)  # shadow rays, which were not turned for it
ROULETTE_DEPTH = 2


def main():
    """Print both tracers' samples a second, nanoseconds a sample and Embree's share of them."""
    compiled, settings = compiled_cornell()
    room = Room(compiled, settings.depth)
    truth = render(compiled, settings).image()[..., :3].mean((0, 1))
    for processes in (1, 2):
        forked = replace(settings, threads=processes, processes=processes > 1)
        least, ours = [], []
        for _ in range(TURNS):
            least.append(traced(room, processes))
            start = time.perf_counter()
            film = render(compiled, forked)
            ours.append((time.perf_counter() - start, film.stats["embree_seconds"]))
        print(f"{processes} processes, samples a second and Embree's share: least {told(least)}; Zraka {told(ours)}")
        if np.abs(least[-1][2] / truth - 1).max() > 0.005:
            raise SystemExit(f"the pictures differ: their means are {least[-1][2]} and {truth}")


def told(runs):
    """Of the run that took least."""
    seconds, embree = min(run[:2] for run in runs)
    count = SIDE * SIDE * SAMPLES
    return f"{count / seconds / 1e6:.2f} M, {seconds / count * 1e9:.0f} ns, {embree / seconds:.1%}"


def compiled_cornell():
    """The compiled scene, and the settings of a render."""
    headless.load_blender()
    scene = open_blend(find("cornell", None))
    scene.render.resolution_x = scene.render.resolution_y = SIDE
    scene.render.resolution_percentage = 100
    match(scene)
    scene.zraka.samples = 1
    with watched() as seen:
        operate(scene, "ZRAKA")
    return seen.compiled, replace(seen.settings, samples=SAMPLES)


def traced(room, processes):
    """Seconds of a picture, of Embree in it, and the picture's mean."""
    squares = np.arange(SIDE * SIDE, dtype=np.int32).reshape(SIDE // SQUARE, SQUARE, SIDE // SQUARE, SQUARE)
    parts = np.split(squares.transpose(0, 2, 1, 3).ravel(), 2)  # a chunk each
    film = zeros_on_demand((2, 3, parts[0].size), np.float64, shared=True)
    start = time.perf_counter()
    reading, writing = os.pipe()
    children = []
    for own in range(processes):
        children.append(os.fork())
        if children[-1] == 0:
            _keep_memory()  # as Zraka's forks
            worker = Worker()
            for number in range(own, 2, processes):
                for sample in range(SAMPLES):
                    film[number] += room.radiance(parts[number], sample, worker)
            os.write(writing, np.float64(worker.clock.seconds).tobytes())
            os._exit(0)
    for child in children:
        os.waitpid(child, 0)
    seconds = time.perf_counter() - start
    embree = np.frombuffer(os.read(reading, 8 * processes)).mean()
    os.close(reading)
    os.close(writing)
    return seconds, embree, film.mean((0, 2)) / SAMPLES


class Room:
    """Diffuse triangles and a lamp of two of them, a rectangle along the axes that shines to one side."""

    def __init__(self, compiled, depth):
        self.accel, self.camera, self.sampler = compiled.accel, compiled.camera, compiled.sampler
        self.depth = depth
        geometry, lamp = compiled.geometry, np.flatnonzero(compiled.emissive_prim[:-1])
        self.normals = np.ascontiguousarray(geometry.facets[:, NORMAL].T)
        table = phong_table(compiled).at(np.arange(geometry.count), False, Worker().scratch)
        self.colors = np.broadcast_to(table.diffuse, self.normals.shape).astype(np.float32)
        self.emission = np.zeros_like(self.normals)
        self.emission[:, lamp] = np.reshape(compiled.materials.emission[geometry.material[lamp[0]]], (3, 1))
        points = geometry.corners[:, lamp].reshape(3, 3, -1)  # corner, coordinate, triangle
        low, high = points.min((0, 2)), points.max((0, 2))
        self.corner, edges = low.reshape(3, 1), np.diag(high - low)[high > low]
        self.edges, self.facing = edges[..., None].astype(np.float32), self.normals[:, lamp[0]]
        area = np.prod((high - low)[high > low])
        self.power = self.emission[:, lamp[:1]] * np.float32(area / np.pi)

    def radiance(self, pixels, sample, worker):
        """A sample of every pixel, (3, P)."""
        scratch, states = worker.scratch, worker.states
        states[0].reset()
        out = np.zeros((3, pixels.size), np.float32)
        keys = self.sampler.keys(pixels ^ np.int32(sample << 20), states[0])
        with scratch.frame():
            o, d, _ = self.camera.rays(pixels, drawn(keys, 2, 100 * sample, scratch), states[0])
        beta = lane = None
        for depth in range(self.depth):
            states[1 - depth % 2].reset()
            with scratch.frame(), np.errstate(all="ignore"):
                hits = self.accel.intersect(o, d, None, scratch, clock=worker.clock)
                if depth == 0:
                    out += np.where(hits.prim < 0, 0, self.emission.take(hits.prim, axis=1, mode="wrap"))
                met = np.greater_equal(hits.prim, 0, out=scratch.empty(hits.prim.size, bool)).nonzero()[0]
                o, d, keys, t, prim = (scratch.take(a, met) for a in (o, d, keys, hits.t, hits.prim))
                beta = beta if beta is None else scratch.take(beta, met)
                lane = met if lane is None else scratch.take(lane, met)
                first = 100 * sample + 8 * depth + 8
                state = self.scatter(o, d, keys, beta, lane, t, prim, depth, first, out, worker)
                o, d, keys, beta, lane = state
                if lane.size == 0:
                    break
        return out

    def scatter(self, o, d, keys, beta, lane, t, prim, depth, first, out, worker):
        """Add the lamp's light at hits; the paths that go on, in the other state."""
        scratch, spare = worker.scratch, worker.states[1 - depth % 2]
        number = prim.astype(np.intp)
        p, n = np.multiply(d, t, out=scratch.empty(d.shape)), scratch.take(self.normals, number)
        np.add(p, o, out=p)
        side = np.einsum("ij,ij->j", n, d)
        np.multiply(n, np.copysign(np.float32(1), np.negative(side, out=side), out=side), out=n)
        color = scratch.take(self.colors, number)
        if beta is not None:
            np.multiply(color, beta, out=color)
        u = drawn(keys, 5 if depth >= ROULETTE_DEPTH else 4, first, scratch)
        with spare.frame():
            self.add_direct(p, n, color, u, lane, out, worker, spare)
        d = directions(n, u[2], u[3], scratch)
        np.add(p, np.multiply(n, EPSILON, out=n), out=p)
        if depth < ROULETTE_DEPTH:
            return tuple(copied(a, spare) for a in (p, d, keys, color, lane))
        chance = np.sqrt(np.sqrt(color.max(0, out=scratch.empty(t.size))))
        np.divide(color, np.minimum(chance, 1, out=chance), out=color)
        alive = np.less(u[4], chance, out=scratch.empty(t.size, bool)).nonzero()[0]
        return tuple(spare.take(a, alive) for a in (p, d, keys, color, lane))

    def add_direct(self, p, n, color, u, lane, out, worker, spare):
        """Light of a point of the lamp, chosen by area."""
        scratch = worker.scratch
        w, t = scratch.empty(p.shape), scratch.empty(p.shape)
        np.multiply(self.edges[0], u[0], out=w)
        np.add(w, np.multiply(self.edges[1], u[1], out=t), out=w)
        np.subtract(np.add(w, self.corner, out=w), p, out=w)
        squared, here, there = (
            np.einsum(s, w, a) for s, a in (("ij,ij->j", w), ("ij,ij->j", n), ("ij,i->j", self.facing))
        )
        np.maximum(here, 0, out=here)
        np.multiply(here, np.maximum(np.negative(there, out=there), 0, out=there), out=here)
        np.divide(here, np.multiply(squared, squared, out=squared), out=here)
        lit = nonzero(here, scratch)
        start, towards, off = (spare.take(a, lit) for a in (p, w, n))
        np.add(start, np.multiply(off, EPSILON, out=off), out=start)
        end = spare.full(lit.size, SHORTER)
        blocked = self.accel.occluded(start, towards, end, scratch, clock=worker.clock)
        share, light = spare.take(here, lit), spare.take(color, lit)
        np.copyto(share, 0, where=blocked)
        np.multiply(np.multiply(light, share, out=light), self.power, out=light)
        where = spare.take(lane, lit)
        for row, values in zip(out, light, strict=True):
            add_at(row, where, values)


def copied(array, arena):
    """The same numbers in `arena`."""
    out = arena.empty(array.shape, array.dtype)
    np.copyto(out, array)
    return out


def drawn(keys, count, first, arena):
    """Random numbers (count, N), as many operations each as Zraka's."""
    out, bits = arena.empty((count, keys.size)), arena.empty(keys.size, np.uint32)
    for number, row in enumerate(out, first):
        np.multiply(keys, np.uint32(hash_int(2 * number + 1) | 1), out=bits)
        np.bitwise_xor(bits, np.uint32(hash_int(2 * number)), out=bits)
        np.right_shift(bits, np.uint32(8), out=bits)
        np.copyto(row, bits.view(np.int32), casting="unsafe")
        np.multiply(row, 2.0**-24, out=row)
    return out


def directions(n, u, v, arena):
    """By the cosine about `n` (3, N): a point of the sphere that touches."""
    w, r = arena.empty(n.shape), arena.empty(u.size)
    z = np.subtract(1, np.add(u, u, out=u), out=u)
    np.sqrt(np.maximum(np.subtract(1, np.multiply(z, z, out=r), out=r), 0, out=r), out=r)
    turn, t = np.multiply(v, np.float32(2 * np.pi), out=v), arena.empty(u.size)
    np.multiply(np.cos(turn, out=t), r, out=w[0])
    np.multiply(np.sin(turn, out=t), r, out=w[1])
    np.copyto(w[2], z)
    np.add(w, n, out=w)
    length = np.sqrt(np.einsum("ij,ij->j", w, w))
    return np.divide(w, np.maximum(length, np.float32(1e-6), out=length), out=w)


if __name__ == "__main__":
    main()
