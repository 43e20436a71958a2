# SPDX-License-Identifier: GPL-3.0-or-later
"""What a caller describes: plain frozen dataclasses over numpy arrays.

A scene is written down here without Blender and without any renderer state; `core.compile` turns it into the tables
that the methods read. World space is right-handed, Z up, units are Blender's (metres, watts). Objects are compared by
identity, so one `Mesh` or `Material` shared by many instances is stored once.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from .camera_description import Camera, Panorama, ThinLens  # noqa: F401 - words of a scene
from .geometry_description import Attribute, ObjectInfo, TextureSpace
from .light_description import AreaLight, LampNodes, Light, PointLight, SpotLight, SunLight  # noqa: F401 - words of a scene
from .visibility import SEEN_BY_ALL, Visibility

IDENTITY = np.eye(4)


# -- materials ---------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Link:
    """An input that takes its value from output `output` of node number `node` of the same graph."""

    node: int
    output: str


@dataclass(frozen=True, eq=False)
class Node:
    """One node of a material graph.

    Parameters
    ----------
    op : str
        Name of the operation in `core.nodes` or of the closure, e.g. ``"principled"``, ``"image"``.
    inputs : mapping of str to Link, float or tuple of float
        Input by name; what is missing takes the operation's default.
    properties : mapping
        What cannot be linked: enums, images, flags.
    """

    op: str
    inputs: Mapping[str, Link | float | tuple] = field(default_factory=dict)
    properties: Mapping[str, object] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Image:
    """Pixels of a texture.

    Parameters
    ----------
    name : str
        Said in diagnostics.
    pixels : (H, W, C) uint8, uint16, float16 or float32, or None
        Row 0 is the bottom row, colours as stored (not yet linear); grey, grey and alpha, RGB or RGBA. None: read
        `filepath`.
    filepath : str
        Absolute path, read by OpenImageIO when `pixels` is None.
    colorspace : str
        Blender's name of the colour space: ``"sRGB"``, ``"Non-Color"``, ``"Linear Rec.709"``...
    alpha_mode : {"AUTO", "STRAIGHT", "PREMUL", "CHANNEL_PACKED", "NONE"}
        Whether colours are stored times alpha. AUTO: not those of `pixels`, those of a file as its header tells;
        CHANNEL_PACKED: alpha has nothing to do with them; NONE: alpha is taken to be 1.
    color_configuration : str
        Path of the OpenColorIO configuration that defines `colorspace`; not needed for the three spaces above.
    linear_first : bool
        Whether sRGB texels are made linear before they are looked up and not after, as in Cycles where the colours of
        a file are not in Linear Rec.709; this takes `color_configuration`.
    nearest : bool
        Whether half floats are rounded to the nearest, as in Cycles since 5.1, and not towards 0.
    tiles : mapping of int to Image
        UDIM tiles by number, from 1001 on; `pixels` and `filepath` are then not read.
    """

    name: str
    pixels: np.ndarray | None = None
    filepath: str = ""
    colorspace: str = "sRGB"
    alpha_mode: str = "AUTO"
    color_configuration: str = ""
    linear_first: bool = False
    nearest: bool = False
    tiles: Mapping[int, Image] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Material:
    """A surface: a graph of nodes and the number of the closure node that reaches the output.

    `surface` is None for a material without a surface shader (it renders black, as in Blender). `displacement` is the
    vector by which its surface is moved, shown as a turned normal; `displacement_step` tells from heights how far
    apart, in footprints of a pixel. `index` is a number that nodes can read. `aovs` are (name, colour, value) that it
    tells besides, each a `Link` or a constant. `bump_correction` softens diffuse reflection on turned normals, and
    raises those of other lobes until they mirror the viewer's ray to above the surface. `older` names what is done on
    turned normals as by an older Blender: ``"softening"`` (before 4.5) by another formula, ``"strands"`` (before 5.0)
    as on other surfaces.
    """

    name: str
    nodes: tuple[Node, ...] = ()
    surface: int | None = None
    displacement: Link | None = None
    index: int = 0
    displacement_step: float = 0.1
    aovs: tuple[tuple, ...] = ()
    bump_correction: bool = True
    older: tuple[str, ...] = ()

    @property
    def side_links(self):
        """Links that end neither at a node nor at the surface."""
        values = (self.displacement, *(value for _, *pair in self.aovs for value in pair))
        return [value for value in values if isinstance(value, Link)]

    @classmethod
    def single(cls, op, name=None, **inputs):
        """Material of one closure node, e.g. ``Material.single("diffuse", color=(.8, .2, .1))``."""
        return cls(name or op, (Node(op, inputs),), 0)

    @classmethod
    def diffuse(cls, color=(0.8, 0.8, 0.8), name="diffuse"):
        """Lambert reflection of albedo `color`."""
        return cls.single("diffuse", name, color=_rgb(color))

    @classmethod
    def emission(cls, color=(1.0, 1.0, 1.0), strength=1.0, name="emission"):
        """Surface that emits radiance `color * strength` on both sides and reflects nothing."""
        return cls.single("emission", name, color=_rgb(color), strength=float(strength))

    @classmethod
    def glossy(cls, color=(0.8, 0.8, 0.8), roughness=0.0, name="glossy"):
        """Mirror or GGX reflection; `roughness` is Blender's (alpha is its square)."""
        return cls.single("glossy", name, color=_rgb(color), roughness=float(roughness))

    @classmethod
    def glass(cls, color=(1.0, 1.0, 1.0), roughness=0.0, ior=1.5, name="glass"):
        """Dielectric boundary, reflection and refraction."""
        return cls.single("glass", name, color=_rgb(color), roughness=float(roughness), ior=float(ior))

    @classmethod
    def principled(cls, name="principled", **inputs):
        """Blender's Principled BSDF; `inputs` as in `core.nodes`, e.g. ``base_color=``, ``metallic=``."""
        return cls.single("principled", name, **inputs)

    @classmethod
    def glowing(cls, color, emission, name="glowing"):
        """Lambert reflection of albedo `color` plus emitted radiance `emission`."""
        nodes = (
            Node("diffuse", {"color": _rgb(color)}),
            Node("emission", {"color": _rgb(emission), "strength": 1.0}),
            Node("add_shader", {"a": Link(0, "bsdf"), "b": Link(1, "bsdf")}),
        )
        return cls(name, nodes, 2)


