# SPDX-License-Identifier: GPL-3.0-or-later
"""Rendered shading: `view` says what a region looks at, `worker` traces it in a thread, `viewport` shows it."""
