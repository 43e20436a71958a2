# SPDX-License-Identifier: GPL-3.0-or-later
"""What all tests share. Tests in `tests/addon` need Blender as a Python module; without it they are left out."""

from __future__ import annotations

import importlib.util
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
HAS_BPY = importlib.util.find_spec("bpy") is not None


def pytest_report_header(config):
    """Say what is left out."""
    if not HAS_BPY:
        return "zraka: bpy is not installed, so tests/addon is LEFT OUT (pip install -e '.[blender,dev]')"
    return None


def pytest_ignore_collect(collection_path, config):
    """Leave out what cannot even be imported."""
    if not HAS_BPY and "addon" in collection_path.relative_to(ROOT).parts:
        return True
    return None


@pytest.fixture(autouse=True)
def no_silent_arithmetic():
    """What users are not bothered with is an error in tests: overflows and NaN while rendering."""
    from zraka.core.methods.wavefront import watched_arithmetic

    with watched_arithmetic():
        yield


@pytest.fixture
def blender_scene():
    """An empty scene of a fresh file, with Zraka registered and chosen, 32 x 24 pixels."""
    import bpy

    import zraka

    zraka.register()
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "ZRAKA"
    scene.render.resolution_x, scene.render.resolution_y = 32, 24
    scene.render.resolution_percentage = 100
    scene.zraka.samples = 2
    return scene


@pytest.fixture
def add_camera():
    """A function that gives a scene a camera that looks down from above."""
    import bpy

    def add(scene, name="Camera", height=5.0):
        camera = bpy.data.objects.new(name, bpy.data.cameras.new(name))
        camera.location.z = height
        scene.collection.objects.link(camera)
        scene.camera = scene.camera or camera
        return camera

    return add


@pytest.fixture
def run_python():
    """A function that runs a fresh Python in the repository and returns the finished process."""

    def run(*args, **kwargs):
        command = [sys.executable, *map(str, args)]
        return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=120, check=False, **kwargs)

    return run
