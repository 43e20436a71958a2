# SPDX-License-Identifier: GPL-3.0-or-later
"""A picture to keep: as many samples as an error of 1% takes, and no light lost."""

import bpy

zraka = bpy.context.scene.zraka
zraka.samples = 4096
zraka.viewport_samples = 256
zraka.noise_target = 0.01
zraka.viewport_noise_target = 0.02
zraka.adaptive = True
zraka.time_limit = 0.0
zraka.depth = 16
zraka.diffuse_bounces = 1024
zraka.glossy_bounces = 1024
zraka.transmission_bounces = 1024
zraka.transparent_depth = 8
zraka.clamp_direct = 0.0
zraka.clamp_indirect = 0.0
zraka.pixel_filter = "BLACKMAN_HARRIS"
zraka.filter_width = 1.5
