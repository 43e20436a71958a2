# SPDX-License-Identifier: GPL-3.0-or-later
"""What every render must keep to, whatever the scene."""

from __future__ import annotations

import time
import warnings
from dataclasses import replace

import numpy as np

from zraka.core.compile import compile_scene
from zraka.core.compile.features import Feature
from zraka.core.diagnostics import Diagnostics, SceneError
from zraka.core.methods.cryptomatte import matte_names
from zraka.core.methods.guides import render_guides
from zraka.core.methods.wavefront import watched_arithmetic
from zraka.core.render import render
from zraka.core.settings import METHODS
from zraka.core.shutter import Shutter, compile_shutter

MOST_SECONDS = 60.0  # of the processor, for a picture of some hundred rays; the table of a Gabor world takes 30


class Broken(AssertionError):
    """A scene that breaks a promise."""


def check(scene, settings, tame, thorough, methods=METHODS):
    """Render `scene`, or those of a tuple while a shutter is open, by all methods.

    `thorough` also compares threads, chunks and features.

    Raises
    ------
    Broken
        With what was not kept. All other exceptions are failures too.
    """
    started = time.process_time()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            compiled = _compiled(scene, settings, thorough)
            forced = _compiled(scene, settings, thorough, Feature.all()) if thorough else None
        except SceneError as error:
            check_sentence(error)
            return
        with watched_arithmetic(tame):
            for method in methods:
                _check_method(compiled, forced, replace(settings, method=method), tame)
        if settings.guides.names:
            middle = scene[len(scene) // 2] if isinstance(scene, tuple) else scene
            _check_guides(getattr(compiled, "middle", compiled), middle, settings, tame)
    spent = time.process_time() - started
    if spent > MOST_SECONDS:
        raise Broken(f"took {spent:.1f} s")


def _compiled(scene, settings, thorough, features=None):
    """A scene as it is rendered; moments that are to be compared are each compiled alone."""
    if not isinstance(scene, tuple):
        return compile_scene(scene, settings, Diagnostics(), features)
    if not thorough:
        return compile_shutter(scene, settings, Diagnostics())
    return Shutter(compile_scene(moment, settings, Diagnostics(), features) for moment in scene)


def check_sentence(error):
    """What the user reads of a `SceneError` is one line."""
    text = str(error)
    if not text or "\n" in text:
        raise Broken(f"no sentence: {text!r}")


def _check_method(compiled, forced, settings, tame):
    film = render(compiled, settings)
    picture = film.image()
    if not np.isfinite(picture).all():
        raise Broken(f"{settings.method}: the picture is not finite")
    if tame and film.nonfinite:
        raise Broken(f"{settings.method}: {film.nonfinite} samples are not finite")
    if forced is None:
        return
    expected = picture.tobytes(), film.nonfinite
    for what, scene, other in (
        ("threads", compiled, replace(settings, threads=2)),
        ("chunks", compiled, replace(settings, chunk=37, tile=3)),
        ("features", forced, settings),
    ):
        again = render(scene, other)
        if not tame and again.nonfinite != film.nonfinite and what == "features":
            continue  # 0 times infinity is NaN, a stage that is left out is 0
        if (again.image().tobytes(), again.nonfinite) != expected:
            worst = np.abs(again.image() - picture).max()
            raise Broken(f"{settings.method}: other {what}, another picture ({worst:g})")


def _check_guides(compiled, scene, settings, tame):
    pictures = render_guides(compiled, scene, settings, around=(scene, scene))
    matte_names(compiled, scene, settings.guides)
    for name, picture in pictures.items():
        if tame and not np.isfinite(picture).all():
            raise Broken(f"guide {name} is not finite")
