# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's dependency graph to a `core.scene.Scene`. Everything is copied; nothing of Blender's is kept."""
