# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials to programs: structurally equal graphs share one, and each material has a row of constants.

A program has three separate codes, so that each user pays for what it needs: `scatter` for surfaces that are shaded,
`emission` for light, `transparency` for rays that may pass straight through.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from ..arena import Arena
from ..bsdf import diffuse, toon
from ..bsdf.base import Lobe
from ..bsdf.bumped import SMOOTH, bumped
from ..bsdf.mixture import UNTESTED, Mixture
from ..bsdf.shading_normal import lifted_normal, unit_normal
from ..nodes import OPERATIONS
from ..nodes.base import Context, as_vector
from ..nodes.closure import RAW_NORMAL, UNTURNED_NORMAL, on_strands, raised_normal
from ..nodes.closures import CLOSURES
from ..scene import Link, Node
from .angular import tabulate
from .code import Code, Table
from .graph import Builder, Const, dimension_of, post_order

_OWN = ("weight", "normal", "base_normal")  # inputs that are not the closure's alone


@dataclass(eq=False)
class Program:
    """What all materials of one structure do.

    Parameters
    ----------
    closures : tuple of (Closure, {layer: lobe}, properties)
        What scatters.
    scatter, emission, transparency, holdout : Code or None
        None where the material does no such thing.
    """

    closures: tuple
    scatter: Code
    emission: Code | None
    transparency: Code | None
    holdout: Code | None = None

    def __post_init__(self):
        self.mixture = Mixture(lobe for _, lobes, _ in self.closures for lobe in lobes.values())
        self._tables = [None] * len(self.closures)
        self._wanted = None

    @property
    def operations(self):
        """Names of all operations that some code of it runs."""
        return frozenset().union(
            *(c.operations for c in (self.scatter, self.emission, self.transparency, self.holdout) if c)
        )

    def tabulate(self, table):
        """Tabulate the closures that follow from material and angle; `table` (C, M) are the constants of all materials.

        The constants of these closures are then asked for no more.
        """
        wanted = set(self.scatter.results)
        for number, (closure, lobes, properties) in enumerate(self.closures):
            inputs = {name: place for (owner, name), place in self.scatter.results.items() if owner == number}
            if closure.by_angle is None or not closure.by_angle(lobes, inputs):
                continue
            constants = {
                name: self.scatter.constant(place, table) for name, place in inputs.items() if name not in _OWN
            }
            varying = [name for name, value in constants.items() if value is None]
            if varying in ([], [closure.color]):
                known = {name: value for name, value in constants.items() if value is not None}
                self._tables[number] = tabulate(closure, lobes, properties, known, *varying)
            if self._tables[number] is not None:
                wanted -= {(number, name) for name in known}
        self._wanted = wanted

    def follows_angle(self, smooth):
        """Whether its lobes follow from the material, the angle and the side of view; `smooth`: on smooth normals."""
        if not self.scatter.is_constant or not (self.transparency is None or self.transparency.is_constant):
            return False
        if any(name in ("normal", "base_normal") for _, name in self.scatter.results):
            return False
        for (_, lobes, _), table in zip(self.closures, self._tables, strict=True):
            if table is None and any(lobe is not diffuse for lobe in lobes.values()):
                return False
            if smooth and any(map(_is_lifted, lobes.values())):
                return False
        return True

    def lobes_over(self, context, constants):
        """[(lobe, weight, params, n)] of the lanes, in the order of `mixture.lobes`."""
        with np.errstate(all="ignore"):  # what is not finite goes through
            return self._lobes_over(context, constants)

    def _lobes_over(self, context, constants):
        values = self.scatter.run(context, constants, self._wanted)
        found, lifted = [], None
        for number, (closure, lobes, properties) in enumerate(self.closures):
            inputs = {name: v for (owner, name), v in values.items() if owner == number}
            weight = inputs.pop("weight")
            turned, given = inputs.pop("normal", None), inputs.pop("base_normal", None)
            build = partial(closure.build, lobes=lobes, properties=properties)
            if self._tables[number] is not None:
                build = partial(self._tables[number].build, rows=constants.rows)
            if turned is not None or given is not None:
                entries = _on_normals(build, context, inputs, lobes, turned, given, properties)
            elif _is_flat(context.surface) or "uncorrected" in properties or not any(map(_is_lifted, lobes.values())):
                entries = build(context, inputs)
            else:
                s = context.surface
                lifted = lifted_normal(s.ns, s.ng, s.wo, context.arena) if lifted is None else lifted
                entries = _on_lifted(build, context, inputs, lifted)
            found += [(lobe, _scaled(color, weight, context.arena), params, n) for lobe, color, params, n in entries]
        return found


