# SPDX-License-Identifier: GPL-3.0-or-later
"""Input nodes, bumps and turned normals over lanes, and that a scene pays for what it reads alone."""

from __future__ import annotations

import numpy as np
import pytest

from zraka.core.arena import Arena
from zraka.core.compile import code, compile_scene
from zraka.core.compile.features import Feature
from zraka.core.compile.materials import compile_program
from zraka.core.compile.needs import Needs, needs_of
from zraka.core.diagnostics import Diagnostics
from zraka.core.nodes import OPERATIONS
from zraka.core.nodes.base import Context, Ray
from zraka.core.nodes.coordinates import lookup_generated
from zraka.core.nodes.displaced import beside
from zraka.core.render import render
from zraka.core.scene import (
    Instance,
    Link,
    Material,
    Mesh,
    Node,
    ObjectInfo,
    Plane,
    Scene,
    Spheres,
    TextureSpace,
)
from zraka.core.settings import Settings

from .scenes import camera, quad

SETTINGS = Settings(width=32, height=32, samples=1, threads=1)


def emitter(*nodes, output="value", name="shown"):
    """A material that emits `output` of the last of `nodes`."""
    shown = Node("emission", {"color": Link(len(nodes) - 1, output), "strength": 1.0})
    return Material(name, (*nodes, shown), len(nodes))


def compiled(*instances, settings=SETTINGS, messages=None, **more):
    diagnostics = Diagnostics()
    view = camera((0, 0, 3), (0, 0, 0), fov=0.5)
    made = compile_scene(Scene(view, instances, **more), settings, diagnostics)
    if messages is not None:
        messages += diagnostics.messages()
    return made


def shown(*nodes, output="value", mesh=None, u=0.25, v=0.25, prim=0, wo=(0, 0, 1), material=None, **more):
    """What a material of `nodes` emits at one point of a quad, (3,)."""
    material = material or emitter(*nodes, output=output)
    made = compiled(Instance(mesh or quad(2), materials=(material,), **more))
    lanes = [np.array([x], np.float32) for x in (u, v)]
    direction = np.float32(wo).reshape(3, 1)
    return made.emission_at(np.array([prim], np.int32), *lanes, Arena(), direction)[:, 0]


# -- what is tabulated -------------------------------------------------------------------------------------------------


def test_a_scene_without_input_nodes_has_no_tables():
    made = compiled(Instance(quad(), materials=(Material.diffuse(),)))
    assert made.geometry.corner_values == {} and made.geometry.objects is None and made.geometry.uvs == {}
    assert Feature.LIGHT_PATH not in made.features


@pytest.mark.parametrize(
    ("node", "output", "expected"),
    [
        (Node("checker"), "color", Needs(generated=True)),
        (Node("checker", {"vector": (0.0, 0.0, 0.0)}), "color", Needs()),
        (Node("image"), "color", Needs(uvs={""})),
        (Node("uv_map", {}, {"uv_map": "A"}), "uv", Needs(uvs={"A"})),
        (Node("tex_coord"), "window", Needs()),
        (Node("tex_coord"), "object", Needs(objects=True)),
        (Node("tex_coord", {}, {"matrix": (1.0,) * 16}), "object", Needs()),
        (Node("geometry"), "position", Needs()),
        (Node("geometry"), "tangent", Needs(generated=True, objects=True)),
        (Node("geometry"), "pointiness", Needs(pointiness=True)),
        (Node("normal_map", {}, {"uv_map": "A"}), "normal", Needs(tangents={"A"}, objects=True)),
        (Node("normal_map", {}, {"space": "WORLD"}), "normal", Needs()),
        (Node("object_info"), "random", Needs(objects=True)),
        (Node("attribute", {}, {"attribute_name": "A"}), "color", Needs(attributes={"A"})),
        (Node("vertex_color"), "color", Needs(colors={None})),
    ],
)
def test_only_what_is_read_is_needed(node, output, expected):
    assert needs_of([emitter(node, output=output)]) == expected


