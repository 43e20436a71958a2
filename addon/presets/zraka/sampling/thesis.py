# SPDX-License-Identifier: GPL-3.0-or-later
"""The settings of the thesis: 30 pictures averaged, depth 5, rays through random points of the pixel."""

import bpy

zraka = bpy.context.scene.zraka
zraka.samples = 30
zraka.viewport_samples = 30
zraka.noise_target = 0.0
zraka.viewport_noise_target = 0.0
zraka.adaptive = False
zraka.time_limit = 0.0
zraka.depth = 5
zraka.diffuse_bounces = 1024
zraka.glossy_bounces = 1024
zraka.transmission_bounces = 1024
zraka.transparent_depth = 8
zraka.clamp_direct = 0.0
zraka.clamp_indirect = 0.0
zraka.pixel_filter = "BOX"
zraka.filter_width = 1.5