@dataclass(eq=False)
class Materials:
    """All programs of a scene and where each material stands.

    Parameters
    ----------
    programs : tuple of Program
    program_of, row_of : (M,) int32
        Program and row of constants of each material.
    emission : list
        Of each material: None, constant radiance (3,) or "textured".
    """

    programs: tuple
    program_of: np.ndarray
    row_of: np.ndarray
    emission: list
    _tables: list

    def constants(self, number, kind, material, arena):
        """`Constants` of code `kind` of program `number` for lanes of the given `material` (N,)."""
        return self._tables[number][kind].over(arena.take(self.row_of, material), arena)

    def groups(self, material, arena):
        """Yield (program number, lanes) of the programs that occur; lanes is None when there is one program."""
        if len(self.programs) == 1:
            yield 0, None
            return
        program = arena.take(self.program_of, material)
        for number in range(len(self.programs)):
            lanes = np.flatnonzero(program == number)
            if lanes.size:
                yield number, lanes


def compile_materials(materials, diagnostics):
    """Compile a tuple of `core.scene.Material`; returns `Materials`."""
    programs, rows, known = [], [], {}
    program_of, row_of = np.zeros(len(materials), np.int32), np.zeros(len(materials), np.int32)
    for m, material in enumerate(materials):
        program, key = compile_program(material, diagnostics)
        number = known.setdefault(key, len(programs))
        is_new = number == len(programs)
        if is_new:
            programs.append(program)
            rows.append({"scatter": [], "emission": [], "transparency": [], "holdout": []})
        for kind, kept in rows[number].items():
            code = getattr(program, kind)
            kept.append(code.row if code else np.zeros(0, np.float32))
            if code and not is_new:
                getattr(programs[number], kind).adopt(code)
        program_of[m], row_of[m] = number, len(rows[number]["scatter"]) - 1
    tables = [{kind: Table(kept) for kind, kept in group.items()} for group in rows]
    for program, table in zip(programs, tables, strict=True):
        program.tabulate(table["scatter"].values)
    compiled = Materials(tuple(programs), program_of, row_of, [], tables)
    compiled.emission = [_emission(compiled, m) for m in range(len(materials))]
    return compiled


def compile_program(material, diagnostics, subject="material"):
    """The `Program` of a material or world, and a key that is equal for programs that do the same."""
    builder = Builder(material, diagnostics, subject)
    builder.normal = _displaced_normal(material, builder)
    scatter, emission, transparency, holdout, closures, dimensions = {}, [], [], [], [], {}
    for found in _closures(material, builder):
        closure, weight, inputs, properties = found
        constants = {name: v.value for name, v in inputs.items() if isinstance(v, Const)}
        linked = set(inputs) - set(constants)
        closure.diagnose(constants, linked, properties, diagnostics, builder.place)
        lobes = closure.lobes(constants, properties)
        if not getattr(material, "bump_correction", True):
            properties["uncorrected"] = True
        properties["older"] = (*properties.get("older", ()), *getattr(material, "older", ()))
        if lobes:
            number = len(closures)
            closures.append((closure, lobes, properties))
            used = inputs if closure.used is None else closure.used(lobes) | {"base_normal"}
            scatter |= {(number, name): v for name, v in inputs.items() if name in used}
            scatter[number, "weight"] = weight
            dimensions |= {(number, name): dimension_of(name, default) for name, default in closure.inputs.items()}
            dimensions[number, "weight"] = 1
        emission += _covered(builder, found, constants, _product(builder, weight, closure.emission, inputs))
        transparency += _product(builder, weight, closure.transparency, inputs)
        holdout += [weight] if closure.is_holdout else []
    code = Code(builder, scatter, dimensions)
    light, clear, hole = _sum(builder, emission), _sum(builder, transparency), _sum(builder, holdout)
    light = Code(builder, {"Le": light}) if light is not None else None
    clear = Code(builder, {"T": clear}) if clear is not None else None
    hole = Code(builder, {"H": hole}) if hole is not None else None
    structure = tuple(
        (
            c.name,
            tuple((layer, id(lobe)) for layer, lobe in lobes.items()),
            properties.get("distribution"),
            properties.get("older"),
            properties.get("uncorrected"),
        )
        for c, lobes, properties in closures
    )
    key = (structure, code.key, light and light.key, clear and clear.key, hole and hole.key)
    return Program(tuple(closures), code, light, clear, hole), key