def test_needs_are_united_and_compared():
    a, b = Needs(uvs={"A"}, objects=True), Needs(uvs={"B"})
    assert a <= a | b and b <= a | b and not a <= b
    assert (a | b) == Needs(uvs={"A", "B"}, objects=True)


def test_light_path_is_a_feature():
    material = emitter(Node("light_path"), output="is_camera_ray")
    assert Feature.LIGHT_PATH in compiled(Instance(quad(), materials=(material,))).features


# -- coordinates -------------------------------------------------------------------------------------------------------


def test_generated_coordinates_span_the_box():
    node = Node("tex_coord")
    # The point (0.5, 0, 0) of a square from -1 to 1; it is flat, so its third coordinate is in the middle.
    found = shown(node, output="generated", u=0.25, v=0.5)
    np.testing.assert_allclose(found, (0.75, 0.5, 0.5), atol=1e-6)


def test_texture_space_and_undeformed_vertices():
    mesh = quad(2)
    moved = Mesh(
        mesh.vertices + np.float32([0, 0, 5]),
        mesh.triangles,
        texture_space=TextureSpace((1, 0, 0), (2, 4, 1), undeformed=mesh.vertices),
    )
    found = shown(Node("tex_coord"), output="generated", mesh=moved, u=0.0, v=0.0)
    np.testing.assert_allclose(found, (0, 0.375, 0.5), atol=1e-6)


def test_spheres_and_planes_are_generated_by_their_place():
    material = emitter(Node("checker", {"scale": 1.0}), output="color")
    made = compiled(
        Instance(quad(), materials=(material,)),
        spheres=(Spheres([(3, 0, 0)], [1.0], material),),
        planes=(Plane((0, 0, -2), (0, 0, 1), material),),
    )
    surface = made.interact(*hits_of(made, [(3, 0, 5), (9, 9, 5)], (0, 0, -1)))
    found = lookup_generated(Context(Arena(), 2, surface, made.geometry))
    np.testing.assert_allclose(found, np.array([(3, 0, 1), (9, 9, -2)]).T, atol=1e-5)


def hits_of(made, origins, direction):
    o = np.ascontiguousarray((np.array(origins) - made.geometry.origin).T.astype(np.float32))
    d = np.repeat(np.float32(direction).reshape(3, 1), o.shape[1], axis=1)
    return made.accel.intersect(o, d, None, Arena()), o, d, Arena()


def test_object_coordinates_undo_the_transform_far_from_zero():
    transform = np.array([[0, -2, 0, 1e5], [2, 0, 0, -3e5], [0, 0, 2, 10], [0, 0, 0, 1]], float)
    found = shown(Node("tex_coord"), output="object", transform=transform, u=0.25, v=0.5)
    np.testing.assert_allclose(found, (0.5, 0, 0), atol=1e-5)


def test_each_object_tells_its_own():
    material = emitter(Node("object_info"), output="color")
    things = [
        Instance(quad(), materials=(material,), info=ObjectInfo(color=(k, 2 * k, 3 * k, 1))) for k in (0.1, 0.2, 0.3)
    ]
    made = compiled(*things)
    prim = np.arange(6, dtype=np.int32)
    zero = np.zeros(6, np.float32)
    found = made.emission_at(prim, zero, zero, Arena())
    np.testing.assert_allclose(found[0], np.repeat([0.1, 0.2, 0.3], 2), rtol=1e-6)


def test_window_coordinates_are_those_of_the_picture():
    assert shown(Node("tex_coord"), output="window", u=0.0, v=0.0) == pytest.approx((1 / 6, 1 / 6, 0), abs=1e-5)


# -- light path --------------------------------------------------------------------------------------------------------


def test_rays_are_told_apart_lane_by_lane():
    camera_flag, length = np.float32([1, 0]), np.float32([2, 5])
    context = Context(Arena(), 2, ray=Ray(camera=camera_flag, depth=3, length=length))
    found = OPERATIONS["light_path"].run(context, {}, {})
    assert found["is_camera_ray"].tolist() == [1, 0] and found["ray_depth"].tolist() == [3]
    assert found["ray_length"].tolist() == [2, 5] and found["is_shadow_ray"].tolist() == [0]


