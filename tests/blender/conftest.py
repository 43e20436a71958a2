# SPDX-License-Identifier: GPL-3.0-or-later
"""Real Blenders with Zraka's extension installed. They come from Debian, by `real_blender.sh`."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest

FOLDER = Path(__file__).parent
ROOT = FOLDER.parents[1]
GATE = "trixie"
VERSIONS = {"trixie": "4.3", "sid": "5.2"}
_left_out = []
_measured = []


@dataclass(frozen=True)
class Blender:
    """A Blender of a Debian suite, with preferences of its own, working in `folder`."""

    suite: str
    home: Path
    folder: Path

    @property
    def version(self):
        """Blender's, e.g. ``"4.3"``."""
        return VERSIONS[self.suite]

    def __call__(self, *args, gui=False, timeout=120):
        """Run Blender with arguments; returns the finished process, all that was said in its `stdout`."""
        command = [FOLDER / "real_blender.sh", "gui" if gui else "run", self.suite, "blender", *map(str, args)]
        return subprocess.run(
            command,
            cwd=self.folder,
            env=os.environ | {"BLENDER_HOME": str(self.home)},
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            errors="replace",
            timeout=timeout,
            check=False,
        )

    def script(self, name, *args):
        """Arguments that run a script of ``inside/``, with arguments of its own."""
        for file in {name, "driver.py"}:
            shutil.copy(FOLDER / "inside" / file, self.folder)
        return ["--python-exit-code", 3, "--python", name, *(["--", *args] if args else [])]


@pytest.fixture(scope="session")
def extension(tmp_path_factory):
    """The extension, with wheels for the Pythons of Debian's Blenders."""
    folder = tmp_path_factory.mktemp("extension")
    wheels = ["--platform", "linux-x64", "--python", "3.13", "--python", "3.14"]
    subprocess.run([sys.executable, ROOT / ".ci" / "extension.py", *wheels, "--folder", folder], check=True)
    return next(folder.glob("*.zip"))


@pytest.fixture(scope="session", params=VERSIONS)
def installed(request, extension, tmp_path_factory):
    """A Blender of each suite with the extension installed, as a user would from the command line."""
    suite = request.param
    done = subprocess.run([FOLDER / "real_blender.sh", "setup", suite], capture_output=True, text=True, check=False)
    if done.returncode:
        said = done.stderr.strip().splitlines()[-1] if done.stderr.strip() else "no reason given"
        if suite == GATE:
            pytest.fail(f"Blender {VERSIONS[suite]} is not to be had: {done.stderr}")
        _left_out.append(f"Blender {VERSIONS[suite]} was NOT TESTED: {said}")
        pytest.skip(_left_out[-1])
    folder = tmp_path_factory.mktemp(suite)
    blender = Blender(suite, folder / "home", folder)
    blender.home.mkdir()
    done = blender("--command", "extension", "install-file", "-r", "user_default", "--enable", extension)
    assert done.returncode == 0, done.stdout
    return blender


@pytest.fixture(scope="session")
def samples(tmp_path_factory):
    """A copy of the sample scenes."""
    return shutil.copytree(ROOT / "sample_blends", tmp_path_factory.mktemp("samples") / "copy")


@pytest.fixture
def blender(installed, samples, tmp_path):
    """The same, in a folder of the test's own with a copy of the Cornell box."""
    shutil.copy(samples / "cornell.blend", tmp_path)
    return Blender(installed.suite, installed.home, tmp_path)


@pytest.fixture(scope="session")
def measured():
    """A list of lines that are said at the end of the run."""
    return _measured


def pytest_terminal_summary(terminalreporter):
    """Say what was measured, and loudly when a Blender was left out."""
    for line in _measured:
        terminalreporter.write_line(f"zraka: {line}")
    for line in dict.fromkeys(_left_out):
        terminalreporter.write_line(f"zraka: {line}", red=True, bold=True)
