# SPDX-License-Identifier: GPL-3.0-or-later
"""The house's own rules: who may import whom, how long a file may be, what stands at its top."""

from __future__ import annotations

import ast
import tomllib
import zipfile
from pathlib import Path

import pytest

import zraka

ROOT = Path(__file__).resolve().parents[1]
TOOLS = {"build", "dist", "renders", "zraka.egg-info"}
FILES = sorted(
    path
    for path in ROOT.rglob("*.py")
    if not any(part.startswith(".") or part in TOOLS for part in path.relative_to(ROOT).parts)
)
PACKAGE = [p for p in FILES if p.relative_to(ROOT).parts[0] in {"addon", "core"}]

# A room may import its own, those on its right in `docs/design.md`, and nothing else. The floor is what all may use.
FLOOR = {
    "core.diagnostics",
    "core.camera_description",
    "core.geometry_description",
    "core.light_description",
    "core.scene",
    "core.settings",
    "core.arena",
    "core.limits",
    "core.visibility",
}
VECTORS = FLOOR | {"core.vecmath", "core.geometry", "core.interaction", "core.spaces", "core.strands"}
SAMPLING = VECTORS | {"core.sampling"}
CAMERA = {"core.camera_lens", "core.camera_panorama"}
TABLES = SAMPLING | {"core.accel", "core.partial", "core.planes", "core.camera", "core.camera_window"} | CAMERA
COMPILE = TABLES | {"core.bsdf", "core.nodes", "core.lights", "core.compile"}
METHODS = COMPILE | {"core.methods", "core.tile_order"}
# Measures and forecasts know arrays alone, so that a film may be judged by what reports are.
FILM = SAMPLING | {"core.neighbours", "core.pixel_set", "core.report.error"}
RENDER = METHODS | {"core.film", "core.adaptive", "core.shutter", "core.render"}
MAY_IMPORT = {
    "core.arena": FLOOR,
    "core.diagnostics": set(),
    "core.limits": set(),
    "core.scene": FLOOR,
    "core.settings": FLOOR,
    "core.vecmath": FLOOR,
    "core.interaction": VECTORS,
    "core.sampling": SAMPLING,
    "core.accel": TABLES,
    "core.partial": TABLES,
    "core.visibility": set(),
    "core.geometry": VECTORS,
    "core.planes": TABLES,
    "core.spaces": VECTORS | {"core.camera_panorama"},
    "core.camera": TABLES,
    "core.camera_description": set(),
    "core.geometry_description": set(),
    "core.light_description": {"core.geometry_description", "core.visibility"},
    "core.strands": VECTORS,
    "core.camera_lens": SAMPLING,
    "core.camera_panorama": VECTORS,
    "core.camera_window": TABLES,
    "core.bsdf": SAMPLING,
    "core.nodes": SAMPLING | {"core.bsdf"},
    "core.lights": TABLES,
    "core.compile": COMPILE,
    "core.methods": METHODS,
    "core.shutter": COMPILE,
    "core.neighbours": set(),
    "core.pixel_set": set(),
    "core.tile_order": set(),
    "core.estimate": FILM,
    "core.film": FILM | {"core.estimate"},
    "core.adaptive": FILM,
    "core.workers": METHODS,
    "core.processes": METHODS | {"core.workers"},
    "core.render": RENDER | {"core.report.forecast", "core.workers", "core.processes"},
    "core.bake": RENDER,
    "core.report": RENDER,
    "core.stability": RENDER | {"core.report"},
}


def room_of(path):
    """`core/bsdf/lambert.py` is in the room ``core.bsdf``, `core/film.py` in ``core.film``, `addon/` is one room."""
    parts = path.relative_to(ROOT).with_suffix("").parts
    return parts[0] if parts[0] == "addon" or parts[1] == "__init__" else ".".join(parts[:2])


def imported_modules(path, tree):
    """Dotted names of what a file imports, relative ones resolved from the root, e.g. ``core.scene.Mesh``."""
    package = path.relative_to(ROOT).parent.parts
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = package[: len(package) - node.level + 1] if node.level else ()
            module = [*base, *(node.module or "").split(".")] if node.module else list(base)
            yield from (".".join([*module, alias.name]) for alias in node.names)