def test_light_that_is_sampled_is_no_camera_ray():
    material = emitter(Node("light_path"), output="is_camera_ray")
    made = compiled(Instance(quad(), materials=(material,)))
    at = [np.zeros(1, np.float32)] * 2
    assert made.emission_at(np.zeros(1, np.int32), *at, Arena()).tolist() == [[0]] * 3
    assert made.emitted(made.interact(*hits_of(made, [(0.1, 0.2, 1)], (0, 0, -1))), Arena()).tolist() == [[1]] * 3


# -- bumps and turned normals ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("slope", [0.5, -2.0])
@pytest.mark.parametrize("width", [0.1, 1.0, 5.0])
def test_a_bump_has_the_slope_of_its_height(slope, width):
    nodes = (
        Node("geometry"),
        Node("multiply", {"a": Link(0, "position"), "b": (slope, 0.0, 0.0)}),
        Node("convert", {"value": Link(1, "value")}, {"from": "vector", "to": "float"}),
        # The mean of three components is a third of the first.
        Node("bump", {"height": Link(2, "value"), "distance": 3.0, "filter_width": width}),
    )
    expected = np.array((-slope, 0, 1)) / np.hypot(1, slope)
    np.testing.assert_allclose(shown(*nodes, output="normal"), expected, atol=2e-4)


def test_displacement_has_the_slope_between_two_heights():
    """Of the height x², whose slope at x = 0 grows with the distance of the heights."""
    nodes = (
        Node("geometry"),
        Node("multiply", {"a": Link(0, "position"), "b": Link(0, "position")}),
        Node("multiply", {"a": Link(1, "value"), "b": (3.0, 0.0, 0.0)}),
        Node("convert", {"value": Link(2, "value")}, {"from": "vector", "to": "float"}),
        Node("displacement", {"height": Link(3, "value"), "midlevel": 0.0}),
        Node("emission", {"color": Link(0, "normal"), "strength": 1.0}),
    )

    def slope(step):
        x, _, z = shown(material=Material("shown", nodes, 5, Link(4, "displacement"), displacement_step=step))
        return x / z

    assert slope(0.1) < -1e-3
    assert slope(1.0) / slope(0.1) == pytest.approx(10.0, rel=0.01)


def test_a_bump_steps_by_pixels_over_the_window():
    made = compiled(Instance(quad(2), materials=(emitter(Node("tex_coord"), output="window"),)))
    surface = made.interact(*hits_of(made, [(0.1, 0.2, 1)], (0, 0, -1)))
    context = Context(Arena(), 1, surface, made.geometry)
    moved = beside(context, ((2.0, 0.0), (0.0, 0.5)))
    properties = {"window_step": "PIXEL"}

    def window(context):
        return OPERATIONS["tex_coord"].run(context, {}, properties)["window"][:, 0]

    for (x, y), aside in moved.items():
        np.testing.assert_allclose(window(aside) - window(context), (x / 32, y / 32, 0), atol=1e-6)


def test_a_constant_height_bumps_nothing():
    np.testing.assert_allclose(shown(Node("bump", {"height": 0.7}), output="normal"), (0, 0, 1), atol=1e-6)


def test_heights_that_are_not_finite_leave_the_normal():
    nodes = (
        Node("geometry"),
        Node("multiply", {"a": Link(0, "position"), "b": (np.inf, np.inf, np.inf)}),
        Node("bump", {"height": Link(1, "value")}),
    )
    np.testing.assert_allclose(shown(*nodes, output="normal"), (0, 0, 1), atol=1e-6)


def test_a_height_is_run_at_three_points_and_what_is_shared_once():
    nodes = (
        Node("geometry"),
        Node("bump", {"height": Link(0, "position")}),
        Node("bump", {"height": Link(0, "position"), "normal": Link(1, "normal")}),
    )
    program, _ = compile_program(emitter(*nodes, output="normal"), Diagnostics())
    assert len(program.emission._steps) == 3 + 2


