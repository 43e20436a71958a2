# SPDX-License-Identifier: GPL-3.0-or-later
"""``python -m zraka`` is the command line."""

import sys

from .addon.cli import main

sys.exit(main())
