# SPDX-License-Identifier: GPL-3.0-or-later
"""Hair curves and the hair of particle systems.

Source: Blender manual, "Particle Systems: Hair Shape", and Cycles for what an attribute that is missing means and for
the radius along a strand.
"""

from __future__ import annotations

from itertools import chain

import numpy as np

from ...core import scene as description
from ...core.compile.round_tables import intercepts
from .attributes import TYPES

DEFAULT_RADIUS = 0.005  # Blender's, where the attribute is missing
_DOMAINS = {"POINT": "vertex", "CURVE": "strand"}


def export_curves(curves, transform, material, name, needs):
    """Strands of hair curves through their control points, None where there are none.

    Parameters
    ----------
    curves : bpy.types.Curves
        Whatever the type of a curve, its control points are gone through as those of hair; so does Cycles.
    transform : (4, 4) float64
    material : core.scene.Material or None
    name : str
    needs : core.compile.needs.Needs
    """
    count, strands = len(curves.points), len(curves.curves)
    if not count or not strands:
        return None
    points = np.zeros((count, 3), np.float32)
    curves.attributes["position"].data.foreach_get("vector", points.reshape(-1))
    ends = np.zeros(strands + 1, np.int32)
    curves.curve_offset_data.foreach_get("value", ends)
    radii = _values(curves.attributes.get("radius"))
    names = needs.attributes | needs.colors | needs.uvs
    attributes = {n: a for n in names if n and (a := curve_attribute(curves.attributes.get(n))) is not None}
    uv = next((a for a in curves.attributes if a.domain == "CURVE" and a.data_type == "FLOAT2"), None)
    return description.Curves(
        points,
        np.full(count, DEFAULT_RADIUS, np.float32) if radii is None else radii.reshape(-1),
        np.diff(ends),
        transform,
        material,
        name,
        uvs={} if uv is None else {uv.name: _values(uv)},
        attributes=attributes,
    )


def curve_attribute(attribute):
    """`core.scene.Attribute` of one of curves or points, None where there is none that nodes can read."""
    values = _values(attribute)
    return None if values is None else description.Attribute(values, _DOMAINS[attribute.domain])


def _values(attribute):
    """Values (n, C) float32 of an attribute of curves, None where there is none that nodes can read."""
    if attribute is None or attribute.data_type not in TYPES or attribute.domain not in _DOMAINS:
        return None
    member, columns, dtype = TYPES[attribute.data_type]
    values = np.zeros((len(attribute.data), columns), dtype)
    attribute.data.foreach_get(member, values.reshape(-1))
    return values.astype(np.float32)


# -- particle systems --------------------------------------------------------------------------------------------------


def has_hair(obj, is_render):
    """Whether an evaluated object has a particle system whose paths are rendered."""
    return any(True for _ in _systems(obj, is_render))


def _systems(obj, is_render):
    for modifier in obj.modifiers:
        if modifier.type == "PARTICLE_SYSTEM" and (modifier.show_render if is_render else modifier.show_viewport):
            settings = modifier.particle_system.settings
            if settings.type == "HAIR" and settings.render_type == "PATH":
                yield modifier, modifier.particle_system, settings


def export_hair(obj, transform, materials, is_render, needs):
    """Strands of each particle system of an object.

    Parameters
    ----------
    obj : bpy.types.Object
        Evaluated.
    transform : (4, 4) float64
        Where the hair is shown; of an instance it is not `obj`'s own.
    materials : sequence of core.scene.Material or None
        Of the object's slots.
    is_render : bool
        Whether the dependency graph is a render's, which has its own number of steps.
    needs : callable
        ``needs(material) -> Needs``.

    Yields
    ------
    core.scene.Curves
    """
    for modifier, system, settings in _systems(obj, is_render):
        numbers = _shown(system, settings, is_render)
        if not len(numbers):
            continue
        material = materials[min(max(settings.material - 1, 0), len(materials) - 1)] if materials else None
        points = _points(obj, system, settings, numbers, is_render)
        counts = np.full(len(numbers), points.shape[1])
        points = points.reshape(-1, 3)
        uvs, active, attributes = _of_emitter(obj, modifier, system, numbers, needs(material))
        yield description.Curves(
            points,
            _radii(points, counts, settings),
            counts,
            transform,
            material,
            obj.name,
            uvs=uvs,
            active_uv=active,
            attributes=attributes,
            texture_space=_texture_space(obj.data),
        )


