# SPDX-License-Identifier: GPL-3.0-or-later
"""A scene made ready: all the tables that the methods read."""

from __future__ import annotations

import copy
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..accel import Accel, Hits
from ..arena import Arena
from ..bsdf.base import Lobe
from ..camera import CameraRays, check_camera
from ..geometry import NORMAL
from ..interaction import make_interact
from ..light_description import has_extent
from ..nodes.base import CAMERA_RAY, SCATTERED_RAY, Context
from ..nodes.probe import PROBING, Probe
from ..sampling.sampler import Sampler
from ..spaces import View
from ..visibility import Rays
from .again import asks_for_camera, exchanged, same_lights, same_shapes
from .features import Feature, features_of, names
from .geometry import compile_geometry
from .lights import compile_lights
from .materials import compile_materials
from .moving import move, parts_of
from .needs import needs_of
from .objects import compile_objects
from .visibility import SceneVisibility

_SHARP = Lobe.DELTA | Lobe.TRANSMISSION
_MEAN_POINTS = 4096  # points at which a textured emitter's mean radiance is estimated


class Surface(NamedTuple):
    """Hits that are shaded: an `Interaction`, the direction `wo` to the viewer, and barycentrics for textures."""

    p: np.ndarray
    ng: np.ndarray
    ns: np.ndarray
    front: np.ndarray
    offset: np.ndarray
    prim: np.ndarray
    wo: np.ndarray
    u: np.ndarray
    v: np.ndarray


