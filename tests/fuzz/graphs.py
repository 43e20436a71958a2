# SPDX-License-Identifier: GPL-3.0-or-later
"""Random node graphs over all operations and closures of the core."""

from __future__ import annotations

import numpy as np

from zraka.core.nodes import OPERATIONS
from zraka.core.nodes.closures import CLOSURES
from zraka.core.scene import Image, Link, Node

# What the compiler alone puts in.
_COVERS = ["principled_cover", "principled_cover_4", "principled_cover_uncorrected", "principled_cover_4_uncorrected"]
INTERNAL = {"add", "multiply", "clamp", "complement", "displaced_normal", *_COVERS}
VALUES = sorted(set(OPERATIONS) - INTERNAL)
SURFACES = sorted(CLOSURES)
# Operations whose results stay of the size of what they read.
_WILD = ("light_falloff", "map_range_float", "map_range_float_vector", "gamma", "ies", "image", "environment")
TAME = [name for name in VALUES if not name.startswith(("math_", "vector_math_")) and name not in _WILD]
TAME_SURFACES = sorted(set(SURFACES) - {"volume"})

_BLENDS = "MIX DARKEN MULTIPLY BURN LIGHTEN SCREEN DODGE ADD OVERLAY SOFT_LIGHT LINEAR_LIGHT DIFFERENCE EXCLUSION"
_BLENDS = (*_BLENDS.split(), "SUBTRACT", "DIVIDE", "HUE", "SATURATION", "COLOR", "VALUE")
_SPACES = ("WORLD", "OBJECT", "CAMERA")
_FLAG = (False, True)

