# SPDX-License-Identifier: GPL-3.0-or-later
"""Lights of a scene: the description's lamps and the emissive triangles, as tables by kind.

Blender's units, each checked against Cycles. With *normalize*, a power P gives radiance P/(4π²r²) to a sphere or disk
of radius r and P/(πA) to an area light, intensity P/(4π) to a point; a sun of irradiance E has radiance
E/(π sin²(angle/2)). Without it, lights with an extent have radiance P/π, a point intensity P/π, a sun radiance E.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial

import numpy as np

from ..geometry import OFFSET
from ..lights.area import AreaLights
from ..lights.choice import importance_of
from ..lights.classic import ClassicLights, LocalLight, ParallelLight, area_pseudo_light, mesh_pseudo_light
from ..lights.environment import ConstantEnvironment, EnvironmentMap
from ..lights.far_sides import far_sides
from ..lights.lamps import LampHits
from ..lights.panel import PanelLights, find_panels
from ..lights.point import DiskLights, PointLights, SphereLights
from ..lights.sampler import LightSampler
from ..lights.spot import SpotLights
from ..lights.sun import SunDisks, SunLights
from ..lights.triangle import TriangleLights, first_in_place, outward
from ..scene import PointLight, SpotLight, SunLight
from ..visibility import Rays
from .lamp_nodes import compile_lamp, shaded_lights
from .world import compile_world

_SMALLEST_RADIUS = 1e-15  # squares of smaller ones vanish in float32: points
_LARGEST_BODY = 0.5  # root of an emitter's area over the scene's extent; larger bodies may hold what they light
_TIGHT = 0.125  # of a facet's offset: the error of a sampled point, without the room that others need
_FARTHEST = 1e18  # m; squares of larger numbers are not finite in float32
_POWER = ("power", "irradiance")
_SMALLEST_ANGLE = 1e-6  # rad; float32 directions tell nothing smaller apart: parallel light


@dataclass(frozen=True, eq=False)
class Lights:
    """Everything that shines.

    sampler : LightSampler; `sampler.count` 0 means that no light can be sampled.
    lamps : LampHits; `lamps.count` 0 means that there is none to hit.
    classic : ClassicLights
    environment : ConstantEnvironment or EnvironmentMap
    emissive : (P,) bool
        Primitives whose material emits. Spheres and planes among them are found by scattered rays alone:
        `sampler.pdf_prim` is 0 for them.
    emitter : (count,) int32
        Of each light of the sampler, what shines: lights of the description, then objects, then the world.
    has_delta, has_extended : bool
        Whether lights without an extent, and with one (lamps and triangles), can be sampled.
    """

    sampler: LightSampler
    lamps: LampHits
    classic: ClassicLights
    environment: ConstantEnvironment | EnvironmentMap
    emissive: np.ndarray
    emitter: np.ndarray
    has_delta: bool
    has_extended: bool


@np.errstate(over="ignore", invalid="ignore")  # what is not finite goes through
def compile_lights(scene, geometry, emission_of_material, diagnostics, environment=None, clear_materials=()):
    """Tables of all lights of `scene`.

    Parameters
    ----------
    scene : Scene
    geometry : Geometry
        Positions become relative to its `origin`.
    emission_of_material : sequence
        For each of `geometry.materials`: None, a constant radiance (3,), or for a textured emitter a pair of the mean
        radiance (3,) and a callable ``Le(prim, u, v, arena) -> (3, n)``. Both sides emit.
    diagnostics : Diagnostics
        Told of lights that are left out or changed.
    environment : ConstantEnvironment or EnvironmentMap, optional
        Of the world, compiled before.
    clear_materials : sequence of int
        Numbers of the materials through which light may pass straight.

    Returns
    -------
    Lights
    """
    builder = _Builder(geometry, diagnostics)
    for number, light in enumerate(scene.lights):
        builder.add(light, number)
    first_object = len(scene.lights)
    world = first_object + len(scene.objects)
    shades = partial(_shades_itself, scene, geometry, clear_materials)
    emissive, surfaces, twins = _emissive_surfaces(geometry, emission_of_material, builder, first_object, shades)
    kinds = builder.kinds() + surfaces
    emitter = [builder.emitters(), *(geometry.object[np.atleast_2d(k.prim)[0]] + first_object for k in surfaces)]
    if environment is None:
        environment = compile_world(scene.world, diagnostics, geometry.view)
    if not environment.is_constant and environment.suns is not None:
        suns = environment.suns
        builder.classic += [ParallelLight(*sun) for sun in zip(suns.axis.T, suns.irradiance.T, strict=True)]
        for made in builder.classic[-len(suns.axis.T) :]:
            made.emitter = world
    if not environment.is_constant and environment.is_sampled:
        kinds.append(environment)
        emitter.append([world])
    shadowless = builder.shadowless()
    shadowless += [False] * (sum(k.count for k in kinds) - len(shadowless))
    sampler = LightSampler(kinds, importance_of(kinds), geometry.material.size, environment, shadowless)
    sampler.adopt(*twins)
    if environment in kinds:
        environment.choice = float(sampler.pmf[-1])
    return Lights(
        sampler=sampler,
        lamps=LampHits(sampler),
        classic=ClassicLights(builder.classic, environment.mean * (Rays.DIFFUSE in scene.world.visibility.rays)),
        environment=environment,
        emissive=emissive,
        emitter=np.concatenate(emitter).astype(np.int32),
        has_delta=any(not _has_extent(k) for k in kinds),
        has_extended=any(_has_extent(k) for k in kinds),
    )


def _has_extent(kind):
    return kind.extended or isinstance(kind, PanelLights | TriangleLights | EnvironmentMap)


class _Builder:
    """Collects lamps by kind, and the classic methods' pseudo-lights in the scene's order."""

    def __init__(self, geometry, diagnostics):
        self._geometry, self._origin = geometry, np.asarray(geometry.origin, np.float64)
        self._diagnostics = diagnostics
        self._rows, self._shadowless, self._emitters = {}, {}, {}
        self._casts_shadow, self._number = True, 0
        self._lamp, self._lamps, self._shades, self._key = None, {}, [], None
        self.classic = []

    def kinds(self):
        """One table for each kind that occurs, and for each program of lamps' nodes."""
        tables = {}
        for key, rows in self._rows.items():
            tables[key] = key[0](*(np.stack(column, axis=-1) for column in zip(*rows, strict=True)))
            if key in self._lamps:
                tables[key] = shaded_lights(tables[key], self._lamps[key], self._geometry)
        for pseudo_light, key, row in self._shades:
            pseudo_light.shade = partial(tables[key].towards_point, row)
        return list(tables.values())

    def shadowless(self):
        """Which of the lights of `kinds` cast no shadow, kind after kind."""
        return [flag for flags in self._shadowless.values() for flag in flags]

    def emitters(self):
        """Which lights of the description those of `kinds` are, kind after kind."""
        return [number for numbers in self._emitters.values() for number in numbers]

    def add(self, light, number):
        """Sort one light of the description in; leave it out, and say so, if it cannot shine."""
        place = f"light {light.name!r}"
        factor, code = compile_lamp(light, self._diagnostics)
        strength = factor * np.asarray(light.irradiance if isinstance(light, SunLight) else light.power, np.float64)
        if not _representable(strength) or not _is_near(light):
            self._diagnostics.warn("a light has numbers that are not finite; it is left out", place)
        elif not strength.any():
            self._diagnostics.warn("a light has no power; it is left out", place)
        else:
            self._casts_shadow, self._number, before = light.casts_shadow, number, len(self.classic)
            self._lamp = None if code is None else (light, code)
            add = {PointLight: self._add_point, SpotLight: self._add_spot, SunLight: self._add_sun}
            add.get(type(light), self._add_area)(light, strength, place)
            for made in self.classic[before:]:
                made.casts_shadow, made.emitter = light.casts_shadow, number
                if code is not None:
                    self._shades.append((made, self._key, len(self._lamps[self._key]) - 1))

    def _put(self, kind, *row):
        key = kind, None if self._lamp is None else self._lamp[1].key
        self._rows.setdefault(key, []).append(row)
        self._shadowless.setdefault(key, []).append(not self._casts_shadow)
        self._emitters.setdefault(key, []).append(self._number)
        if self._lamp is not None:
            self._lamps.setdefault(key, []).append(self._lamp)
            self._key = key

    def _add_point(self, light, power, place):
        self._put(*self._round_light(light, power))
        self.classic.append(self._round_classic(light, power, None))

    def _add_spot(self, light, power, place):
        direction = _unit(light.direction)
        if direction is None or not light.angle > 0.0:
            self._diagnostics.warn("a spot light has no direction or no angle; it is left out", place)
            return
        kind, *row = self._round_light(light, power)
        cone = (direction, light.angle, light.blend)
        self._put(_SPOTS[kind], *row, *cone)
        spot = _alone(_SPOTS[kind], (*row, *cone))
        self.classic.append(self._round_classic(light, power, lambda wi, arena: spot.attenuation(0, wi, arena)))

    def _round_light(self, light, power):
        """Kind and row of a point light or of the source of a spot light."""
        position, radius = self._local(light.position), float(light.radius)
        if radius < _SMALLEST_RADIUS:
            return PointLights, position, power / (4.0 * math.pi if light.normalize else math.pi)
        radiance = _round_radiance(light, power)
        if not _representable(radiance):
            return PointLights, position, radiance * math.pi * radius**2
        return DiskLights if light.soft_falloff else SphereLights, position, radius, radiance

    def _round_classic(self, light, power, profile):
        radius = float(light.radius)
        if radius < _SMALLEST_RADIUS:
            radius, intensity = 0.0, power / (4.0 * math.pi if light.normalize else math.pi)
        else:
            intensity = _round_radiance(light, power) * math.pi * radius**2
        extent = {"softening": radius**2} if light.soft_falloff else {"nearest": radius**2}
        return LocalLight(self._local(light.position), intensity, profile=profile, **extent)

    def _add_sun(self, light, irradiance, place):
        direction = _unit(light.direction)
        if direction is None:
            self._diagnostics.warn("a sun has no direction; it is left out", place)
            return
        projected = math.pi * math.sin(0.5 * light.angle) ** 2
        if light.angle < _SMALLEST_ANGLE:
            self._put(SunLights, -direction, irradiance)
        else:
            radiance = irradiance / projected if light.normalize else irradiance
            self._put(SunDisks, -direction, light.angle, radiance)
            irradiance = radiance * projected
        self.classic.append(ParallelLight(-direction, irradiance))

    def _add_area(self, light, power, place):
        transform = np.asarray(light.transform, np.float64)
        x, y, half = _rectangle(transform[:3, :3], light.size)
        round_ = light.shape in ("ELLIPSE", "DISK")
        area = half[0] * half[1] * (math.pi if round_ else 4.0)
        radiance = power / (math.pi * area if light.normalize else math.pi) if area > 0.0 else np.full(3, math.inf)
        if not _representable(radiance):
            self._diagnostics.warn("an area light has no area; it is left out", place)
            return
        normal = np.cross(x, y)
        normal = -normal if normal @ transform[:3, 2] > 0.0 else normal
        center = self._local(transform[:3, 3])
        row = (center, x, y, normal, half, round_, radiance, light.spread)
        self._put(AreaLights, *row)
        self.classic.append(area_pseudo_light(center, normal, area, radiance, _alone(AreaLights, row).attenuation))

    def _local(self, position):
        return np.asarray(position, np.float64) - self._origin

    def warn_triangles(self, count, material):
        """Say that a material's emission is not finite."""
        message = "an emission is not finite; its triangles are not sampled as lights"
        self._diagnostics.warn(message, f"material {material.name!r}", count)


