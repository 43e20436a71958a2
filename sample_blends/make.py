# SPDX-License-Identifier: GPL-3.0-or-later
"""Make the sample scenes: ``python sample_blends/make.py [name ...]``, all of them without a name.

Needs the bpy module. The files in the repository were made with bpy 4.2, so that every Blender from 4.2 on opens them.
"""

from __future__ import annotations

import math
import sys
from pathlib import Path

import bpy
import numpy as np
from mathutils import Matrix
from parts import (
    CUBE_FACES,
    CUBE_VERTICES,
    ball,
    box,
    camera,
    checker,
    coated,
    diffuse,
    emission,
    glass,
    glossy,
    image,
    lathe,
    light,
    link,
    mesh,
    new_file,
    node,
    principled,
    quad,
    save,
    thesis_to_blender,
    world,
)

import zraka

FOLDER = Path(__file__).parent
SCENES = {}


def scene(build):
    """Register a scene under its function's name."""
    SCENES[build.__name__] = build
    return build


# -- Cornell box -------------------------------------------------------------------------------------------------------


@scene
def cornell():
    """The Cornell box, 2 m wide, its light a hole in the ceiling that glows."""
    new_file(512, 512, samples=128, depth=8, about=cornell.__doc__)
    white = diffuse("White", (0.725, 0.71, 0.68))
    red, green = diffuse("Red", (0.63, 0.065, 0.05)), diffuse("Green", (0.14, 0.45, 0.091))
    lamp = emission("Light", (1.0, 0.86, 0.66), 28.0)

    quad("Floor", ((-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)), white)
    quad("Back wall", ((-1, 1, 0), (1, 1, 0), (1, 1, 2), (-1, 1, 2)), white)
    quad("Left wall", ((-1, -1, 0), (-1, 1, 0), (-1, 1, 2), (-1, -1, 2)), red)
    quad("Right wall", ((1, 1, 0), (1, -1, 0), (1, -1, 2), (1, 1, 2)), green)
    xs, ys = (-1.0, -0.235, 0.235, 1.0), (-1.0, -0.19, 0.19, 1.0)
    faces = [(i, i + 4, i + 5, i + 1) for row in (0, 4, 8) for i in range(row, row + 3)]
    slots = [int(face == 4) for face in range(9)]
    ceiling = mesh("Ceiling", [(x, y, 2) for y in ys for x in xs], faces, [white, lamp], material_of_face=slots)
    link("Ceiling", ceiling)

    box("Tall box", (0.6, 0.6, 1.2), (-0.33, 0.37, 0.6), white, rotation_z=18)
    box("Short box", (0.6, 0.6, 0.6), (0.33, -0.28, 0.3), white, rotation_z=-17)
    world((0.0, 0.0, 0.0))
    camera((0, -3.88, 1), (0, 0, 1), fov=38.2)


# -- the scenes of the thesis ------------------------------------------------------------------------------------------

THESIS_OBJECTS = {  # colour, translation, rotation about Y in degrees, scale: of a cube from -1 to 1, Y up
    "Cube 1": ((1.0, 0.2, 0.3), (0, 0, 0), 0, (1, 1, 1)),
    "Cube 2": ((0.2, 0.2, 0.8), (1, 1, 1), 45, (1, 1, 1)),
    "Floor": ((0.2, 0.8, 0.6), (0, -2, 0), 45, (30, 1, 30)),
    "Wall 1": ((1.0, 1.0, 1.0), (0, 0, 5), 0, (10, 10, 1)),
    "Wall 2": ((1.0, 1.0, 1.0), (-5, 0, 0), 0, (1, 10, 10)),
    "Ceiling": ((1.0, 0.0, 0.0), (0, 3.2, 0), 0, (10, 0, 10)),
    "Wall 3": ((1.0, 1.0, 1.0), (0, 0, -5), 0, (10, 10, 1)),
    "Wall 4": ((1.0, 1.0, 1.0), (5, 0, 0), 0, (1, 10, 10)),
}
THESIS_POWER = 200.0  # W

