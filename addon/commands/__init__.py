# SPDX-License-Identifier: GPL-3.0-or-later
"""What the command line can do, one command a file; each adds itself by `add_command`."""