def _alone(kind, row):
    """Table of one light."""
    return kind(*(np.asarray(value)[..., None] for value in row))


def _spots_of(kind):
    """Maker of spot lights with sources of `kind`, from the source's columns and the cone's."""

    def make(*columns):
        return SpotLights(kind(*columns[:-3]), *columns[-3:])

    return make


_SPOTS = {kind: _spots_of(kind) for kind in (PointLights, SphereLights, DiskLights)}


def _emissive_surfaces(geometry, emission_of_material, builder, first_object, shades):
    """Which primitives emit, (P,) bool, the tables of the panels and triangles among them, and twins (2, n).

    Of triangles in one place one is a light, for all shine through one another; a twin is (the other one, the light).
    """
    emits = np.array([e is not None for e in emission_of_material], bool)
    emissive = emits[geometry.material] if emits.size else np.zeros(geometry.material.size, bool)
    means, textures, texture_of = _emission_tables(geometry, emission_of_material, builder)
    prim = np.flatnonzero(emissive[: geometry.triangle_count])
    material = geometry.material[prim]
    corners = geometry.corners_of(prim).astype(np.float64)
    v0, v1, v2 = corners.reshape(3, 3, -1)
    area = np.linalg.norm(np.cross(v1 - v0, v2 - v0, axis=0), axis=0)
    shines = (area > 0.0) & means[:, material].any(axis=0)
    first = first_in_place(corners, np.where(texture_of[material] < 0, material, -1 - prim))
    is_light = shines & (first == np.arange(prim.size))
    twins = np.stack([prim, prim[first]])[:, shines & ~is_light]
    if not is_light.any():
        return emissive, [], twins
    prim, material, corners = prim[is_light], material[is_light], corners[:, is_light]
    radiance = means[:, material]
    by_object = np.argsort(geometry.object[prim], kind="stable")
    ends = np.flatnonzero(np.diff(geometry.object[prim][by_object])) + 1
    for own in np.split(by_object, ends):
        builder.classic.append(mesh_pseudo_light(corners[:, own], radiance[:, own]))
        builder.classic[-1].emitter = first_object + int(geometry.object[prim[own[0]]])
    low, high = geometry.bounds
    extent = float(np.linalg.norm(np.subtract(high, low, dtype=np.float64)))
    texture, axis = texture_of[material], outward(corners, geometry.object[prim], _LARGEST_BODY * extent)
    clearance = _TIGHT * geometry.facets[prim, OFFSET]
    hiding = far_sides(corners, geometry.object[prim], axis, clearance, lambda rows: shades(prim[rows]))
    alike = (np.diff(prim) == 1) & (np.diff(material) == 0) & (np.diff(geometry.object[prim]) == 0)
    first, *sides = find_panels(corners, alike & (texture[1:] < 0))
    kinds = []
    if first.size:
        pairs = np.stack([prim[first], prim[first + 1]])
        kinds.append(PanelLights(*sides, pairs, radiance[:, first], axis[:, first], hiding and hiding.of_pairs(first)))
    rest = np.delete(np.arange(prim.size), np.concatenate([first, first + 1]))
    if rest.size:
        texture = texture[rest] if textures else None
        tables = radiance[:, rest], axis[:, rest], textures, texture, hiding and hiding.of(rest)
        kinds.append(TriangleLights(corners[:, rest], prim[rest], *tables))
    return emissive, kinds, twins