class CompiledScene:
    """Read-only tables of one scene, shared by all workers.

    Attributes
    ----------
    described : core.scene.Scene
        What was compiled.
    geometry, accel, materials, lights, camera, sampler
        The tables, by subject.
    emissive_prim, transparent_prim, clear_prim : (P + 1,) bool
        Which primitives emit, let rays pass straight, do nothing else; the last element stands for a miss (-1).
    visibility : SceneVisibility
        What kinds of rays see what.
    needs_rays : bool
        Whether `interact` reads the rays' origins and distances; triangles do without.
    features : Feature
        What the scene needs, and what the methods therefore run.
    """

    def __init__(self, scene, settings, diagnostics, force_features=None, before=None, editable=False):
        check_camera(scene.camera)
        self.described, self.diagnostics = scene, diagnostics
        self._shows_uv = "uv" in settings.guides.names
        needs = needs_of(_materials_of(scene))
        if self._shows_uv:
            needs.uvs.add("")
        self._needs = needs
        shapes_stay = before is not None and before._shows_uv == self._shows_uv and same_shapes(before.described, scene)
        geometry = before.geometry if shapes_stay else self._with_new_places(before) or self._with_new_materials(before)
        forms_stay = geometry is not None
        if not forms_stay:
            geometry = compile_geometry(scene, needs.uvs, diagnostics, needs)
        view = View(scene.camera, settings.width, settings.height, geometry.origin)
        self.geometry = replace(geometry, view=view)
        materials_stay = before is not None and _are(before.geometry.materials, geometry.materials)
        self.materials = before.materials if materials_stay else compile_materials(geometry.materials, diagnostics)
        self._interact = make_interact(self.geometry)
        self.needs_rays = self.geometry.count > self.geometry.triangle_count
        self._tabulate_materials()
        if shapes_stay and same_lights(before.described, scene) and not self._light_follows_camera():
            self.lights = before.lights
        else:
            self.lights = self._compile_lights(before)
        self.camera = CameraRays(scene.camera, settings.width, settings.height, self.geometry.origin)
        self.sampler = Sampler(settings.seed)
        self.needed = features_of(self.geometry, self.materials, self.lights, self.camera, settings)
        if forms_stay:
            self.accel = before.accel
        else:
            self.accel = Accel(self.geometry, parts=parts_of(self.geometry) if editable else None)
        if any(p.operations & PROBING for p in self.materials.programs):
            self.geometry = replace(self.geometry, probe=Probe(self.accel, self._interact))
        self.visibility = SceneVisibility(scene, self.geometry, self.lights, self.accel)
        if not self.visibility.is_plain:
            self.needed |= Feature.VISIBILITY
        if self.visibility.among_catchers is not None and settings.method == "pathtrace":
            self.needed |= Feature.CATCHERS
        self.features = self.needed if force_features is None else force_features
        self.lights.sampler.tells_lights = Feature.VISIBILITY in self.features
        self._say_what_is_missing(settings, diagnostics)

    def _tabulate_materials(self):
        """What is asked of a primitive's material before its program runs."""
        programs, emission_of = self.materials.programs, self.materials.emission
        textured = [isinstance(e, str) for e in emission_of]
        self._textured_emission = any(textured)
        table = [np.zeros(3) if e is None or isinstance(e, str) else e for e in emission_of]
        self._emission_table = np.array(table, np.float32).reshape(-1, 3).T.copy()
        self.emissive_prim = self._by_primitive([e is not None for e in emission_of])
        self.transparent_prim = self._by_primitive(
            [programs[n].transparency is not None for n in self.materials.program_of]
        )
        self.clear_prim = self._by_primitive(
            [
                not programs[n].closures and programs[n].holdout is None and emission_of[m] is None
                for m, n in enumerate(self.materials.program_of)
            ]
        )
        # Black surfaces and misses are numbered beyond the last program.
        scatters = np.array([bool(p.closures or p.transparency) for p in programs] or [False])
        self._shaded_prim = self._by_primitive(scatters[self.materials.program_of])
        self._all_shaded = bool(self._shaded_prim[:-1].all())
        self._only_program = int(np.flatnonzero(scatters)[0]) if scatters.sum() == 1 else None
        numbers = np.where(scatters, np.arange(len(scatters)), len(programs))[self.materials.program_of]
        self._program_of_prim = self._by_primitive(numbers, miss=len(programs), dtype=np.uint16)

    def _say_what_is_missing(self, settings, diagnostics):
        programs = self.materials.programs
        if self.visibility.among_catchers is not None and settings.method != "pathtrace":
            diagnostics.warn("shadow catchers are rendered as any other object by this method")
        if self.accel.insides_missed:
            diagnostics.warn("this Blender's Embree does not show spheres of large point clouds from inside")
        if self.visibility.holdout_prim is not None and settings.method != "pathtrace":
            diagnostics.warn("objects that are holdouts are rendered as any other by this method")
        if settings.method in ("phong", "raycast") and self.transparent_prim.any():
            diagnostics.warn("transparent surfaces hide what is behind them by this method; ray tracing shows it")
        if settings.method != "pathtrace":
            self._say_what_is_not_mirrored(settings, diagnostics)
        if self.accel.strands_missed:
            diagnostics.warn("hair and curves are not rendered: Embree's curves cannot be reached here")
        cuts = settings.transparent_film and settings.method == "pathtrace"
        if not cuts and any(p.holdout is not None for p in programs):
            diagnostics.warn("holdouts are black; they cut holes only in path tracing, before a transparent film")

    def _say_what_is_not_mirrored(self, settings, diagnostics):
        """Of the classic methods: what would be black, or missing, without a word."""
        lobes = [lobe.flags for p in self.materials.programs for lobe in p.mixture.lobes if lobe.flags & _SHARP]
        sharp = any(Lobe.DIFFUSE not in flags for flags in lobes)
        if sharp and (settings.method != "raytrace" or settings.depth == 1):
            diagnostics.warn("mirrors and glass show highlights alone by this method; ray tracing shows more")
        elif sharp and 0 in (settings.glossy_bounces, settings.transmission_bounces):
            diagnostics.warn("mirrors or glass show highlights alone: their bounces are limited to 0")
        asking = Rays.CAMERA | (Rays.GLOSSY | Rays.TRANSMISSION) * (sharp and settings.method == "raytrace")
        if any(has_extent(light) and light.visibility.rays & asking for light in self.described.lights):
            diagnostics.warn("lamps are not seen by this method, neither by the camera nor in mirrors and glass")

    def _with_new_places(self, before):
        """The geometry of `before`, whose tables it takes over, where objects only moved; else None."""
        if before is None or self._needs != before._needs:
            return None
        return move(before, self.described, self._needs)

    def _with_new_materials(self, before):
        """The geometry of `before` where only materials changed, and not what they read; else None."""
        if before is None or self._needs != before._needs:
            return None
        scene, geometry = self.described, before.geometry
        materials = exchanged(before.described, scene, geometry.materials)
        if materials is None:
            return None
        objects = compile_objects(scene, geometry.origin, materials) if self._needs.objects else None
        return replace(geometry, materials=materials, objects=objects)

    def _compile_lights(self, before):
        emission = [
            (self._mean_emission(m), self.emission_at) if isinstance(e, str) else e
            for m, e in enumerate(self.materials.emission)
        ]
        world, environment = self.described.world, None
        if before is not None and before.described.world is world and not asks_for_camera(world):
            environment = copy.copy(before.lights.environment)  # of its own: it is told how often it is chosen
        programs = self.materials.programs
        clear = [m for m, n in enumerate(self.materials.program_of) if programs[n].transparency is not None]
        return compile_lights(self.described, self.geometry, emission, self.diagnostics, environment, clear)

    def _light_follows_camera(self):
        """Whether the world, or a surface that is sampled as a light, may look different to another camera."""
        shaders = self.geometry.materials if self._textured_emission else ()
        lamps = [light.nodes.shader for light in self.described.lights if light.nodes is not None]
        return any(map(asks_for_camera, (self.described.world, *lamps, *shaders)))

    def seen_by(self, camera, width, height):
        """A copy, of the same tables, for another camera; None where the light follows the camera."""
        if self._light_follows_camera():
            return None
        other = copy.copy(self)
        other.described = replace(self.described, camera=camera)
        other.geometry = replace(self.geometry, view=View(camera, width, height, self.geometry.origin))
        other._look(camera, width, height)
        return other

    def run_also(self, features):
        """Run the stages of `features` too; it changes no picture."""
        self.features |= features
        self.lights.sampler.tells_lights = Feature.VISIBILITY in self.features

    def of_catchers(self):
        """A copy, of the same tables, in which shadow catchers and their lights are alone."""
        other = copy.copy(self)
        other.visibility = self.visibility.among_catchers
        other.accel = other.visibility.all
        if self.geometry.probe is not None:
            other.geometry = replace(self.geometry, probe=Probe(other.accel, self._interact))
        return other

    def look_through(self, camera, width, height):
        """Replace the camera and the size of the frame; nothing may be traced meanwhile."""
        self.geometry.view.look_through(camera, width, height)  # one object, which the world's shader shares
        self._look(camera, width, height)

    def _look(self, camera, width, height):
        self.camera = CameraRays(camera, width, height, self.geometry.origin)
        if self.camera.has_far:
            self.needed |= Feature.FAR_CLIP
            self.features |= Feature.FAR_CLIP

    def feature_report(self):
        """Names of the features in use and left out."""
        return {"in_use": names(self.features), "left_out": names(~self.features)}

    def grouped(self, prim, arena):
        """Lanes that hit something that is not black, ordered by material program.

        Returns
        -------
        order : (n,) int
            Lanes, those of one program together.
        groups : list of (program, start, stop)
            Where each program's lanes stand in `order`.
        """
        if self._only_program is not None:
            with arena.frame():
                order = np.flatnonzero(self._is_shaded(prim, arena))
            return order, [(self._only_program, 0, order.size)]
        program = np.take(self._program_of_prim, prim, mode="wrap")
        order = np.argsort(program, kind="stable")  # a radix sort for numbers this short
        ends = np.cumsum(np.bincount(program, minlength=len(self.materials.programs) + 1))[:-1]
        starts = np.concatenate(([0], ends))[:-1]  # a scene without surfaces has neither
        groups = [(n, int(a), int(b)) for n, (a, b) in enumerate(zip(starts, ends, strict=True)) if b > a]
        return order[: groups[-1][2] if groups else 0], groups

    def _is_shaded(self, prim, arena):
        shaded = arena.empty(prim.size, bool)
        if self._all_shaded:
            return np.greater_equal(prim, 0, out=shaded)
        return np.take(self._shaded_prim, prim, out=shaded, mode="wrap")

    def interact(self, hits, o, d, arena):
        """The `Surface` that rays `o`, `d` (3, N) see at `hits`, all of which hit something."""
        wo = np.negative(d, out=arena.empty(d.shape))
        return Surface(*self._interact(hits, o, d, arena), wo, hits.u, hits.v)

    def emitted(self, surface, arena, ray=CAMERA_RAY):
        """Radiance (3, N) that leaves `surface` against the rays `ray` that see it."""
        material = arena.take(self.geometry.material, surface.prim)
        out = arena.take(self._emission_table, material)
        if not self._textured_emission:
            return out
        for number, lanes in self.materials.groups(material, arena):
            program = self.materials.programs[number]
            if program.emission is None or program.emission.is_constant:
                continue
            lanes = slice(None) if lanes is None else lanes
            part = type(surface)(*(a[..., lanes] for a in surface))
            constants = self.materials.constants(number, "emission", material[lanes], arena)
            context = Context(arena, part.prim.size, part, self.geometry, ray=ray)
            out[:, lanes] = program.emission.run(context, constants)["Le"]
        return out

    def emission_at(self, prim, u, v, arena, wo=None, ray=SCATTERED_RAY):
        """Radiance (3, N) that leaves the points `u`, `v` (N,) of triangles `prim` (N,).

        It leaves towards `wo` (3, N), unit; None is along the normal.
        """
        if not self._textured_emission:
            return arena.take(self._emission_table, arena.take(self.geometry.material, prim))
        if wo is None:
            wo = np.take(self.geometry.facets[:, NORMAL], prim, axis=0).T
        d = np.negative(wo, out=arena.empty(wo.shape))
        o = t = None
        if self.needs_rays:  # though triangles do not
            o, t = arena.zeros(d.shape), arena.zeros(prim.size)
        return self.emitted(self.interact(Hits(t, prim, u, v), o, d, arena), arena, ray)

    def _mean_emission(self, m):
        """Mean radiance (3,) of textured material number `m` over some points of its triangles' brighter side."""
        prims = np.flatnonzero(self.geometry.material[: self.geometry.triangle_count] == m).astype(np.int32)
        if prims.size == 0:
            return np.zeros(3, np.float32)
        rng = np.random.default_rng(0)
        u, v = rng.random((2, _MEAN_POINTS), np.float32)
        folded = u + v > 1
        u, v = np.where(folded, 1 - u, u), np.where(folded, 1 - v, v)
        prim = prims[rng.integers(prims.size, size=_MEAN_POINTS)]
        normal = np.take(self.geometry.facets[:, NORMAL], prim, axis=0).T
        with np.errstate(over="ignore", invalid="ignore"):  # what is not finite goes through
            front, back = (self.emission_at(prim, u, v, Arena(), wo).mean(axis=1) for wo in (normal, -normal))
            return np.where(np.abs(back).sum() > np.abs(front).sum(), back, front)

    def _by_primitive(self, of_material, miss=False, dtype=bool):
        """A per-material table spread over primitives, and `miss` at its end."""
        of_material, table = np.asarray(of_material, dtype), np.full(self.geometry.count + 1, miss, dtype)
        if of_material.size and (of_material == of_material[0]).all():
            table[:-1] = of_material[0]
        else:
            np.take(of_material, self.geometry.material, out=table[:-1], mode="clip")
        return table


