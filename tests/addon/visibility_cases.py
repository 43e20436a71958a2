# SPDX-License-Identifier: GPL-3.0-or-later
"""A room in which not all see all: a floor, a box, a mirror, a glass box and a lamp.

Lamps are points where they may be, which mirrors and glass do not throw elsewhere, so that little is left to chance.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass

import bpy
import numpy as np

from zraka.addon.bench.engines import match, operate, watched

from .nodes.harness import add, fresh_scene

SIDE, BLOCKS = 24, 4


@dataclass(frozen=True)
class Case:
    """What is changed in the room, ``change(objects, scene)``, after ``setup(objects)``, and how far off it may be.

    `alpha`: whether that is compared as well.
    """

    item: str
    change: Callable
    setup: Callable = lambda objects: None
    tolerance: float = 0.02
    note: str = ""
    alpha: bool = False


def give(obj, kind, **inputs):
    """Give an object a material of one shader node."""
    material = bpy.data.materials.new(kind)
    tree = tree_of(material)
    shader, output = add(tree, kind, inputs), add(tree, "OutputMaterial")
    tree.links.new(shader.outputs[0], output.inputs["Surface"])
    obj.data.materials.clear()
    obj.data.materials.append(material)


def tree_of(owner):
    """An empty node tree."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        owner.use_nodes = True
    owner.node_tree.nodes.clear()
    return owner.node_tree


def cube(name, location, size, kind="BsdfDiffuse", **inputs):
    """A cube of one shader."""
    bpy.ops.mesh.primitive_cube_add(size=size, location=location)
    bpy.context.object.name = name
    give(bpy.context.object, kind, **inputs)


def room():
    """The scene."""
    scene = fresh_scene()
    scene.render.resolution_x = scene.render.resolution_y = SIDE
    scene.zraka.method, scene.zraka.depth, scene.zraka.samples = "PATHTRACE", 3, 100
    camera = scene.camera
    camera.data.type, camera.data.lens = "PERSP", 50
    camera.location, camera.rotation_euler = (0, -6, 3.5), (1.05, 0, 0)
    scene.world = bpy.data.worlds.new("World")
    tree = tree_of(scene.world)
    background, output = add(tree, "Background", {"Color": (0.2, 0.3, 0.4, 1)}), add(tree, "OutputWorld")
    tree.links.new(background.outputs[0], output.inputs["Surface"])
    bpy.ops.mesh.primitive_plane_add(size=12)
    bpy.context.object.name = "Floor"
    give(bpy.context.object, "BsdfPrincipled", Roughness=0.4)
    cube("Box", (0, 0, 0.7), 1.2, Color=(0.8, 0.2, 0.2, 1))
    cube("Mirror", (-1.6, 0, 0.7), 1.2, "BsdfAnisotropic", Color=(0.9, 0.9, 0.9, 1), Roughness=0.0)
    cube("Glass", (0.6, -2, 0.5), 0.8, "BsdfGlass", Color=(1, 1, 1, 1), Roughness=0.0, IOR=1.05)
    lamp = bpy.data.objects.new("Lamp", bpy.data.lights.new("Lamp", "POINT"))
    lamp.data.energy, lamp.data.shadow_soft_size, lamp.location = 200, 0, (1.5, -1, 3.5)
    scene.collection.objects.link(lamp)
    return scene


def large_lamp(location, turn, size, energy=200):
    """Put an area lamp in the place of the other, before surfaces that throw no light about."""
    bpy.data.objects["Mirror"].hide_render = bpy.data.objects["Glass"].hide_render = True
    lamp = bpy.data.objects["Lamp"]
    lamp.data = bpy.data.lights.new("Area", "AREA")
    lamp.data.energy, lamp.data.size = energy, size
    lamp.location, lamp.rotation_euler = location, (turn, 0, 0)


def means(picture):
    """Means of blocks of pixels, (BLOCKS, BLOCKS, C)."""
    width = SIDE // BLOCKS
    return picture.reshape(BLOCKS, width, BLOCKS, width, -1).mean(axis=(1, 3))


def farthest(some, others):
    """Greatest difference of two pictures of blocks: of colours as a share of the brightest of `others`, of alpha."""
    apart = np.abs(some - others)
    brightest = others[..., :3].max() or 1.0
    return float(max(apart[..., :3].max() / brightest, apart[..., 3:].max(initial=0)))


def collection(*names, exclude=False):
    """A collection of objects that light linking includes or excludes."""
    made = bpy.data.collections.new("Set")
    for k, name in enumerate(names):
        made.objects.link(bpy.data.objects[name])
        made.collection_objects[k].light_linking.link_state = "EXCLUDE" if exclude else "INCLUDE"
    return made


def measure(case):
    """Greatest difference of the blocks' means, of how much the change shows, shares of the brightest; messages."""
    scene = room()
    case.setup(bpy.data.objects)
    before = means(operate(scene, "ZRAKA", case.alpha)[0])
    case.change(bpy.data.objects, scene)
    match(scene)
    bpy.context.view_layer.update()
    with watched() as seen:
        ours = means(operate(scene, "ZRAKA", case.alpha)[0])
    theirs = means(operate(scene, "CYCLES", case.alpha)[0])
    return farthest(ours, theirs), farthest(ours, before), seen.messages


# -- changes -----------------------------------------------------------------------------------------------------------


def hide(name, kind):
    """Hide an object from a kind of rays."""
    return lambda objects, _: setattr(objects[name], f"visible_{kind}", False)


