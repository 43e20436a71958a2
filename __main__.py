# SPDX-License-Identifier: GPL-3.0-or-later
"""``python -m zraka`` is the command line."""

import sys

try:
    from .addon.cli import main
except KeyboardInterrupt:  # while modules are still read
    sys.stderr.write("zraka: interrupted before the first sample; nothing was written\n")
    sys.exit(130)

sys.exit(main())