def _shades_itself(scene, geometry, clear_materials, prim):
    """Whether light from beyond primitives of an object that shines ends at them, (n,) bool of `prim` (n,)."""
    numbers, inverse = np.unique(geometry.object[prim], return_inverse=True)
    seen = [scene.objects[n].visibility for n in numbers]
    meets = np.array([Rays.SHADOW in v.rays and v.blockers is None for v in seen], bool)
    return meets[inverse] & ~np.isin(geometry.material[prim], np.asarray(clear_materials, int))


def _emission_tables(geometry, emission_of_material, builder):
    """Mean radiance (3, M), evaluators of the textured materials, and each material's evaluator or -1, (M,)."""
    means = np.zeros((3, len(emission_of_material)))
    texture_of = np.full(len(emission_of_material), -1, np.int32)
    textures = []
    for m, emission in enumerate(emission_of_material):
        if emission is None:
            continue
        textured = len(emission) == 2
        mean = np.asarray(emission[0] if textured else emission, np.float64)
        if not _representable(mean):
            builder.warn_triangles(int((geometry.material == m).sum()), geometry.materials[m])
            continue
        means[:, m] = mean
        if textured:
            texture_of[m] = len(textures)
            textures.append(emission[1])
    return means, textures, texture_of


def _round_radiance(light, power):
    return power / (4.0 * (math.pi * light.radius) ** 2) if light.normalize else power / math.pi