# By operation, properties and what they may be; a missing property is left out as often as not.
PROPERTIES = {
    "convert": {"from": ("color", "vector", "float"), "to": ("color", "vector", "float", "int", "bool")},
    "uv_map": {"uv_map": ("", "uv", "nowhere"), "from_instancer": _FLAG},
    "tex_coord": {"from_instancer": _FLAG, "matrix": (tuple(np.eye(4).ravel().tolist()), (0.0,) * 16)},
    "mapping": {"vector_type": ("POINT", "TEXTURE", "VECTOR", "NORMAL")},
    "image": {
        "projection": ("FLAT", "BOX", "SPHERE", "TUBE"),
        "projection_blend": (0.0, 0.3, 1.0),
        "interpolation": ("Linear", "Closest", "Cubic", "Smart"),
        "extension": ("REPEAT", "EXTEND", "CLIP", "MIRROR"),
    },
    "environment": {"projection": ("EQUIRECTANGULAR", "MIRROR_BALL"), "interpolation": ("Linear", "Closest", "Cubic")},
    "voronoi": {
        "voronoi_dimensions": ("1D", "2D", "3D", "4D"),
        "feature": ("F1", "F2", "SMOOTH_F1", "DISTANCE_TO_EDGE", "N_SPHERE_RADIUS"),
        "distance": ("EUCLIDEAN", "MANHATTAN", "CHEBYCHEV", "MINKOWSKI"),
        "normalize": _FLAG,
    },
    "brick": {
        "offset": (0.0, 0.5, 1.0),
        "offset_frequency": (1, 2, 99),
        "squash": (0.0, 1.0, 99.0),
        "squash_frequency": (1, 2, 99),
    },
    "gabor": {"gabor_type": ("2D", "3D")},
    "gradient": {
        "gradient_type": ("LINEAR", "QUADRATIC", "EASING", "DIAGONAL", "RADIAL", "SPHERICAL", "QUADRATIC_SPHERE")
    },
    "magic": {"turbulence_depth": (0, 1, 2, 10)},
    "noise": {
        "noise_dimensions": ("1D", "2D", "3D", "4D"),
        "noise_type": ("FBM", "MULTIFRACTAL", "HETERO_TERRAIN", "HYBRID_MULTIFRACTAL", "RIDGED_MULTIFRACTAL"),
        "normalize": _FLAG,
    },
    "wave": {
        "wave_type": ("BANDS", "RINGS"),
        "bands_direction": ("X", "Y", "Z", "DIAGONAL"),
        "rings_direction": ("X", "Y", "Z", "SPHERICAL"),
        "wave_profile": ("SIN", "SAW", "TRI"),
    },
    "white_noise": {"noise_dimensions": ("1D", "2D", "3D", "4D")},
    "clamp_range": {"clamp_type": ("MINMAX", "RANGE")},
    "combine_color": {"mode": ("RGB", "HSV", "HSL")},
    "separate_color": {"mode": ("RGB", "HSV", "HSL")},
    "map_range_float": {"clamp": _FLAG, "interpolation_type": ("LINEAR", "STEPPED", "SMOOTHSTEP", "SMOOTHERSTEP")},
    "mix_rgba": {"blend_type": _BLENDS, "clamp_factor": _FLAG, "clamp_result": _FLAG},
    "mix_float": {"clamp_factor": _FLAG},
    "mix_vector": {"clamp_factor": _FLAG},
    "vector_transform": {
        "vector_type": ("VECTOR", "POINT", "NORMAL"),
        "convert_from": _SPACES,
        "convert_to": _SPACES,
    },
    "attribute": {
        "attribute_type": ("GEOMETRY", "OBJECT", "INSTANCER", "VIEW_LAYER"),
        "attribute_name": ("", "heat", "uv", "nowhere"),
    },
    "vertex_color": {"layer_name": ("", "heat", "nowhere")},
    "texture_mapping": {"coordinates": ("generated", "uv"), "normalize": _FLAG},
    "bump": {"invert": _FLAG},
    "displacement": {"space": ("OBJECT", "WORLD")},
    "vector_displacement": {"space": ("TANGENT", "OBJECT", "WORLD")},
    "tangent": {"direction_type": ("RADIAL", "UV_MAP"), "axis": ("X", "Y", "Z"), "uv_map": ("", "uv", "nowhere")},
    "wireframe": {"use_pixel_size": _FLAG},
    "normal_map": {
        "space": ("TANGENT", "OBJECT", "WORLD", "BLENDER_OBJECT", "BLENDER_WORLD"),
        "uv_map": ("", "uv", "nowhere"),
        "convention": ("OPENGL", "DIRECTX"),
    },
    "sky": {
        "sky_type": ("PREETHAM", "HOSEK_WILKIE", "SINGLE_SCATTERING", "MULTIPLE_SCATTERING", "NISHITA"),
        "turbidity": (1.0, 2.2, 10.0),
        "ground_albedo": (0.0, 0.3, 1.0),
        "sun_direction": ((0.0, 0.0, 1.0), (0.0, 0.0, 0.0), (1.0, 0.0, -1.0)),
        "sun_elevation": (-1.6, 0.0, 0.3, 1.57),
        "sun_size": (0.0, 0.01, 1.5),
        "sun_disc": _FLAG,
        "altitude": (0.0, 100.0, 60000.0),
        "air_density": (0.0, 1.0, 10.0),
    },
    "vector_rotate_axis_angle": {"invert": _FLAG},
    "vector_rotate_euler_xyz": {"invert": _FLAG},
    "vector_rotate_x_axis": {"invert": _FLAG},
    "sheen": {"distribution": ("ASHIKHMIN", "MICROFIBER")},
    "toon": {"component": ("DIFFUSE", "GLOSSY")},
    "metallic": {
        "distribution": ("BECKMANN", "GGX", "MULTI_GGX"),
        "fresnel_type": ("PHYSICAL_CONDUCTOR", "F82"),
    },
    "glossy": {"distribution": ("BECKMANN", "GGX", "ASHIKHMIN_SHIRLEY", "MULTI_GGX")},
    "glass": {"distribution": ("BECKMANN", "GGX", "MULTI_GGX")},
    "refraction": {"distribution": ("BECKMANN", "GGX")},
    "principled": {"distribution": ("GGX", "MULTI_GGX"), "subsurface_method": ("BURLEY", "RANDOM_WALK")},
}
PROPERTIES["voronoi_4"] = PROPERTIES["voronoi"]
PROPERTIES["map_range_float_vector"] = PROPERTIES["map_range_float"]

