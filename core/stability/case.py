# SPDX-License-Identifier: GPL-3.0-or-later
"""One scene with a known answer: how it is rendered and judged."""

from __future__ import annotations

import time
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

from ..accel import Accel
from ..compile import compile_scene
from ..compile.features import Feature
from ..compile.visibility import SceneVisibility
from ..diagnostics import Diagnostics, SceneError
from ..methods.wavefront import watched_arithmetic
from ..render import render
from ..scene import Scene
from ..settings import METHODS, Settings
from ..shutter import Shutter, compile_shutter

SIGMAS = 4.0  # standard errors of the mean that noise is allowed
PATH = ("pathtrace",)
THREADS = 2


@dataclass(frozen=True)
class Case:
    """A scene, what its picture's mean must be, and by which methods.

    Parameters
    ----------
    build : callable
        Makes the `Scene`, or a tuple of those at the moments of a shutter.
    truth : float or None
        Mean of the picture over pixels and channels; None asks for finite samples alone.
    methods : sequence of str
        By which the truth holds. The others must give finite samples.
    tolerance : float
        Relative; four standard errors of the mean come on top.
    samples, size, settings
        Of `Settings`; `size` is (width, height).
    finite : bool
        Whether all that the scene describes is finite, so that no sample may be otherwise.
    told : str
        Words of a diagnostic that the user must see. With them a wrong value is out of range instead of failed.
    """

    build: Callable[[], Scene | tuple]
    truth: float | None = None
    methods: tuple = PATH
    tolerance: float = 5e-3
    samples: int = 64
    size: tuple = (8, 8)
    settings: Mapping = field(default_factory=dict)
    finite: bool = True
    told: str = ""


class Outcome(NamedTuple):
    """What one render of a case gave; `verdict` is "pass", "out of range" or "fail", and `note` says why."""

    method: str
    route: str
    features: str
    value: float | None
    noise: float | None  # standard error of the value
    nonfinite: int
    seconds: float
    verdict: str
    note: str


class Variant(NamedTuple):
    """A method, Embree's C API or embreex's own interface, and the scene's own stages or all."""

    method: str
    native: bool = True
    every_feature: bool = False

    @property
    def route(self):
        """The interface's name."""
        return "C API" if self.native else "TriangleMesh"

    @property
    def features(self):
        """The stages' name."""
        return "ALL" if self.every_feature else "own"


METHOD_VARIANTS = tuple(Variant(m) for m in reversed(METHODS))
OTHER_ROUTE = Variant("pathtrace", native=False)
EVERY_FEATURE = Variant("pathtrace", every_feature=True)
ALL_VARIANTS = (*METHOD_VARIANTS, OTHER_ROUTE, EVERY_FEATURE)


def measure(case, variant=METHOD_VARIANTS[0]):
    """Render a case once and judge it; numpy's warnings and every exception fail it.

    Parameters
    ----------
    case : Case
    variant : Variant

    Returns
    -------
    Outcome
    """
    started, diagnostics = time.perf_counter(), Diagnostics()
    value = noise = None
    nonfinite, failure = 0, ""
    try:
        with warnings.catch_warnings(), watched_arithmetic():
            warnings.simplefilter("error")
            film = _film(case, variant, diagnostics)
        value, noise = mean_of(film)
        nonfinite = film.nonfinite
    except SceneError as error:
        diagnostics.warn(str(error))
    except Exception as error:  # whatever goes wrong is what the grid looks for
        failure = f"{type(error).__name__}: {error}"
    verdict, note = _judge(case, variant, value, noise, nonfinite, failure, diagnostics.messages())
    seconds = time.perf_counter() - started
    return Outcome(variant.method, variant.route, variant.features, value, noise, nonfinite, seconds, verdict, note)


def film_of(case, variant=METHOD_VARIANTS[0], **changes):
    """The film of a case, with some `Settings` changed."""
    return _film(case, variant, Diagnostics(), **changes)


def settings_of(case, **changes):
    """The `Settings` of a case."""
    width, height = case.size
    plain = {"width": width, "height": height, "samples": case.samples, "threads": THREADS}
    return Settings(**(plain | dict(case.settings) | changes))


def mean_of(film):
    """Mean of a film over pixels and channels, and its standard error."""
    channels = film.mean()[:3]
    return float(channels.mean()), float((film.pixel_error() ** 2).mean() ** 0.5 / channels.shape[1] ** 0.5)


def _film(case, variant, diagnostics, **changes):
    settings = settings_of(case, method=variant.method, **changes)
    described = case.build()
    if isinstance(described, Scene):
        return render(compiled_of(described, settings, variant, diagnostics), settings)
    if variant in METHOD_VARIANTS:
        return render(compile_shutter(described, settings, diagnostics), settings)
    return render(Shutter(compiled_of(scene, settings, variant, diagnostics) for scene in described), settings)


def compiled_of(scene, settings, variant, diagnostics):
    """A compiled `Scene` that casts its rays and has the stages as `variant` says."""
    every = Feature.all() if variant.every_feature else None
    compiled = compile_scene(scene, settings, diagnostics, every)
    if not variant.native:
        compiled.accel = Accel(compiled.geometry, native=False)
        compiled.visibility = SceneVisibility(scene, compiled.geometry, compiled.lights, compiled.accel)
    return compiled


def _judge(case, variant, value, noise, nonfinite, failure, messages):
    """(verdict, note)."""
    said = "; ".join(messages)
    if failure:
        return "fail", failure
    if case.told and case.told not in said:
        return "fail", f"the user is not told {case.told!r}; {said}"
    if nonfinite and case.finite:
        return "fail", f"{nonfinite} samples are not finite"
    if value is None:
        return ("out of range" if case.told else "fail"), said
    if case.truth is None or variant.method not in case.methods:
        return "pass", said
    allowed = case.tolerance * abs(case.truth)
    if abs(value - case.truth) <= allowed + SIGMAS * noise:
        # A picture so noisy that nothing could fail says nothing.
        quiet = SIGMAS * noise <= 4 * allowed or case.truth == 0
        return ("pass", said) if quiet else ("fail", "too noisy to tell")
    return ("out of range" if case.told else "fail"), said