# -- geometry ----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Mesh:
    """Triangles in object space.

    Parameters
    ----------
    vertices : (V, 3) float32
    triangles : (T, 3) int32 or uint32
        Vertex numbers, counter-clockwise seen from the front.
    corners : (T, 3) uint32, optional
        Where a triangle's corners stand in per-corner arrays; None means ``3 * t + k``.
    normals : (V, 3) or (C, 3) float32, optional
        Shading normals; None is flat.
    normals_domain : {"vertex", "corner"}
    uvs : mapping of str to (C, 2) float32
        UV maps, per corner.
    active_uv : str
        The map used where none is named; "" is the first.
    material_index : (T,) int32, optional
        Slot of each triangle; None is slot 0.
    texture_space : TextureSpace, optional
        None is the bounding box of the vertices.
    attributes : mapping of str to Attribute
    active_color : str
        The colour attribute that is read where none is named.
    edges : (E, 2) int32, optional
        Vertex numbers; None takes the sides of the triangles.
    """

    vertices: np.ndarray
    triangles: np.ndarray
    corners: np.ndarray | None = None
    normals: np.ndarray | None = None
    normals_domain: str = "vertex"
    uvs: Mapping[str, np.ndarray] = field(default_factory=dict)
    active_uv: str = ""
    material_index: np.ndarray | None = None
    name: str = "mesh"
    texture_space: TextureSpace | None = None
    attributes: Mapping[str, Attribute] = field(default_factory=dict)
    active_color: str = ""
    edges: np.ndarray | None = None


@dataclass(frozen=True, eq=False)
class Instance:
    """A mesh placed in the world; `materials[slot]` of each triangle, the last slot when out of range.

    `transform` is a (4, 4) float64 matrix, object to world. No materials, or None in a slot, is Blender's default grey.
    """

    mesh: Mesh
    transform: np.ndarray = field(default_factory=lambda: IDENTITY)
    materials: tuple[Material | None, ...] = ()
    name: str = "object"
    info: ObjectInfo = field(default_factory=ObjectInfo)
    visibility: Visibility = SEEN_BY_ALL