def _shown(system, settings, is_render):
    """Numbers of the strands that are rendered: the children, and the parents where there are none."""
    parents, children = len(system.particles), len(system.child_particles)
    if not is_render:
        children = children * settings.display_percentage // 100
    first = parents if settings.child_type != "NONE" and children else 0
    return range(first, parents + children)


def _points(obj, system, settings, numbers, is_render):
    """Points (S, K, 3) of the strands in the space of `obj`."""
    steps = (1 << (settings.render_step if is_render else settings.display_step)) + 1
    if settings.kink == "SPIRAL":
        steps += settings.kink_extra_steps
    co = system.co_hair
    read = chain.from_iterable(co(obj, particle_no=n, step=k).to_tuple() for n in numbers for k in range(steps))
    points = np.fromiter(read, np.float64, 3 * steps * len(numbers)).reshape(-1, 3)
    to_object = np.linalg.pinv(np.array(obj.matrix_world, np.float64))
    return (points @ to_object[:3, :3].T + to_object[:3, 3]).astype(np.float32).reshape(len(numbers), steps, 3)


def _radii(points, counts, settings):
    """Radius of each point: from the root's to the tip's along a power of the share of the length."""
    left = 1 - intercepts(points, counts)[0]
    if settings.shape < 0:
        left = left ** (1 + settings.shape)
    elif settings.shape > 0:
        left = left ** (1 / max(1 - settings.shape, 1e-6))
    root, tip = (0.5 * settings.radius_scale * r for r in (settings.root_radius, settings.tip_radius))
    radii = tip + left * (root - tip)
    if settings.use_close_tip:
        radii[np.cumsum(counts) - 1] = 0
    return radii


def _of_emitter(obj, modifier, system, numbers, needs):
    """UV maps, the active one's name and colour attributes, as they are read, of the surface below the roots."""
    mesh = obj.data
    particles = [system.particles[min(n, len(system.particles) - 1)] for n in numbers] if _reads_emitter(needs) else []

    def asked(function, number):
        return np.array([function(modifier, p, n, number) for n, p in zip(numbers, particles, strict=True)], np.float32)

    active = next((layer.name for layer in mesh.uv_layers if layer.active_render), "")
    wanted = needs.uvs | needs.attributes
    uvs = {
        layer.name: asked(lambda m, p, n, k: system.uv_on_emitter(m, particle=p, particle_no=n, uv_no=k), number)
        for number, layer in enumerate(mesh.uv_layers)
        if layer.name in wanted or ("" in needs.uvs and layer.name == active)
    }
    layers = [a for a in mesh.color_attributes if a.domain == "CORNER" and a.data_type == "BYTE_COLOR"]
    attributes = {}
    for number, layer in enumerate(layers):
        if layer.name in needs.attributes | needs.colors:
            colors = asked(lambda m, p, n, k: system.mcol_on_emitter(m, p, particle_no=n, vcol_no=k), number)
            attributes[layer.name] = description.Attribute(_linear(colors), "strand")
    return uvs, active, attributes


def _reads_emitter(needs):
    return bool(needs.uvs or needs.attributes or needs.colors)


def _linear(colors):
    """Colours as they are stored, in sRGB, to linear."""
    return np.where(colors <= 0.04045, colors / 12.92, ((np.maximum(colors, 0) + 0.055) / 1.055) ** 2.4)


def _texture_space(mesh):
    return description.TextureSpace(tuple(mesh.texspace_location), tuple(mesh.texspace_size))