_OUTPUTS = {
    "convert": "value",
    "rgb": "color",
    "value": "value",
    "uv_map": "uv",
    "tex_coord": "generated normal uv object camera window reflection",
    "camera_data": "view_vector view_z_depth view_distance",
    "checker": "color fac",
    "image": "color alpha",
    "voronoi": "distance color position w",
    "brick": "color fac",
    "gabor": "value phase intensity",
    "gradient": "color fac",
    "magic": "color fac",
    "noise": "fac color",
    "wave": "color fac",
    "white_noise": "value color",
    "clamp_range": "result",
    "rgb_to_bw": "val",
    "combine_xyz": "vector",
    "separate_xyz": "x y z",
    "separate_color": "red green blue",
    "float_curve": "value",
    "rgb_curves": "value",
    "vector_curves": "value",
    "map_range_float": "result",
    "mix_float": "result",
    "mix_vector": "result",
    "mix_rgba": "result",
    "normal": "normal dot",
    "color_ramp": "color alpha",
    "vector_math_dot_product": "value",
    "vector_math_distance": "value",
    "vector_math_length": "value",
    "light_falloff": "quadratic linear constant",
    "ies": "fac",
    "attribute": "color vector fac alpha",
    "vertex_color": "color alpha",
    "bump": "normal",
    "displacement": "displacement",
    "vector_displacement": "displacement",
    "fresnel": "fac",
    "layer_weight": "fresnel facing",
    "geometry": "position normal tangent true_normal incoming parametric backfacing pointiness random_per_island",
    "tangent": "tangent",
    "wireframe": "fac",
    "light_path": "is_camera_ray is_shadow_ray is_diffuse_ray is_glossy_ray is_singular_ray is_reflection_ray "
    "is_transmission_ray ray_length ray_depth diffuse_depth glossy_depth transparent_depth transmission_depth",
    "normal_map": "normal",
    "bevel": "normal",
    "ambient_occlusion": "color ao",
    "object_info": "location color alpha object_index material_index random",
    "particle_info": "index random age lifetime location size velocity angular_velocity",
    "hair_info": "is_strand intercept length thickness random tangent_normal",
    "point_info": "position radius random",
} | dict.fromkeys(_COVERS, "value")
_OUTPUTS["voronoi_4"] = _OUTPUTS["voronoi"]


def outputs_of(op):
    """Names of the outputs of an operation."""
    found = _OUTPUTS.get(op)
    if found is None:
        is_vector = "vector" in op or op.endswith("mapping")
        found = "value" if op.startswith("math_") else "vector" if is_vector else "color"
    return found.split()


def properties_of(op, numbers):
    """Random properties of an operation."""
    table = PROPERTIES.get(op, {})
    needed = op in ("mix_rgba", "normal_map", "convert", "texture_mapping")
    found = {name: numbers.choice(values) for name, values in table.items() if needed or numbers.chance(0.5)}
    if op.startswith("math_"):
        found["use_clamp"] = numbers.chance(0.3)
    if op in ("image", "environment"):
        found["image"] = image(numbers)
    elif op == "color_ramp":
        found |= {"samples": numbers.array((4, 257)), "interpolate": numbers.chance(0.5)}
    elif op.endswith(("_curve", "_curves")):
        rows = 1 if op == "float_curve" else 3
        found |= {"samples": numbers.array((rows, 257)), "low": -numbers.unit(), "high": 1.0 + numbers.unit()}
        found["extrapolate"] = numbers.chance(0.5)
    elif op == "ies":
        angles, planes = numbers.choice(("0 40 90", "0 180", "30 20")), numbers.choice(("0 90", "0 360", "20 200"))
        count = len(angles.split())
        found["text"] = f"TILT=NONE\n1 1 2 {count} 2 1 2 0 0 0 1 1 1\n{angles}\n{planes}\n" + "7 9 " * count
    elif op == "normal":
        found["direction"] = numbers.vector()
    return found