def wrong_imports(path, source):
    """Imports of `source`, standing at `path`, that the table does not allow."""
    room = room_of(path)
    names = list(imported_modules(path, ast.parse(source)))
    wrong = [n for n in names if n.split(".")[0] == "zraka"]
    if room == "addon":
        return wrong
    allowed = MAY_IMPORT.get(room, set()) | {room}
    banned = {"bpy", "mathutils", "gpu", "addon"} | (set() if room == "core.accel" else {"embreex"})
    wrong += [n for n in names if n.split(".")[0] in banned]
    wrong += [n for n in names if n.startswith("core.") and not _rooms(n) & allowed]
    return wrong


def _rooms(name):
    """The room of a dotted name, and the file in it: one file of a room may be allowed alone."""
    return {".".join(name.split(".")[:depth]) for depth in (2, 3)}


def relative_id(path):
    return path.relative_to(ROOT).as_posix()


@pytest.mark.parametrize("path", PACKAGE, ids=relative_id)
def test_imports_point_one_way(path):
    assert wrong_imports(path, path.read_text(encoding="utf-8")) == []


@pytest.mark.parametrize(
    ("place", "source"),
    [
        ("core/film.py", "from .methods import wavefront"),
        ("core/bsdf/lambert.py", "from ..accel import Accel"),
        ("core/scene.py", "import bpy"),
        ("core/render.py", "def f():\n    from mathutils import Vector"),
        ("core/film.py", "import embreex"),
        ("core/compile/geometry.py", "from ...addon import session"),
        ("addon/ui.py", "from zraka.core.scene import Mesh"),
    ],
)
def test_a_wrong_import_is_found(place, source):
    assert wrong_imports(ROOT / place, source)


@pytest.mark.parametrize("path", FILES, ids=relative_id)
def test_file_is_licensed_and_short(path):
    lines = path.read_text(encoding="utf-8").splitlines()
    if lines:  # an empty __init__.py says nothing
        assert any("SPDX-License-Identifier: GPL-3.0-or-later" in line for line in lines[:2])
    assert len(lines) <= 400


def test_core_leaves_blender_alone(run_python):
    modules = [
        ".".join(("zraka", *p.relative_to(ROOT).with_suffix("").parts)) for p in PACKAGE if "core" in p.parts[:-1]
    ]
    program = (
        f"import importlib, sys\nfor m in {modules!r}: importlib.import_module(m.removesuffix('.__init__'))\n"
        "print([m for m in ('bpy', 'mathutils', 'gpu', 'OpenImageIO') if m in sys.modules])"
    )
    done = run_python("-c", program)
    assert done.stdout.strip() == "[]", done.stderr


def test_packages_and_versions_agree():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    found = {".".join(("zraka", *p.parent.relative_to(ROOT).parts)) for p in PACKAGE if p.name == "__init__.py"}
    assert set(project["tool"]["setuptools"]["packages"]) == found | {"zraka"}
    manifest = tomllib.loads((ROOT / "blender_manifest.toml").read_text(encoding="utf-8"))
    assert manifest["version"] == project["project"]["version"] == zraka.__version__


def extension_tool():
    """Blender's own program that checks and packs extensions."""
    bpy = pytest.importorskip("bpy")
    return Path(bpy.utils.system_resource("SCRIPTS")) / "addons_core/bl_pkg/cli/blender_ext.py"


def test_blender_accepts_the_manifest(run_python):
    done = run_python(extension_tool(), "validate", ROOT)
    assert done.returncode == 0, done.stdout + done.stderr


def test_blender_packs_what_it_needs_and_no_more(run_python, tmp_path):
    archive = tmp_path / "zraka.zip"
    done = run_python(extension_tool(), "build", "--source-dir", ROOT, "--output-filepath", archive)
    assert done.returncode == 0, done.stdout + done.stderr
    with zipfile.ZipFile(archive) as file:
        tops = {name.split("/")[0] for name in file.namelist()}
    needed = {"__init__.py", "blender_manifest.toml", "addon", "core", "LICENSE"}
    assert needed <= tops
    assert tops <= needed | {"__main__.py", "pyproject.toml", "README.md"}
