# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line: ``zraka render FILE.blend``, ``zraka bench`` ...; ``python -m zraka``, ``blender --command zraka``.

Blender is imported after the arguments were found good. Exit codes: 0; 2 with one line for bad input; 130 when
interrupted by Ctrl-C, with the samples so far in the file.
"""

from __future__ import annotations

import argparse
import sys
import time

from ..core.diagnostics import SceneError
from .commands import bench, compare, converge, render, stability, thesis


def main(argv=None):
    """Run the program.

    Parameters
    ----------
    argv : sequence of str, optional
        Arguments without the program's name; those of the process when None.

    Returns
    -------
    int
        The exit code.
    """
    started = time.perf_counter()
    try:
        args = _parser().parse_args(argv)
        return args.run(args, started)
    except SceneError as error:
        print(f"zraka: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("zraka: interrupted before the first sample; nothing was written", file=sys.stderr)
        return 130


# -- arguments ---------------------------------------------------------------------------------------------------------


class _Parser(argparse.ArgumentParser):
    """Says what is wrong in one line, without the usage before it."""

    def error(self, message):
        self.exit(2, f"{self.prog}: {message}\n")


def _parser():
    from .. import __version__

    parser = _Parser(prog="zraka", description="Render Blender scenes with Zraka.")
    parser.add_argument("--version", action="version", version=f"zraka {__version__}")
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    for command in (render, converge, compare, thesis, bench, stability):
        command.add_command(commands)
    return parser


# -- blender --command zraka -------------------------------------------------------------------------------------------

_commands = []


def register():
    """Add the program to Blender's commands, where it has them (4.2 has)."""
    import bpy

    if hasattr(bpy.utils, "register_cli_command"):
        _commands.append(bpy.utils.register_cli_command("zraka", main))


def unregister():
    """Remove it."""
    import bpy

    while _commands:
        bpy.utils.unregister_cli_command(_commands.pop())
