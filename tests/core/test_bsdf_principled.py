# SPDX-License-Identifier: GPL-3.0-or-later
"""Principled's upper layers: Cycles' albedos, energy, what a program is spared, normals and tangents."""

import numpy as np
import pytest

from zraka.core.arena import Arena
from zraka.core.bsdf import (
    coating,
    dielectric,
    diffuse,
    facets,
    glass_film,
    glossy,
    metal,
    oren_nayar,
    principled,
    sheen,
)
from zraka.core.bsdf.mixture import Mixture
from zraka.core.compile.materials import compile_materials
from zraka.core.diagnostics import Diagnostics
from zraka.core.nodes.base import Context
from zraka.core.scene import Material, Node
from zraka.tests import stat

from .test_bsdf_mixture import f32, furnace, numbers, rgb, surface

BASE = {"base_color": (0.8, 0.5, 0.2), "roughness": 0.4}
COATED = {"coat_weight": 1.0, "coat_roughness": 0.3}
TINTED = {"coat_weight": 0.5, "coat_roughness": 0.0, "coat_ior": 1.8, "coat_tint": (0.9, 0.4, 0.2)}
CLOTH = {"sheen_weight": 1.0, "sheen_roughness": 0.4, "sheen_tint": (1.0, 0.6, 0.3)}
BOTH = {"sheen_weight": 0.7, "sheen_roughness": 0.8, "coat_weight": 0.6, "coat_roughness": 0.2}
METAL = {"thin_film_thickness": 300.0, "metallic": 1.0}
GLASS = {"thin_film_thickness": 300.0, "transmission_weight": 1.0}
CYCLES = [  # inputs, cosine, radiance in a white world as Cycles of Blender 5.0 renders it
    (COATED, 0.8, (0.8172, 0.5431, 0.2690)),
    (COATED, 0.3, (0.8566, 0.6449, 0.4332)),
    (TINTED, 0.8, (0.7760, 0.3873, 0.1760)),
    (TINTED, 0.3, (0.8045, 0.4578, 0.2815)),
    (CLOTH, 0.8, (0.8115, 0.5230, 0.2360)),
    (CLOTH, 0.3, (0.8646, 0.5757, 0.3090)),
    (BOTH, 0.8, (0.8453, 0.6132, 0.3811)),
    (BOTH, 0.3, (0.9009, 0.7548, 0.6087)),
    ({"thin_film_thickness": 400.0}, 0.8, (0.7759, 0.5081, 0.2302)),
    ({"thin_film_thickness": 400.0}, 0.3, (0.7811, 0.5016, 0.2699)),
    (METAL, 0.8, (0.7749, 0.3242, 0.1570)),
    (METAL, 0.3, (0.7471, 0.4941, 0.1818)),
    (GLASS, 0.8, (0.8982, 0.7121, 0.4535)),
    (GLASS, 0.3, (0.9062, 0.7388, 0.4967)),
]

FILM = {"thin_film_thickness": 400.0}
ROUGH_COAT = {"coat_weight": 1.0, "coat_roughness": 0.6}
CYCLES_4_2 = [  # as above, of Blender 4.2
    (ROUGH_COAT, 0.8, (0.8103, 0.5361, 0.2619)),
    (ROUGH_COAT, 0.3, (0.7355, 0.5317, 0.3279)),
    (FILM, 0.8, (0.7722, 0.5089, 0.2301)),
    (FILM, 0.3, (0.7788, 0.4983, 0.2682)),
    (METAL, 0.8, (0.7938, 0.4904, 0.1945)),
    (METAL, 0.3, (0.8033, 0.5243, 0.2633)),
    (GLASS, 0.3, (0.9065, 0.7387, 0.4969)),
    ({"thin_film_thickness": 15.0, "thin_film_ior": 2.5}, 0.8, (0.8066, 0.5245, 0.2433)),
    ({"thin_film_thickness": 15.0, "thin_film_ior": 2.5}, 0.3, (0.7881, 0.5486, 0.3098)),
]


def arrays(inputs):
    return {name: rgb(*v) if isinstance(v, tuple) else f32(v) for name, v in inputs.items()}


def expanded(inputs, degrees, count=1 << 15, **more):
    seen = surface(degrees, count)
    return principled.expand(arrays(inputs), np.full(count, True), seen.wo, seen.ns, Arena(), **more)