THESIS_TEXT = """
Scene of Davor Najev, "Postupak praćenja zrake i praćenja puta" (FER, Zagreb, 2024): {which}.

Y-up coordinates (x, y, z) became (x, -z, y). {ceiling}
Reflectivity 0.2 is a white glossy share of 0.2 over Lambert reflection, as rough as Phong's exponent 32 is wide:
alpha^2 = 2 / (32 + 2), and Blender's roughness is the root of alpha. The thesis' path tracing is sharper (its roughness
is 0.1). The classic methods take reflectivity, exponent and ambient light from the scene's overrides.
The thesis' light falls off linearly, to nothing at distance 20; Blender's with the square of the distance, and Lambert
reflection divides by pi. Its power, {power:g} W, was chosen so that the pictures look alike: at a distance of 3.5 both
are equally bright (4 pi^2 3.5^2 0.5 (1 - 3.5/20) = 200 W); what is nearer is brighter here, what is farther darker.
"""


FLAT_CEILING = "The ceiling keeps its scale of zero: its sides have no area, its two faces coincide."
THIN_CEILING = """The ceiling is 2 mm thick instead of flat: Cycles shows two faces that coincide black,
and this scene is compared with it."""


def _thesis_scene(which, count, ceiling="", thickness=0.0):
    """The first `count` of the thesis' objects, its light, its sky and its camera."""
    about = THESIS_TEXT.format(which=which, power=THESIS_POWER, ceiling=ceiling)
    new_file(500, 500, samples=64, depth=5, about=about, reflectivity=0.2, exponent=32.0, ambient=0.2)
    for name, (color, (x, y, z), angle, (sx, sy, sz)) in list(THESIS_OBJECTS.items())[:count]:
        sy = sy or thickness
        data = mesh(name, CUBE_VERTICES, CUBE_FACES, [coated(name, color, 0.2, (2 / 34) ** 0.25)])
        link(name, data, (x, -z, y), (0, 0, angle), (sx, sz, sy))
    light("Light", "POINT", THESIS_POWER, (0, 0.5, 3.1), color=(0.5, 1.0, 1.0), shadow_soft_size=0.0)
    world((0.3, 0.4, 1.0))
    turn = Matrix.Rotation(math.radians(145), 4, "Y") @ Matrix.Rotation(math.radians(-30), 4, "X")
    camera((0, 0, 0), fov=70, matrix=thesis_to_blender((3, 3, -3), turn))


@scene
def thesis():
    """Cubes, floor, two walls and the ceiling."""
    _thesis_scene("two cubes, floor, two walls and the ceiling", 6, FLAT_CEILING)


@scene
def room_open():
    """Cubes and floor."""
    _thesis_scene("two cubes and the floor", 3)


@scene
def room_closed():
    """All eight: no ray escapes."""
    _thesis_scene("all eight, so that no ray escapes", 8, THIN_CEILING, 0.001)


# -- Whitted's spheres -------------------------------------------------------------------------------------------------


@scene
def whitted():
    """A glass and a mirror sphere over a checker floor, after Turner Whitted's picture of 1980."""
    new_file(640, 360, samples=256, depth=10, about=whitted.__doc__, ambient=0.1)
    floor = checker("Checker", (0.75, 0.06, 0.04), (0.85, 0.72, 0.12), 16.0)
    quad("Floor", ((-8, -4, 0), (8, -4, 0), (8, 12, 0), (-8, 12, 0)), floor, uv_scale=(1, 1))
    ball("Glass ball", 1.0, (-0.35, -0.1, 1.75), glass("Glass", 1.5))
    ball("Mirror ball", 1.1, (1.35, 1.9, 1.25), glossy("Mirror", (0.9, 0.9, 0.92)))
    ball("Blue ball", 0.45, (-1.9, 1.2, 0.45), diffuse("Blue", (0.05, 0.15, 0.6)))
    light("Light", "AREA", 900, (-5, -4, 8), (0, 1, 0.5), color=(1.0, 0.95, 0.85), shape="SQUARE", size=4.0)
    world((0.22, 0.45, 0.9), 0.8)
    camera((-0.2, -6.6, 2.5), (0.1, 0.3, 1.35), fov=46)