def _rectangle(axes, size):
    """Orthonormal x, y and half side lengths (2,) of a rectangle under the linear map `axes` (3, 3).

    A sheared rectangle becomes the upright one of the same area.
    """
    x, y = axes[:, 0] * size[0], axes[:, 1] * size[1]
    width = float(np.linalg.norm(x))
    x = x / width if width > 0.0 else np.array([1.0, 0.0, 0.0])
    y = y - (x @ y) * x
    height = float(np.linalg.norm(y))
    y = y / height if height > 0.0 else np.array([0.0, 1.0, 0.0])
    return x, y, np.array([0.5 * width, 0.5 * height])


def _unit(vector):
    """Unit vector (3,) float64, or None of the zero vector."""
    vector = np.asarray(vector, np.float64)
    length = float(np.linalg.norm(vector))
    return vector / length if length > 0.0 else None


def _representable(values):
    """Whether numbers are finite in float32, squares of their tables' sums included."""
    return bool(np.all(np.abs(values) < 1e36))


def _is_near(light):
    """Whether places and sizes are finite in float32, and so are their squares."""
    numbers = [v for name, v in vars(light).items() if isinstance(v, (float, tuple, np.ndarray)) and name not in _POWER]
    return all(np.isfinite(v).all() and np.all(np.abs(v) < _FARTHEST) for v in numbers)
