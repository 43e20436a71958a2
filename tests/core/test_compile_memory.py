# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes that do not fit into memory are refused before they are built."""

from __future__ import annotations

import time

import numpy as np
import pytest

from zraka.core.compile import memory
from zraka.core.compile.geometry import compile_geometry
from zraka.core.compile.memory import available_bytes, check_memory, check_picture
from zraka.core.diagnostics import SceneError
from zraka.core.scene import Camera, Instance, Mesh, Scene

from .scenes import quad


def rock(triangles=10_000):
    """A mesh of that many triangles; nobody looks at their shape."""
    return Mesh(np.zeros((triangles // 2, 3), np.float32), np.zeros((triangles, 3), np.int32))


def test_ten_thousand_instances_are_refused_at_once(monkeypatch):
    monkeypatch.setattr(memory, "available_bytes", lambda: 8 * 10**9)
    mesh = rock()
    scene = Scene(Camera(np.eye(4)), (Instance(quad()), *(Instance(mesh, name="Rock") for _ in range(10_000))))
    start = time.perf_counter()
    with pytest.raises(SceneError) as refused:
        compile_geometry(scene)
    assert time.perf_counter() - start < 1
    said = str(refused.value)
    for part in ("100,000,002 triangles", "7.2 GB can be had", "object 'Rock'", "10,000 instances of 10,000 triangles"):
        assert part in said
    assert 15 < float(said.split("about ")[1].split(" GB")[0]) < 30


def test_what_fits_is_not_refused():
    mesh = rock()
    check_memory([Instance(mesh)] * 1000, 0, 0, available=3 * 10**9)
    with pytest.raises(SceneError, match="'object' with 1,000 instances"):
        check_memory([Instance(mesh)] * 1000, 0, 0, available=10**9)
    with pytest.raises(SceneError):  # what nodes read counts
        check_memory([Instance(mesh)] * 1000, 4, 20, available=3 * 10**9)
    check_memory([Instance(mesh)], 0, 0, available=0)  # too little to ask


def test_one_large_mesh_is_named_without_instances():
    with pytest.raises(SceneError, match=r"'object' with 2,000,000 triangles: show"):
        check_memory([Instance(rock(2_000_000))], 0, 0, available=10**8)


def test_the_estimate_is_near_what_the_tables_take(monkeypatch):
    """The tables alone, without Embree's tree, which takes about as much again."""
    mesh = rock(20_000)
    mesh.vertices[:] = np.random.default_rng(0).random(mesh.vertices.shape)
    mesh.triangles[:] = np.random.default_rng(1).integers(0, len(mesh.vertices), mesh.triangles.shape)
    geometry = compile_geometry(Scene(Camera(np.eye(4)), (Instance(mesh),)))
    tables = sum(
        a.nbytes for a in (geometry.facets, geometry.index, geometry.vertices, geometry.material, geometry.object)
    )
    assert 0.4 < tables / (20_000 * memory._TRIANGLE + 10_000 * memory._VERTEX) < 0.6


def test_the_system_tells_how_much_is_free():
    free = available_bytes()
    assert free is None or 10**7 < free < 10**14


def test_a_picture_that_does_not_fit_is_refused():
    check_picture(20_000, 10_000, available=30 * 10**9)
    check_picture(640, 480, available=0)  # too little to ask
    with pytest.raises(SceneError, match=r"20000 × 10000 pixels is too large: .* 20.0 GB of memory, 9.0 GB can be had"):
        check_picture(20_000, 10_000, available=10**10)
    with pytest.raises(SceneError, match="too large"):  # than its pixels can be numbered
        check_picture(65536, 32768, available=10**15)