def _closures(material, builder):
    """Yield (closure, weight, inputs, properties) of every closure that reaches the surface with some weight."""
    if material.surface is None:
        return
    nodes = material.nodes
    order = post_order(nodes, material.surface)
    for index in order:  # every node once, from the leaves, so that no call nests as deep as the graph
        if nodes[index].op in OPERATIONS and nodes[index].op not in CLOSURES:
            builder.node_outputs(index)
    weights = {material.surface: Const(as_vector(1.0))}
    for index in reversed(order):
        weight, node = weights.get(index), nodes[index]
        if weight is None or _is_zero(weight):
            continue
        if node.op == "add_shader":
            shares = {"a": weight, "b": weight}
        elif node.op == "mix_shader":
            fac = builder.value(node.inputs.get("fac"), 0.5)
            fac = builder.emit("clamp", a=fac)
            shares = {
                "a": _times(builder, weight, builder.emit("complement", a=fac)),
                "b": _times(builder, weight, fac),
            }
        else:
            yield _leaf(node, weight, builder)
            continue
        for name, share in shares.items():
            link = node.inputs.get(name)
            if isinstance(link, Link):
                before = weights.get(link.node)
                weights[link.node] = share if before is None else builder.emit("add", a=before, b=share)


def _leaf(node, weight, builder):
    closure = CLOSURES.get(node.op)
    if closure is None:
        label = node.properties.get("label", node.op)
        builder.diagnostics.warn(f"shader '{label}' is not supported; a grey diffuse surface is shown", builder.place)
        return CLOSURES["diffuse"], weight, {"color": Const(as_vector(0.8)), "roughness": Const(as_vector(0.0))}, {}
    inputs = {name: builder.value(node.inputs.get(name), default) for name, default in closure.inputs.items()}
    if "normal" in inputs and inputs["normal"] is None:
        inputs["base_normal"] = builder.normal
    return closure, weight, {name: v for name, v in inputs.items() if v is not None}, dict(node.properties)


def _displaced_normal(material, builder):
    """The normal of a surface that the material moves, None where it moves nothing."""
    link = getattr(material, "displacement", None)
    if link is None:
        return None
    for index in post_order(material.nodes, link.node):
        builder.node_outputs(index)
    if isinstance(builder.value(link, (0.0, 0.0, 0.0)), Const):
        return None
    inputs = {"displacement": link, "filter_width": material.displacement_step}
    return builder.visit(Node("displaced_normal", inputs)).get("normal")


def _is_diffuse(lobe):
    return lobe.flags == Lobe.REFLECTION | Lobe.DIFFUSE


def _is_flat(surface):
    return surface is None or surface.ns is surface.ng


def _is_lifted(lobe):
    """Whether a lobe stands on a normal that mirrors the viewer's ray to above the surface, as in Cycles."""
    return not _is_diffuse(lobe) and lobe is not toon.Glossy


def _on_lifted(build, context, inputs, lifted):
    """What `build` makes of a smooth surface: diffuse reflection on its normal as it is, the rest on the `lifted` one.

    Without it half of the light would be lost near the outlines of coarse smooth meshes.
    """
    raw = context.surface.ns
    entries = build(replace(context, surface=context.surface._replace(ns=lifted)), inputs | {RAW_NORMAL: raw})
    for lobe, color, params, own in entries:
        yield lobe, color, params, lifted if own is None and _is_lifted(lobe) else own