def image(numbers):
    """A small picture of any kind, or None."""
    if numbers.chance(0.05):
        return None
    if numbers.chance(0.05):
        return Image("missing", filepath="/nowhere/missing.png")
    height, width = (numbers.choice((1, 1, 2, 3, 8, 33)) for _ in range(2))
    shape = (height, width, numbers.choice((1, 2, 3, 4)))
    dtype = numbers.choice((np.uint8, np.uint16, np.float16, np.float32))
    if np.issubdtype(dtype, np.integer):
        pixels = numbers.rng.integers(0, np.iinfo(dtype).max, shape, dtype, endpoint=True)
    else:
        with np.errstate(over="ignore"):
            pixels = numbers.array(shape).astype(dtype)
        pixels = np.abs(pixels) if numbers.tame else pixels
    space = numbers.choice(("sRGB", "Non-Color", "Linear Rec.709", "AgX Base sRGB"))
    alpha = numbers.choice(("AUTO", "STRAIGHT", "PREMUL", "CHANNEL_PACKED", "NONE"))
    return Image("random", pixels, colorspace=space, alpha_mode=alpha)


class Graph:
    """Nodes in the making; `closure` adds a tree of closures and returns its number.

    Parameters
    ----------
    numbers : Numbers
    operations : sequence of str
        Of which value nodes are taken.
    loops : bool
        Whether links may go round in circles.
    """

    def __init__(self, numbers, operations=VALUES, loops=True):
        self._numbers, self._operations = numbers, operations
        self._loops = loops and numbers.chance(0.1)
        self.nodes = []
        for _ in range(numbers.count(10) if numbers.chance(0.7) else 0):
            self._add_value()

    def closure(self, kinds, depth=0):
        """Number of a node that ends in closures."""
        numbers = self._numbers
        if depth < 4 and numbers.chance(0.35):
            a, b = (self.closure(kinds, depth + 1) for _ in range(2))
            op = numbers.choice(("mix_shader", "add_shader"))
            inputs = {"a": Link(a, "bsdf"), "b": Link(b, "bsdf")}
            if numbers.chance(0.1):
                del inputs[numbers.choice(("a", "b"))]
            if op == "mix_shader":
                inputs["fac"] = self._input(0.5)
            return self._append(Node(op, {k: v for k, v in inputs.items() if v is not None}))
        op = numbers.choice(kinds)
        return self._append(Node(op, self._inputs(CLOSURES[op].inputs), properties_of(op, numbers)))

    def displacement(self):
        """A link to some node that gives a vector, or None."""
        found = [n for n, node in enumerate(self.nodes) if "displacement" in node.op]
        return Link(found[-1], "displacement") if found and self._numbers.chance(0.6) else None

    def _add_value(self):
        op = self._numbers.choice(self._operations)
        if op == "convert" and not self.nodes:
            op = "value"
        inputs = self._inputs(OPERATIONS[op].inputs)
        if op == "convert":
            inputs = {"value": self._link()}
        self._append(Node(op, inputs, properties_of(op, self._numbers)))

    def _inputs(self, defaults):
        given = {name: self._input(default) for name, default in defaults.items()}
        return {name: value for name, value in given.items() if value is not None}

    def _input(self, default):
        """A link, a constant, or None to leave the input as it is."""
        numbers, kind = self._numbers, self._numbers.rng.random()
        if kind < 0.3 and self.nodes:
            return self._link()
        if kind < 0.65 and default is not None:
            return numbers.color() if isinstance(default, tuple) else numbers.number()
        return None

    def _link(self):
        values = [n for n, node in enumerate(self.nodes) if node.op in OPERATIONS]
        if not values:
            return 0.5
        number = self._numbers.choice(values)
        if self._loops and self._numbers.chance(0.2):
            return Link(len(self.nodes), "color")
        return Link(number, self._numbers.choice(outputs_of(self.nodes[number].op)))

    def _append(self, node):
        self.nodes.append(node)
        return len(self.nodes) - 1
