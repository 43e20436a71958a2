# SPDX-License-Identifier: GPL-3.0-or-later
"""Description to tables: `compile_scene`."""

from .scene import CompiledScene, compile_scene

__all__ = ["CompiledScene", "compile_scene"]
