# SPDX-License-Identifier: GPL-3.0-or-later
"""A look at the scene within seconds: noisy, and corners a little too dark."""

import bpy

zraka = bpy.context.scene.zraka
zraka.samples = 16
zraka.viewport_samples = 16
zraka.noise_target = 0.0
zraka.viewport_noise_target = 0.0
zraka.adaptive = False
zraka.time_limit = 0.0
zraka.depth = 4
zraka.diffuse_bounces = 1024
zraka.glossy_bounces = 1024
zraka.transmission_bounces = 1024
zraka.transparent_depth = 8
zraka.clamp_direct = 0.0
zraka.clamp_indirect = 30.0
zraka.pixel_filter = "BLACKMAN_HARRIS"
zraka.filter_width = 1.5
