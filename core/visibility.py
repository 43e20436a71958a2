# SPDX-License-Identifier: GPL-3.0-or-later
"""Who sees a thing: kinds of rays, and for what shines the objects it reaches."""

from __future__ import annotations

import enum
from dataclasses import dataclass


class Rays(enum.IntFlag):
    """Kinds of rays. A ray that was sent through a surface is TRANSMISSION, whatever sent it."""

    CAMERA = enum.auto()
    DIFFUSE = enum.auto()
    GLOSSY = enum.auto()
    TRANSMISSION = enum.auto()
    SHADOW = enum.auto()


ALL_RAYS = Rays(31)
UNLIMITED = 1 << 30


@dataclass(frozen=True)
class ObjectSet:
    """The objects called `names`, or with `excluded` all others."""

    names: frozenset[str] = frozenset()
    excluded: bool = False

    def __contains__(self, name):
        return (name in self.names) != self.excluded


@dataclass(frozen=True)
class Visibility:
    """Who sees an object, a light or the world.

    Parameters
    ----------
    rays : Rays
        The kinds of rays that meet it. Light that is sampled counts as met by the lobes that it is scattered by; SHADOW
        means nothing to lights and worlds.
    holdout : bool
        Objects only: the camera sees a hole in their place.
    catcher : bool
        Objects: they stand for what is behind the picture, which shows only how others shade them
        (`core.methods.catchers`). Lights: whether they belong to what is behind; the world does.
    receivers, blockers : ObjectSet, optional
        Of what shines: the objects that it lights, and those that shade it; None is all.
    receives_as, blocks_as : str
        Objects only: the name by which they are found in these sets; "" is their own.
    max_bounces : int
        Lights and worlds only: scatterings after which it shines no more on what is met.
    """

    rays: Rays = ALL_RAYS
    holdout: bool = False
    catcher: bool = False
    receivers: ObjectSet | None = None
    blockers: ObjectSet | None = None
    receives_as: str = ""
    blocks_as: str = ""
    max_bounces: int = UNLIMITED


SEEN_BY_ALL = Visibility()
LAMP = Visibility(ALL_RAYS & ~Rays.CAMERA, catcher=True)
"""Blender's default of lights: the camera does not see them."""