# -- graphs ------------------------------------------------------------------------------------------------------------


def test_a_loop_is_cut_and_said():
    nodes = (
        Node("geometry"),
        Node("add", {"a": Link(0, "position"), "b": Link(2, "value")}),
        Node("add", {"a": Link(1, "value"), "b": 0.25}),
    )
    messages = []
    made = compiled(Instance(quad(), materials=(emitter(*nodes),)), messages=messages)
    at = [np.zeros(1, np.float32)] * 2
    assert np.isfinite(made.emission_at(np.zeros(1, np.int32), *at, Arena())).all()
    assert len(messages) == 1 and "loop" in messages[0]


def test_a_tangent_that_is_a_loop_is_cut():
    """An anisotropic closure has then one of its own, of which nothing was tabulated."""
    link = Link(0, "color")
    glossy = Node("glossy", {"color": (0.8,) * 3, "roughness": 0.3, "anisotropy": 0.5, "tangent": link})
    made = Scene(camera((0, 0, 3), (0, 0, 0), fov=0.5), [Instance(quad(2), materials=(Material("m", (glossy,), 0),))])
    film = render(compile_scene(made, SETTINGS, Diagnostics()), SETTINGS)
    assert film.nonfinite == 0


def test_two_thousand_nodes_run_in_bounded_memory(monkeypatch):
    nodes = [Node("tex_coord")]
    nodes += [Node("add", {"a": Link(k, "generated" if k == 0 else "value"), "b": 1e-3}) for k in range(2000)]
    made = compiled(Instance(quad(2), materials=(emitter(*nodes),)))
    rng = np.random.default_rng(0)
    u, v = 0.5 * rng.random((2, 30_000), np.float32)
    arena = Arena()
    whole = np.array(made.emission_at(np.zeros(u.size, np.int32), u, v, arena))
    np.testing.assert_allclose(whole[0], u + v + 2, atol=1e-3)
    assert arena.nbytes < 1 << 26
    monkeypatch.setattr(code, "_MOST_VALUES", 1 << 40)
    np.testing.assert_array_equal(made.emission_at(np.zeros(u.size, np.int32), u, v, Arena()), whole)


def test_what_reads_an_unknown_node_takes_its_default():
    nodes = (
        Node("unsupported", {}, {"label": "Magic Wand"}),
        Node("convert", {"value": Link(0, "fac")}, {"from": "float", "to": "color"}),
        Node("diffuse", {"color": Link(1, "value")}),
    )
    messages = []
    made = compiled(Instance(quad(), materials=(Material("m", nodes, 2),)), messages=messages)
    row = made.materials.constants(0, "scatter", np.zeros(1, np.int32), Arena())
    assert 0.8 in row and len(messages) == 1 and "Magic Wand" in messages[0]


def test_what_is_not_known_is_said():
    messages = []
    material = emitter(Node("particle_info"), output="age")
    compiled(Instance(quad(), materials=(material,)), messages=messages)
    assert len(messages) == 1 and "shown" in messages[0]


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, 0.0, -1.0])
@pytest.mark.parametrize(
    ("op", "inputs", "output"),
    [
        ("fresnel", ("ior",), "fac"),
        ("layer_weight", ("blend",), "facing"),
        ("layer_weight", ("blend",), "fresnel"),
        ("bump", ("strength", "distance"), "normal"),
        ("normal_map", ("strength", "color"), "normal"),
        ("wireframe", ("size",), "fac"),
        ("displacement", ("height", "scale"), "displacement"),
    ],
)
def test_odd_inputs_raise_no_warning(op, inputs, output, value):
    nodes = (
        Node("geometry"),
        Node("multiply", {"a": Link(0, "position"), "b": (value,) * 3}),
        Node(op, dict.fromkeys(inputs, Link(1, "value"))),
    )
    assert shown(*nodes, output=output).shape == (3,)