@dataclass(frozen=True, eq=False)
class Spheres:
    """Analytic spheres in world space: `centers` (N, 3), `radii` (N,).

    `attributes` are of the domains "vertex" (N rows) or "mesh".
    """

    centers: np.ndarray
    radii: np.ndarray
    material: Material | None = None
    name: str = "spheres"
    info: ObjectInfo = field(default_factory=ObjectInfo)
    attributes: Mapping[str, Attribute] = field(default_factory=dict)
    visibility: Visibility = SEEN_BY_ALL


@dataclass(frozen=True, eq=False)
class Curves:
    """Strands in object space: tubes around Catmull-Rom splines, as Blender draws hair.

    Parameters
    ----------
    points : (N, 3) float32
        Of all strands, from root to tip, one strand after the other; each goes through its first and last point.
    radii : (N,) float32
    counts : (S,) int
        Points of each strand; those with fewer than two are left out.
    transform : (4, 4) float64
        Object to world. Radii take its mean scale.
    uvs : mapping of str to (S, 2) float32
        Where the strands are rooted, by UV map of the surface they grow on.
    active_uv : str
        The map used where none is named; "" is the first.
    attributes : mapping of str to Attribute
        Of the domains "vertex" (N rows), "strand" (S rows) or "mesh".
    texture_space : TextureSpace, optional
        In which the roots have generated coordinates; None is the bounding box of the points.
    """

    points: np.ndarray
    radii: np.ndarray
    counts: np.ndarray
    transform: np.ndarray = field(default_factory=lambda: IDENTITY)
    material: Material | None = None
    name: str = "curves"
    info: ObjectInfo = field(default_factory=ObjectInfo)
    uvs: Mapping[str, np.ndarray] = field(default_factory=dict)
    active_uv: str = ""
    attributes: Mapping[str, Attribute] = field(default_factory=dict)
    texture_space: TextureSpace | None = None
    visibility: Visibility = SEEN_BY_ALL


@dataclass(frozen=True, eq=False)
class Plane:
    """An infinite plane through `point`, its front where `normal` points."""

    point: tuple[float, float, float]
    normal: tuple[float, float, float]
    material: Material | None = None
    name: str = "plane"
    info: ObjectInfo = field(default_factory=ObjectInfo)
    visibility: Visibility = SEEN_BY_ALL


# -- light from infinity -----------------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class World:
    """Light from infinity: constant `radiance` (3,), or a graph over directions.

    `surface` is the number of the graph's closure node; None, as of all constant worlds, lets `radiance` count. `aovs`
    are as those of a `Material`.
    """

    radiance: tuple[float, float, float] = (0.0, 0.0, 0.0)
    nodes: tuple[Node, ...] = ()
    surface: int | None = None
    name: str = "world"
    visibility: Visibility = SEEN_BY_ALL
    aovs: tuple[tuple, ...] = ()

    @classmethod
    def textured(cls, image, strength=1.0, projection="EQUIRECTANGULAR", interpolation="Linear", name="world"):
        """World that shows an `Image` of all directions."""
        properties = {"image": image, "projection": projection, "interpolation": interpolation}
        nodes = (
            Node("environment", {}, properties),
            Node("background", {"color": Link(0, "color"), "strength": float(strength)}),
        )
        return cls(nodes=nodes, surface=1, name=name)


# -- the whole ---------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Scene:
    """Everything that is rendered."""

    camera: Camera
    instances: tuple[Instance, ...] = ()
    spheres: tuple[Spheres, ...] = ()
    planes: tuple[Plane, ...] = ()
    lights: tuple[Light, ...] = ()
    world: World = field(default_factory=World)
    curves: tuple[Curves, ...] = ()

    @property
    def objects(self):
        """All that can be hit, in the order in which objects are numbered."""
        return (*self.instances, *self.spheres, *self.curves, *self.planes)


def _rgb(color):
    """A grey number or three numbers as a tuple of three floats."""
    values = np.broadcast_to(np.asarray(color, dtype=float), (3,))
    return tuple(float(v) for v in values)