def _on_normals(build, context, inputs, lobes, turned, given, properties):
    """What `build` makes on the normal `turned` by a node, or, where that is None, on the surface's displaced one.

    Diffuse reflection takes the normal as it is, the rest one that mirrors the viewer's ray to above the surface. Where
    a node has turned it, diffuse reflection is softened. All this is as in Cycles, and so is what is left of it where
    the user wants no correction: diffuse reflection does not reach behind the surface. Hair knows nothing of it: all
    takes the normal as it is, and light is not asked from which side of the strand it comes (it was before 5.0).
    """
    s, arena = context.surface, context.arena
    is_corrected, older = "uncorrected" not in properties, properties.get("older", ())
    raw = unit_normal(given if turned is None else turned, s.ns, arena)
    n = raised_normal(context, raw) if is_corrected and any(map(_is_lifted, lobes.values())) else raw
    hair, as_meshes = on_strands(context), "strands" in older
    more = {RAW_NORMAL: raw}
    if turned is not None:
        more[UNTURNED_NORMAL] = s.ns if given is None else unit_normal(given, s.ns, arena)
    entries = build(replace(context, surface=s._replace(ns=n)), inputs | more)
    for lobe, color, params, own in entries:
        normal = own if own is not None else n if _is_lifted(lobe) else raw
        if hair is not None and not (as_meshes and Lobe.GLOSSY in lobe.flags):
            params = params | {UNTESTED: hair}
        if turned is None or not _is_diffuse(lobe):
            yield lobe, color, params, normal
        else:
            smooth = s.ns if hair is None or as_meshes else np.where(hair, normal, s.ns)
            yield bumped(lobe, is_corrected, "softening" in older), color, params | {SMOOTH: smooth}, normal


def _product(builder, weight, factors, inputs):
    """[weight times the named inputs], or [] when it is always zero; "1-x" is the complement of x."""
    if not factors:
        return []
    value = weight
    for factor in factors:
        name = factor.removeprefix("1-")
        part = inputs[name]
        if name != factor:
            part = builder.emit("complement", a=part)
        value = _times(builder, value, part)
    return [] if _is_zero(value) else [value]


def _covered(builder, found, constants, values):
    """`values` as they are seen through what lies over them in the closure that was `found`."""
    closure, _, inputs, properties = found
    cover = closure.cover(constants, properties) if closure.cover and values else None
    if cover is None:
        return values
    operation, names = cover
    share = builder.emit(operation, **{name: inputs[name] for name in names if name in inputs})
    return [_times(builder, value, share) for value in values]


def _sum(builder, values):
    total = None
    for value in values:
        total = value if total is None else builder.emit("add", a=total, b=value)
    return total


def _times(builder, a, b):
    if _is_zero(a) or _is_zero(b):
        return Const(as_vector(0.0))
    return b if _is_one(a) else a if _is_one(b) else builder.emit("multiply", a=a, b=b)


def _is_zero(value):
    return isinstance(value, Const) and not value.value.any()


def _is_one(value):
    return isinstance(value, Const) and value.value.size == 1 and bool((value.value == 1).all())


def _scaled(color, weight, arena):
    """Color · weight; a weight of constant 1 costs nothing."""
    if weight.size == 1 and weight.reshape(-1)[0] == 1:
        return color
    return np.multiply(color, weight, out=arena.empty((3, max(color.shape[-1], weight.shape[-1]))))


def _emission(materials, m):
    """None, constant radiance (3,) or "textured"."""
    program = materials.programs[materials.program_of[m]]
    if program.emission is None:
        return None
    if program.emission.is_constant:
        row = materials.constants(materials.program_of[m], "emission", np.array([m], np.int32), Arena(4096))
        value = program.emission.run(Context(Arena(4096), 1), row)["Le"]
        return np.broadcast_to(value.reshape(-1, 1), (3, 1))[:, 0].astype(np.float32)
    return "textured"