def compile_scene(scene, settings, diagnostics, force_features=None, before=None, editable=False):
    """Compile a `core.scene.Scene`.

    Parameters
    ----------
    scene : Scene
    settings : Settings
    diagnostics : Diagnostics
        Takes what the user must be told.
    force_features : Feature, optional
        Run these stages instead of those needed; a superset gives the same picture, bit for bit.
    before : CompiledScene, optional
        Of another frame or moment. Its tables serve again where meshes and materials are the same objects and nothing
        else changed; the picture is the same, bit for bit.
    editable : bool
        The scene is going to be a `before` whose objects move, and be of no use then: Embree builds a tree for each
        object, and tables are changed in place. Then pictures may differ by rounding.

    Raises
    ------
    SceneError
        When the scene cannot be rendered.
    """
    return CompiledScene(scene, settings, diagnostics, force_features, before, editable)


def _are(some, others):
    """Whether two sequences hold the same objects."""
    return len(some) == len(others) and all(a is b for a, b in zip(some, others, strict=True))


def _materials_of(scene):
    found = {m for i in scene.instances for m in i.materials}
    found |= {x.material for x in (*scene.spheres, *scene.curves, *scene.planes)}
    return [m for m in found if m is not None]


__all__ = ["CompiledScene", "Feature", "compile_scene"]