# -- interior ----------------------------------------------------------------------------------------------------------


def _noise(rng, height, width, octaves):
    """Smooth noise in [0, 1] that tiles: octaves of cosine-interpolated random grids."""
    total = np.zeros((height, width))
    for cells_y, cells_x, weight in octaves:
        grid = rng.random((cells_y, cells_x))
        y, x = np.arange(height) * cells_y / height, np.arange(width) * cells_x / width
        fy, fx = (0.5 - 0.5 * np.cos(np.pi * (v % 1)) for v in (y, x))
        y0, x0 = y.astype(int), x.astype(int)
        y1, x1 = (y0 + 1) % cells_y, (x0 + 1) % cells_x
        low = grid[np.ix_(y0, x0)] * (1 - fx) + grid[np.ix_(y0, x1)] * fx
        high = grid[np.ix_(y1, x0)] * (1 - fx) + grid[np.ix_(y1, x1)] * fx
        total += weight * (low * (1 - fy[:, None]) + high * fy[:, None])
    return total / sum(weight for *_, weight in octaves)


def _planks(rng, size=256, rows=8):
    """Floor boards: each with its own tone, grain along it and a dark gap."""
    grain = _noise(rng, size, size, ((64, 4, 1.0), (128, 8, 0.6), (16, 2, 1.0)))
    y, x = np.mgrid[:size, :size]
    row = y * rows // size
    board = (x + rng.integers(0, size, rows)[row]) % size
    tone = 0.75 + 0.5 * rng.random((rows, 2))[row, board * 2 // size]
    gap = ((y * rows % size) < rows * 1.5) | (board % (size // 2) < 1.5)
    shade = (0.55 + 0.6 * grain) * tone * np.where(gap, 0.35, 1.0)
    return shade[..., None] * np.array((0.62, 0.43, 0.27))


def _tiles(rng, size=256, count=4):
    """Blue and white wall tiles with a quarter circle pattern and light joints."""
    y, x = np.mgrid[:size, :size] * count / size
    u, v = x % 1, y % 1
    flip = (np.floor(x) + np.floor(y)) % 2 == 0
    radius = np.hypot(np.where(flip, u, 1 - u), v)
    blue = (abs(radius - 0.62) < 0.12) | (radius < 0.2)
    joint = (np.minimum(u, v) < 0.03) | (np.maximum(u, v) > 0.97)
    glaze = 0.92 + 0.08 * _noise(rng, size, size, ((16, 16, 1.0),))
    color = np.where(blue[..., None], (0.2, 0.36, 0.58), (0.88, 0.87, 0.82)) * glaze[..., None]
    return np.where(joint[..., None], (0.7, 0.68, 0.64), color)


def _painting(width=192, height=128):
    """A sunset over hills."""
    y, x = np.mgrid[:height, :width] / (height - 1)
    color = np.stack((0.35 + 0.62 * (1 - y), 0.3 + 0.25 * (1 - y), 0.35 + 0.35 * y), axis=-1)
    color[np.hypot(x - 0.95, y - 0.55) < 0.13] = (1.0, 0.86, 0.5)
    far, middle, near = (0.4, 0.25, 0.38), (0.24, 0.2, 0.32), (0.1, 0.13, 0.2)
    for base, swing, waves, tone in ((0.5, 0.09, 5, far), (0.36, 0.07, 8, middle), (0.2, 0.06, 11, near)):
        color[y < base + swing * np.sin(waves * x + 9 * base)] = tone
    return color


@scene
def interior():
    """A room with image textures, lit through its window."""
    new_file(640, 360, samples=256, depth=8, view="AgX", about=interior.__doc__)
    rng = np.random.default_rng(7)
    wood = principled("Boards", image("boards", _planks(rng)), roughness=0.35)
    tiles = principled("Tiles", image("tiles", _tiles(rng)), roughness=0.2)
    picture = principled("Picture", image("picture", _painting()), roughness=0.6)
    plaster = principled("Plaster", (0.8, 0.76, 0.69), roughness=0.9)
    oak = principled("Oak", (0.42, 0.24, 0.12), roughness=0.4)
    cloth = principled("Cloth", (0.5, 0.12, 0.08), roughness=0.85)
    linen = principled("Linen", (0.75, 0.7, 0.6), roughness=0.9)

    quad("Floor", ((-2.5, -3, 0), (2.5, -3, 0), (2.5, 2, 0), (-2.5, 2, 0)), wood, (3, 3))
    quad("Ceiling", ((-2.5, 2, 2.7), (2.5, 2, 2.7), (2.5, -3, 2.7), (-2.5, -3, 2.7)), plaster)
    quad("Back wall", ((-2.5, 2, 1.1), (2.5, 2, 1.1), (2.5, 2, 2.7), (-2.5, 2, 2.7)), plaster)
    quad("Tiled wall", ((-2.5, 2, 0), (2.5, 2, 0), (2.5, 2, 1.1), (-2.5, 2, 1.1)), tiles, (5, 1.1))
    quad("Right wall", ((2.5, 2, 0), (2.5, -3, 0), (2.5, -3, 2.7), (2.5, 2, 2.7)), plaster)
    quad("Front wall", ((2.5, -3, 0), (-2.5, -3, 0), (-2.5, -3, 2.7), (2.5, -3, 2.7)), plaster)
    ys, zs = (-3.0, -0.7, 1.3, 2.0), (0.0, 0.8, 2.3, 2.7)
    faces = [(i, i + 1, i + 5, i + 4) for row in (0, 4, 8) for i in range(row, row + 3) if row + i != 9]
    left = mesh("Window wall", [(-2.5, y, z) for z in zs for y in ys], faces, [plaster])
    link("Window wall", left)
    for name, size, at in (
        ("Sill", (0.3, 2.1, 0.05), (-2.48, 0.3, 0.78)),
        ("Mullion", (0.06, 0.06, 1.5), (-2.5, 0.3, 1.55)),
        ("Transom", (0.06, 2.0, 0.06), (-2.5, 0.3, 1.75)),
    ):
        box(name, size, at, linen)

    box("Table top", (1.5, 0.8, 0.05), (0.1, 0.45, 0.74), oak)
    for number, (x, y) in enumerate(((-0.57, 0.13), (0.77, 0.13), (-0.57, 0.77), (0.77, 0.77)), 1):
        box(f"Table leg {number}", (0.07, 0.07, 0.715), (x, y, 0.3575), oak)
    box("Sofa seat", (0.85, 1.7, 0.42), (1.95, 0.2, 0.21), cloth)
    box("Sofa back", (0.25, 1.7, 0.85), (2.32, 0.2, 0.425), cloth)
    box("Cushion", (0.16, 0.45, 0.42), (2.1, 0.62, 0.64), linen, rotation_z=14)
    box("Rug", (2.4, 1.5, 0.012), (0.1, -0.3, 0.006), linen)
    box("Frame", (1.36, 0.05, 0.92), (0.1, 1.97, 1.85), oak)
    quad("Picture", ((-0.54, 1.94, 1.43), (0.74, 1.94, 1.43), (0.74, 1.94, 2.27), (-0.54, 1.94, 2.27)), picture, (1, 1))
    brass = principled("Brass", (0.85, 0.6, 0.25), roughness=0.25, metallic=1.0)
    glaze = principled("Glaze", (0.1, 0.35, 0.33), roughness=0.12)
    radii = (0.0, 0.07, 0.1, 0.125, 0.12, 0.08, 0.05, 0.055, 0.075, 0.06, 0.0)
    heights = (0.0, 0.0, 0.03, 0.1, 0.17, 0.24, 0.29, 0.33, 0.35, 0.34, 0.3)
    lathe("Vase", list(zip(radii, heights, strict=True)), (-0.25, 0.45, 0.766), glaze)
    ball("Brass ball", 0.11, (0.3, 0.38, 0.876), brass, levels=4)

    daylight = {"shape": "RECTANGLE", "size": 1.9, "size_y": 1.4}
    light("Window", "AREA", 110, (-2.65, 0.3, 1.55), (0.0, 0.3, 1.1), (1.0, 0.93, 0.82), **daylight)
    world((0.55, 0.7, 1.0), 1.0)
    camera((0.35, -2.9, 1.45), (0.05, 0.6, 1.12), fov=68)


# -- many --------------------------------------------------------------------------------------------------------------


@scene
def many():
    """A sunflower's spiral of 10,000 instances, made by geometry nodes from five small meshes."""
    new_file(640, 360, samples=128, depth=5, view="AgX", about=many.__doc__)
    kinds = bpy.data.collections.new("Seeds")
    colors = ((0.85, 0.3, 0.05), (0.8, 0.55, 0.06), (0.75, 0.1, 0.08), (0.9, 0.75, 0.4), (0.15, 0.35, 0.4))
    for number, color in enumerate(colors):
        data = _prism(f"Seed {number}", 4 + number, principled(f"Seed {number}", color, roughness=0.4))
        kinds.objects.link(bpy.data.objects.new(data.name, data))
    carrier = link("Spiral", mesh("Spiral", [(0, 0, 0)], []))
    carrier.modifiers.new("Spiral", "NODES").node_group = _spiral(kinds, 10000)
    quad("Ground", ((-60, -60, 0), (60, -60, 0), (60, 60, 0), (-60, 60, 0)), diffuse("Ground", (0.3, 0.27, 0.22)))
    light("Sun", "SUN", 3.5, (0, 0, 10), (-6, 3, 5.5), (1.0, 0.9, 0.75), angle=math.radians(1.5))
    world((0.35, 0.5, 0.8), 0.7)
    camera((0, -19.5, 11.5), (0, -0.9, 0), fov=42)


def _prism(name, sides, material):
    """A small pointed prism."""
    ring = [(math.cos(2 * math.pi * i / sides), math.sin(2 * math.pi * i / sides)) for i in range(sides)]
    vertices = [(0.1 * x, 0.1 * y, 0) for x, y in ring] + [(0.12 * x, 0.12 * y, 0.5) for x, y in ring] + [(0, 0, 0.66)]
    faces = [(i, (i + 1) % sides, sides + (i + 1) % sides, sides + i) for i in range(sides)]
    faces += [(sides + i, sides + (i + 1) % sides, 2 * sides) for i in range(sides)]
    return mesh(name, vertices, faces, [material])


def _spiral(kinds, count):
    """Geometry nodes: `count` instances at golden angles, the pieces of `kinds` by turns, heights in waves."""
    tree = bpy.data.node_groups.new("Spiral", "GeometryNodeTree")
    tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")

    def math_node(operation, a, b=0.0):
        return node(tree, "ShaderNodeMath", properties={"operation": operation}, _0=a, _1=b)

    index = node(tree, "GeometryNodeInputIndex")
    angle = math_node("MULTIPLY", index, math.pi * (3 - math.sqrt(5)))
    radius = math_node("MULTIPLY", math_node("SQRT", index), 0.115)
    x = math_node("MULTIPLY", radius, math_node("COSINE", angle))
    y = math_node("MULTIPLY", radius, math_node("SINE", angle))
    place = node(tree, "ShaderNodeCombineXYZ", X=x, Y=y)
    wave = math_node("SINE", math_node("MULTIPLY", radius, 1.35))
    height = math_node("MULTIPLY_ADD", wave, 0.9)
    height.node.inputs[2].default_value = 1.5
    points = node(tree, "GeometryNodePoints", Count=count, Position=place)
    pieces = node(
        tree,
        "GeometryNodeCollectionInfo",
        Separate_Children=True,
        Reset_Children=True,
    )
    pieces.node.inputs["Collection"].default_value = kinds
    instances = node(
        tree,
        "GeometryNodeInstanceOnPoints",
        Points=points,
        Instance=pieces,
        Pick_Instance=True,
        Instance_Index=index,
        Rotation=node(tree, "ShaderNodeCombineXYZ", Z=angle),
        Scale=node(tree, "ShaderNodeCombineXYZ", X=1.0, Y=1.0, Z=height),
    )
    tree.links.new(instances, tree.nodes.new("NodeGroupOutput").inputs[0])
    return tree


# -- analytic primitives -----------------------------------------------------------------------------------------------


@scene
def spheres():
    """Point clouds, which are exact spheres, over an infinite plane (an Empty; Cycles does not show it)."""
    new_file(640, 360, samples=128, depth=8, about=spheres.__doc__, ambient=0.1)
    colors = ((0.8, 0.2, 0.12), (0.85, 0.6, 0.1), (0.1, 0.45, 0.35), (0.15, 0.25, 0.6))
    rng = np.random.default_rng(3)
    placed = [(0.0, 0.0, 1.0), (-2.1, 0.5, 0.8), (1.95, 0.35, 0.75)]
    cloud("Mirror", placed[:1], glossy("Mirror", (0.92, 0.92, 0.92)))
    cloud("Glass", placed[1:2], glass("Glass", 1.5))
    cloud("Brass", placed[2:], glossy("Brass", (0.9, 0.62, 0.25), 0.3))
    groups = [[] for _ in colors]
    for _ in range(4000):
        radius = 0.09 + 0.26 * rng.random() ** 2
        x, y = rng.uniform(-4.6, 4.6), rng.uniform(-2.6, 5.5)
        clear = all((x - a) ** 2 + (y - b) ** 2 + (radius - c) ** 2 > (radius + c + 0.02) ** 2 for a, b, c in placed)
        if clear and len(placed) < 170:
            groups[len(placed) % len(colors)].append((x, y, radius))
            placed.append((x, y, radius))
    for number, (group, color) in enumerate(zip(groups, colors, strict=True), 1):
        cloud(f"Pebbles {number}", group, diffuse(f"Pebbles {number}", color))
    ground = link("Infinite plane", None)
    ground.empty_display_type, ground.empty_display_size = "IMAGE", 4.0
    ground.zraka.plane = True
    ground.zraka.plane_material = diffuse("Ground", (0.55, 0.53, 0.5))
    light("Light", "AREA", 800, (-4, -5, 7), (0, 0.5, 0.5), (1.0, 0.95, 0.88), shape="DISK", size=2.5)
    world((0.4, 0.55, 0.85), 0.7)
    camera((0, -7.2, 2.9), (0, 0.4, 0.7), fov=44)


def cloud(name, balls, material):
    """A point cloud of spheres that rest on the ground at (x, y), given as (x, y, radius)."""
    data = mesh(name, [(x, y, radius) for x, y, radius in balls], [], [material])
    data.attributes.new("size", "FLOAT", "POINT").data.foreach_set("value", [radius for *_, radius in balls])
    thing = link(name, data)
    tree = bpy.data.node_groups.new(name, "GeometryNodeTree")
    for in_out in ("INPUT", "OUTPUT"):
        tree.interface.new_socket("Geometry", in_out=in_out, socket_type="NodeSocketGeometry")
    size = node(tree, "GeometryNodeInputNamedAttribute", properties={"data_type": "FLOAT"}, Name="size")
    vertices = tree.nodes.new("NodeGroupInput").outputs[0]
    points = node(tree, "GeometryNodeMeshToPoints", Mesh=vertices, Radius=size)
    painted = node(tree, "GeometryNodeSetMaterial", Geometry=points, Material=material)
    tree.links.new(painted, tree.nodes.new("NodeGroupOutput").inputs[0])
    thing.modifiers.new("Spheres", "NODES").node_group = tree
    return thing


def main(names):
    """Make the scenes called `names`, or all."""
    unknown = [name for name in names if name not in SCENES]
    if unknown:
        sys.exit(f"unknown scene {unknown[0]!r}; choose from {', '.join(SCENES)}")
    for name in names or SCENES:
        SCENES[name]()
        save(FOLDER / f"{name}.blend")
    zraka.unregister()  # the bpy module of Blender 4.2 crashes at its end over classes that stay registered


if __name__ == "__main__":
    main(sys.argv[1:])
