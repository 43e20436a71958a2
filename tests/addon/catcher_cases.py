# SPDX-License-Identifier: GPL-3.0-or-later
"""The room of `visibility_cases` before a film that is seen through glass, and with shadow catchers."""

from __future__ import annotations

import bpy

from .visibility_cases import Case, emitter, give, large_lamp


def film_through_glass(objects, scene):
    """A film that shows it through glass too."""
    scene.render.film_transparent = scene.zraka.film_transparent_glass = True


def glass(roughness, tint=(1, 1, 1, 1)):
    """A box of glass before the world, and no floor."""

    def setup(objects):
        for name in ("Floor", "Mirror", "Glass"):
            objects[name].hide_render = True
        give(objects["Box"], "BsdfGlass", Color=tint, Roughness=roughness, IOR=1.2)
        bpy.context.scene.zraka.depth = 8

    return setup


def hold_out_behind_glass(objects):
    """A hole behind the glass."""
    glass(0.0)(objects)
    bpy.context.scene.zraka.samples = 400  # at 100, noise alone is 2% in some Blenders
    hole = objects["Mirror"]
    hole.hide_render, hole.is_holdout, hole.location = False, True, (0.3, 1.5, 0.7)


def catch(film, *names):
    """Let the floor, and what else is named, catch shadows."""

    def change(objects, scene):
        scene.render.film_transparent = film
        for name in ("Floor", *names):
            objects[name].is_shadow_catcher = True
        # Where the light's estimates are noisy their clipped ratio is too dark, in Cycles as here, but not as much so.
        scene.zraka.samples = 400

    return change


def catch_through_glass(objects, scene):
    """A film, and catchers, that are seen through glass."""
    catch(True)(objects, scene)
    scene.zraka.film_transparent_glass = True


def bare(what=lambda objects: None):
    """No mirror and no glass, the lamp aside, and `what` else."""

    def setup(objects):
        for name in ("Mirror", "Glass"):
            objects[name].hide_render = True
        what(objects)

    return setup


def unseen_box(objects):
    """A box that the camera does not see: outlines before catchers are darker in Cycles."""
    objects["Box"].visible_camera = False


def below_area(objects):
    """A larger lamp."""
    large_lamp((0, 1, 4), -0.3, 2)


def unseen_box_below_area(objects):
    """Both."""
    unseen_box(objects)
    below_area(objects)


def half_transparent(what=lambda objects: None):
    """A floor that lets a fifth of the film be seen, and `what` else."""

    def setup(objects):
        give(objects["Floor"], "BsdfPrincipled", Roughness=0.4, Alpha=0.8)
        what(objects)

    return setup


def second_catcher(objects):
    """Show the other box, of plain colour."""
    objects["Mirror"].hide_render = False
    give(objects["Mirror"], "BsdfDiffuse", Color=(0.7, 0.7, 0.3, 1))


def shown(name):
    """Show an object."""
    return lambda objects: setattr(objects[name], "hide_render", False)


def made_light(objects):
    """A lamp that does not belong to what is behind, beside one that does."""
    lamp = objects["Lamp"].copy()
    lamp.location = (-2, 0, 3)
    bpy.context.collection.objects.link(lamp)
    lamp.is_shadow_catcher = False


CASES = (
    *(
        Case(f"transparent glass of a transparent film, {what}", film_through_glass, setup, alpha=True)
        for what, setup in (
            ("clear", glass(0.0)),
            ("tinted, roughness 0.08", glass(0.08, (0.9, 0.6, 0.3, 1))),
            ("holdout behind it", hold_out_behind_glass),
        )
    ),
    *(
        Case(f"shadow catcher, {what}", catch(film, *names), bare(setup), alpha=True, note=note)
        for what, film, setup, names, note in (
            ("transparent film", True, lambda objects: None, (), ""),
            ("transparent film, lamp with an extent", True, below_area, (), ""),
            ("opaque film", False, unseen_box, (), "of objects before it Cycles darkens the outline"),
            ("opaque film, lamp with an extent", False, unseen_box_below_area, (), ""),
            ("in a mirror", True, shown("Mirror"), (), ""),
            ("two, one on the other", True, second_catcher, ("Mirror",), ""),
            ("and an emitting mesh", True, emitter(1, (1.2, 0, 2.2), 20.0), (), ""),
            ("and an emitting mesh that is one", True, emitter(1, (1.2, 0, 2.2), 20.0), ("Emitter",), ""),
            ("and a lamp that is none", True, made_light, (), ""),
            ("half transparent", True, half_transparent(), (), "what it lets pass counts twice, as in Cycles"),
            ("half transparent, of a box that is not seen", True, half_transparent(unseen_box), (), ""),
            ("behind glass", True, shown("Glass"), (), ""),
        )
    ),
    Case(
        "shadow catcher, behind transparent glass",
        catch_through_glass,
        bare(shown("Glass")),
        alpha=True,
    ),
    Case(
        "transparent glass of a transparent film, roughness 0.3 beyond the threshold",
        film_through_glass,
        glass(0.3),
        alpha=True,
    ),
)