@pytest.mark.parametrize(("inputs", "cosine", "truth"), CYCLES)
def test_layers_as_cycles(inputs, cosine, truth):
    degrees = float(np.degrees(np.arccos(cosine)))
    mean, error = furnace(expanded(BASE | inputs, degrees), degrees)
    assert (np.abs(mean - truth) < 0.01 * np.array(truth) + 3 * error).all()


@pytest.mark.parametrize(("inputs", "cosine", "truth"), CYCLES_4_2)
def test_layers_as_an_older_cycles(inputs, cosine, truth):
    degrees = float(np.degrees(np.arccos(cosine)))
    mean, error = furnace(expanded(BASE | inputs, degrees, older=("coat", "film")), degrees)
    assert (np.abs(mean - truth) < 0.01 * np.array(truth) + 3 * error).all()


@pytest.mark.parametrize("inputs", [COATED, TINTED, CLOTH, BOTH, METAL, GLASS])
@pytest.mark.parametrize("degrees", [0.0, 60.0, 85.0])
def test_a_white_base_makes_no_energy(inputs, degrees):
    mean, error = furnace(expanded(inputs | {"base_color": (1.0, 1.0, 1.0)}, degrees), degrees)
    assert (mean < 1.005 + 3 * error).all()


@pytest.mark.parametrize("degrees", [20.0, 75.0])
def test_samples_follow_the_density(degrees):
    inputs = arrays(BASE | BOTH | {"metallic": 0.3, "anisotropic": 0.7})
    lobes = list(
        principled.lobes_of(principled.DEFAULTS | BASE | BOTH | {"metallic": 0.3, "anisotropic": 0.7}).values()
    )
    mix, tangent = Mixture(lobes), rgb(1.0, 0.3, 0.0)

    def entries(count, arena):
        seen = surface(degrees, count)
        front = np.full(count, True)
        return principled.expand(inputs, front, seen.wo, seen.ns, arena, tangent=tangent), seen

    def sample(u, arena):
        found, seen = entries(u.shape[1], arena)
        s = mix.sample(found, seen, *u, arena)
        return s.wi, s.pdf

    def density(wi, arena):
        found, seen = entries(wi.shape[1], arena)
        return mix.eval_pdf(found, seen, wi, arena)[1]

    assert stat.check_sampler(sample, density, 60_000) > stat.sidak(stat.LEVEL, 2)


def test_only_the_lobes_that_are_asked_for():
    lobes_of = lambda **inputs: principled.lobes_of(principled.DEFAULTS | inputs)  # noqa: E731
    assert list(lobes_of(sheen_weight=0.1)) == ["sheen", "specular", "diffuse"]
    assert lobes_of(coat_weight=0.1)["coat"] is dielectric.Rough
    assert lobes_of(coat_weight=0.1, coat_roughness=0.0)["coat"] is dielectric.Mirror
    assert lobes_of(anisotropic=0.5)["specular"] is facets.reflection(facets.GGX, dielectric.reflectance)
    assert issubclass(lobes_of(anisotropic=0.5, roughness=0.0)["specular"], glossy.Mirror)
    filmed = lobes_of(thin_film_thickness=300.0, metallic=0.5, transmission_weight=0.5)
    assert filmed["metallic"] is metal.lobes(metal.f82_film)[0]
    assert filmed["transmission"] is glass_film.Rough
    assert lobes_of(subsurface_weight=1.0) == lobes_of()
    assert lobes_of(subsurface_weight=1.0, diffuse_roughness=0.5)["subsurface"] is diffuse


def test_only_the_inputs_that_are_read():
    assert principled.inputs_of(principled.lobes_of(principled.DEFAULTS)) == {
        "alpha", "ior", "specular_ior_level", "roughness", "specular_tint", "base_color",
    }  # fmt: skip
    assert "thin_film_ior" in principled.inputs_of({"specular": metal.lobes(metal.dielectric_film)[0]})
    assert "anisotropic" in principled.inputs_of({"metallic": facets.reflection(facets.GGX, metal.f82_film)})
    assert "diffuse_roughness" in principled.inputs_of({"diffuse": oren_nayar})