def lower_glass(objects):
    """Put the glass before the box."""
    objects["Glass"].location = (0, -1.2, 0.6)


def panel(refraction):
    """An area lamp instead of the point; a box that refracts where it is asked for."""

    def setup(objects):
        large_lamp((0, 2, 0.8), -1.4, 2, 50)
        if refraction:
            give(objects["Box"], "BsdfRefraction", Color=(1, 1, 1, 1), Roughness=0.5, IOR=1.1)
            bpy.context.scene.zraka.samples = 800  # at 100, noise alone is up to 4% in some Blenders

    return setup


def dim(objects):
    """Leave the light to the world."""
    objects["Lamp"].data.energy = 1


def aside(objects):
    """Put the lamp where what is linked shows."""
    objects["Lamp"].location = (1.5, 0, 2.5)


def link(role, names, exclude, owner="Lamp"):
    """Link a lamp or an emitter with objects."""

    def change(objects, _):
        setattr(objects[owner].light_linking, f"{role}_collection", collection(*names, exclude=exclude))

    return change


def emitter(size, location, strength, shadow=False, samples=100):
    """A square that emits, with a lamp above it where its shadow is asked for."""

    def setup(objects):
        dim(objects)
        bpy.context.scene.zraka.samples = samples
        objects["Mirror"].hide_render = objects["Glass"].hide_render = True
        bpy.ops.mesh.primitive_plane_add(size=size, location=location)
        bpy.context.object.name = "Emitter"
        give(bpy.context.object, "Emission", Strength=strength)
        if shadow:
            objects["Lamp"].data.energy, objects["Lamp"].location = 400, (1.2, 0, 3)

    return setup


def white_floor(objects):
    """Send much light on."""
    give(objects["Floor"], "BsdfDiffuse", Color=(0.9, 0.9, 0.9, 1))
    objects["Mirror"].location.y = -1


def limit(bounces):
    """Limit the bounces of the lamp: a point, as Cycles limits how lamps are sampled, not how they are met."""
    return lambda objects, _: setattr(objects["Lamp"].data.cycles, "max_bounces", bounces)


def no_shadow(objects, _):
    """Let the lamp shine through everything."""
    data = objects["Lamp"].data
    data.use_shadow = False
    if hasattr(data.cycles, "cast_shadow"):  # before 5.0
        data.cycles.cast_shadow = False


def hold_out(film):
    """Cut the box out of the picture."""

    def change(objects, scene):
        scene.render.film_transparent = film
        objects["Box"].is_holdout = True

    return change


def half_transparent(objects):
    """A box that is seen through."""
    give(objects["Box"], "BsdfPrincipled", Alpha=0.4)


def opaque(objects):
    """A box that is not."""
    give(objects["Box"], "BsdfPrincipled")


def indirect_only(objects, scene):
    """Move the box into a collection that the camera does not see."""
    hidden = bpy.data.collections.new("Hidden")
    scene.collection.children.link(hidden)
    hidden.objects.link(objects["Box"])
    scene.collection.objects.unlink(objects["Box"])
    bpy.context.view_layer.layer_collection.children["Hidden"].indirect_only = True


def transparent_film(objects, scene):
    """A film that shows what is behind the scene, but not through glass."""
    scene.render.film_transparent = True


RAYS = ("camera", "diffuse", "glossy", "transmission")
LINKS = {"include": (("Floor", "Glass"), False), "exclude": (("Box",), True)}
CASES = (
    *(
        Case(
            f"objects hidden from {kind} rays",
            hide("Floor" if kind == "diffuse" else "Box", kind),  # dark beside the box where its light is missing
            lower_glass if kind == "transmission" else lambda objects: None,
            0.01,
        )
        for kind in (*RAYS, "shadow")
    ),
    *(Case(f"lamps hidden from {k} rays", hide("Lamp", k), panel(k == "transmission")) for k in RAYS[1:]),
    Case("lamps seen by the camera", lambda o, _: setattr(o["Lamp"], "visible_camera", True), panel(False)),
    Case("lamps without shadow", no_shadow),
    *(
        Case(f"world hidden from {k} rays", lambda _, scene, k=k: setattr(scene.world.cycles_visibility, k, False), dim)
        for k in RAYS
    ),
    *(
        Case(f"{what} linking, {how}", link(role, *LINKS[how]), aside)
        for what, role in (("light", "receiver"), ("shadow", "blocker"))
        for how in LINKS
    ),
    *(
        Case(
            f"{what} linking of an emitting mesh",
            link(role, ("Box",), True, "Emitter"),
            emitter(0.5, (1.5, 0, 2.5), 200.0),
        )
        for what, role in (("light", "receiver"), ("shadow", "blocker"))
    ),
    *(
        Case(
            f"emitting mesh hidden from {kind} rays",
            hide("Emitter", kind),
            emitter(1, (1.2, 0, 1.5), 20.0, kind == "shadow", 800 if kind == "camera" else 100),  # Cycles' noise
            0.01,
        )
        for kind in ("camera", "diffuse", "glossy", "shadow")
    ),
    *(
        Case(f"bounces of a lamp: {n}", limit(n), white_floor, note="of larger lamps Cycles limits the sampling alone")
        for n in (0, 1)
    ),
    *(
        Case(f"holdout, {what}{', transparent film' if film else ''}", hold_out(film), setup)
        for what, setup in (("opaque", opaque), ("alpha 0.4", half_transparent))
        for film in (False, True)
    ),
    Case("indirect-only collection", indirect_only),
    Case("transparent film, before it glass", transparent_film),
)
