# SPDX-License-Identifier: GPL-3.0-or-later
"""Pack Zraka as a Blender extension, one .zip a platform: ``python .ci/extension.py``.

The extension brings embreex alone. Blender has numpy, and which of two numpys runs would change from one start to the
next; Blender's own OpenImageIO is used, since a second one would share its symbols with the first.
"""

from __future__ import annotations

import argparse
import importlib.util
import shutil
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
CONTENT = ("__init__.py", "LICENSE", "addon", "core")
PYTHONS = ("3.11", "3.13")  # Blender's: up to 5.0, from 5.1 on

# Blender's names of the platforms, and pip's.
PLATFORMS = {
    "linux-x64": "manylinux_2_28_x86_64",
    "windows-x64": "win_amd64",
    "macos-arm64": "macosx_13_0_arm64",
    "macos-x64": "macosx_13_0_x86_64",
}


def main():
    """Build what the arguments ask for."""
    parser = argparse.ArgumentParser(description="Pack Zraka as a Blender extension.")
    parser.add_argument("--platform", action="append", choices=PLATFORMS, help="may be repeated; all when not given")
    parser.add_argument("--python", action="append", metavar="3.N", help=f"may be repeated; else {' '.join(PYTHONS)}")
    parser.add_argument("--folder", type=Path, default=ROOT / "dist", help="where the .zip goes (dist/)")
    args = parser.parse_args()
    args.folder.mkdir(parents=True, exist_ok=True)
    for platform in args.platform or PLATFORMS:
        print(build(platform, args.python or PYTHONS, args.folder))  # noqa: T201


def build(platform, pythons, folder):
    """Build the extension of one platform; return its path."""
    manifest = (ROOT / "blender_manifest.toml").read_text(encoding="utf-8")
    parsed = tomllib.loads(manifest)
    archive = folder / f"{parsed['id']}-{parsed['version']}-{platform}.zip"
    with tempfile.TemporaryDirectory() as stage:
        stage = Path(stage)
        for name in CONTENT:
            source = ROOT / name
            if source.is_dir():
                shutil.copytree(source, stage / name, ignore=shutil.ignore_patterns("__pycache__"))
            else:
                shutil.copy(source, stage / name)
        wheels = [wheel for python in pythons for wheel in download("embreex", platform, python, stage / "wheels")]
        lists = {"wheels": [f"./wheels/{wheel}" for wheel in wheels], "platforms": [platform]}
        (stage / "blender_manifest.toml").write_text(with_lists(manifest, lists), encoding="utf-8")
        run(extension_tool(), "build", "--source-dir", stage, "--output-filepath", archive)
    run(extension_tool(), "validate", archive)
    return archive


def download(project, platform, python, folder):
    """Download the wheel of a project into a folder, by way of `build/wheels`; return the new files' names."""
    cache = ROOT / "build" / "wheels" / f"{platform}-{python}"
    if not list(cache.glob("*.whl")):
        options = ["--quiet", "--disable-pip-version-check", "--no-deps", "--only-binary=:all:"]
        target = ["--platform", PLATFORMS[platform], "--python-version", python, "--dest", cache]
        run("-m", "pip", "download", *options, *target, requirement(project))
    folder.mkdir(exist_ok=True)
    return [Path(shutil.copy(wheel, folder)).name for wheel in sorted(cache.glob("*.whl"))]


def requirement(project):
    """Which versions `pyproject.toml` allows."""
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    return next(line for line in settings["project"]["dependencies"] if line.startswith(project))


def with_lists(manifest, lists):
    """The manifest with lists put in or exchanged; they must stand before its first table."""
    lines = [line for line in manifest.splitlines() if not line.startswith(tuple(f"{name} =" for name in lists))]
    at = next(i for i, line in enumerate(lines) if line.startswith("["))
    lines[at:at] = [f"{name} = {items!r}".replace("'", '"') for name, items in lists.items()] + [""]
    return "\n".join(lines) + "\n"


def extension_tool():
    """Blender's own program that builds and checks extensions; the bpy module brings it along."""
    package = Path(importlib.util.find_spec("bpy").origin).parent
    return next(package.glob("*/scripts/addons_core/bl_pkg/cli/blender_ext.py"))


def run(*command):
    """Run a Python program; say what it said only when it fails."""
    done = subprocess.run([sys.executable, *map(str, command)], capture_output=True, text=True, check=False)
    if done.returncode:
        sys.exit(f"{done.stdout}{done.stderr}extension: {Path(command[0]).name} failed")


if __name__ == "__main__":
    main()