def test_a_coat_has_its_own_normal():
    seen = surface(30.0, 64)
    tilted = surface(30.0, 64, (0.3, 0.0, 1.0)).ns
    inputs = arrays(BASE | BOTH)
    front = np.full(64, True)
    mixed = coating.sheen_normal({"coat_weight": f32(0.6)}, seen.ns, tilted, Arena())
    normals = {"coat_normal": tilted, "sheen_normal": mixed}
    entries = principled.expand(inputs, front, seen.wo, seen.ns, Arena(), **normals)
    by_lobe = {entry[0]: entry[3] for entry in entries[:2]}
    assert by_lobe[dielectric.Rough] is tilted
    assert by_lobe[sheen] is mixed
    assert 0 < mixed[0, 0] < tilted[0, 0]
    assert all(entry[3] is None for entry in entries[2:])


def test_a_tangent_turns_with_its_rotation():
    seen = surface(0.0, 4)
    front = np.full(4, True)

    def tangent_of(turns):
        inputs = arrays({"metallic": 1.0, "anisotropic": 0.5, "anisotropic_rotation": turns})
        (entry,) = principled.expand(inputs, front, seen.wo, seen.ns, Arena(), tangent=rgb(1, 0, 0))
        return np.broadcast_to(entry[2]["tangent"], (3, 4))[:, 0]

    assert tangent_of(0.0) == pytest.approx([1, 0, 0], abs=1e-6)
    assert tangent_of(0.25) == pytest.approx([0, 1, 0], abs=1e-6)


def test_emission_is_seen_through_its_cover():
    """Lit from below, a coat of tint 0.5 lets through half of what its own reflection leaves, seen straight."""
    material = Material.principled("Lamp", emission_strength=2.0, coat_weight=1.0, coat_tint=(0.5, 0.5, 0.5))
    plain = Material.principled("Plain", emission_strength=2.0)
    compiled = compile_materials((material, plain), Diagnostics())
    seen, arena = surface(0.0, 1), Arena()
    code = compiled.programs[0].emission
    row = compiled.constants(0, "emission", np.zeros(1, np.int32), arena)
    value = code.run(Context(arena, 1, seen), row)["Le"]
    assert value[:, 0] == pytest.approx(2.0 * 0.5 * (1 - 0.04), rel=0.01)
    assert compiled.emission[0] == "textured" and compiled.emission[1] == pytest.approx([2.0] * 3)


@pytest.mark.parametrize(("older", "truth"), [((), 1.1305), (("coat",), 0.9544)])
def test_a_rough_coat_dims_what_glows_below_it(older, truth):
    """Both as Cycles of 4.5 and of 4.2 show a black surface that emits 1, at cosine 0.3 in a white world."""
    inputs = {"base_color": (0.0, 0.0, 0.0), "roughness": 0.4, "coat_weight": 1.0, "coat_roughness": 0.8}
    node = Node("principled", inputs | {"emission_strength": 1.0}, {"older": older})
    compiled = compile_materials((Material("Lamp", (node,), 0),), Diagnostics())
    degrees, arena = float(np.degrees(np.arccos(0.3))), Arena()
    row = compiled.constants(0, "emission", np.zeros(1, np.int32), arena)
    glow = compiled.programs[0].emission.run(Context(arena, 1, surface(degrees, 1)), row)["Le"][:, 0]
    reflected, error = furnace(expanded(inputs, degrees, older=older), degrees)
    assert (np.abs(glow + reflected - truth) < 0.003 + 3 * error).all()


def test_a_layer_that_varies_is_there_where_it_is_wanted():
    """Sheen of weight 0 in a lane leaves the layers below as they are."""
    count = 4096
    seen, front = surface(70.0, count), np.full(count, True)
    inputs = arrays(BASE)
    inputs["sheen_weight"] = (np.arange(count) % 2).astype(np.float32)
    constants = {k: v for k, v in (principled.DEFAULTS | BASE).items() if k != "sheen_weight"}
    lobes = principled.lobes_of(constants)
    entries = principled.expand(inputs, front, seen.wo, seen.ns, Arena(), lobes)
    plain = principled.expand(arrays(BASE), front, seen.wo, seen.ns, Arena())
    for (lobe, weight, *_), (other, bare, *_) in zip(entries[1:], plain, strict=True):
        assert lobe is other
        weight, bare = np.broadcast_to(weight, (3, count)), np.broadcast_to(bare, (3, count))
        assert np.allclose(weight[:, ::2], bare[:, ::2], rtol=1e-6)
        assert (weight[:, 1::2] < bare[:, 1::2]).all()
    assert not entries[0][1][:, ::2].any()
    s = Mixture(lobes.values()).sample(entries, seen, *numbers(count), Arena())
    assert np.isfinite(s.weight).all()
