# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials to programs: structurally equal graphs share one, and each material has a row of constants.

A program has three separate codes, so that each user pays for what it needs: `scatter` for surfaces that are shaded,
`emission` for light, `transparency` for rays that may pass straight through.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arena import Arena
from ..bsdf.mixture import Mixture
from ..nodes.base import Context, as_vector
from ..nodes.closures import CLOSURES
from ..scene import Link
from .graph import Builder, Code, Const, post_order


@dataclass(eq=False)
class Program:
    """What all materials of one structure do.

    Parameters
    ----------
    closures : tuple of (Closure, {layer: lobe}, properties)
        What scatters.
    scatter, emission, transparency : Code or None
        None where the material does no such thing.
    """

    closures: tuple
    scatter: Code
    emission: Code | None
    transparency: Code | None

    def __post_init__(self):
        self.mixture = Mixture(lobe for _, lobes, _ in self.closures for lobe in lobes.values())

    def lobes_over(self, context, constants):
        """[(lobe, weight, params, n)] of the lanes, in the order of `mixture.lobes`."""
        values = self.scatter.run(context, constants)
        found = []
        for number, (closure, lobes, properties) in enumerate(self.closures):
            inputs = {name: v for (owner, name), v in values.items() if owner == number}
            weight = inputs.pop("weight")
            for lobe, color, params, n in closure.build(context, inputs, lobes, properties):
                found.append((lobe, _scaled(color, weight, context.arena), params, n))
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
        """Constants of code `kind` of program `number` for lanes of the given `material` (N,); (C, 1) when shared."""
        table = self._tables[number][kind]
        if table.shape[1] == 1 or table.shape[0] == 0:
            return table
        return arena.take(table, arena.take(self.row_of, material))

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
        if number == len(programs):
            programs.append(program)
            rows.append({"scatter": [], "emission": [], "transparency": []})
        for kind, kept in rows[number].items():
            code = getattr(program, kind)
            kept.append(code.row if code else np.zeros(0, np.float32))
        program_of[m], row_of[m] = number, len(rows[number]["scatter"]) - 1
    tables = [{kind: _table(kept) for kind, kept in group.items()} for group in rows]
    compiled = Materials(tuple(programs), program_of, row_of, [], tables)
    compiled.emission = [_emission(compiled, m) for m in range(len(materials))]
    return compiled


def uv_maps_of(materials):
    """Names of the UV maps that materials may read, a set; "" is the active one."""
    names = set()
    for material in materials:
        for node in material.nodes:
            if node.op == "uv_map":
                names.add(node.properties.get("uv_map", ""))
            elif node.op in ("tex_coord", "image", "checker"):
                names.add("")
    return names


def compile_program(material, diagnostics, subject="material"):
    """The `Program` of a material or world, and a key that is equal for programs that do the same."""
    builder = Builder(material, diagnostics, subject)
    scatter, emission, transparency, closures = {}, [], [], []
    for closure, weight, inputs, properties in _closures(material, builder):
        constants = {name: v.value for name, v in inputs.items() if isinstance(v, Const)}
        linked = set(inputs) - set(constants)
        closure.diagnose(constants, linked, diagnostics, builder.place)
        if "normal" in linked:
            diagnostics.warn(f"{closure.name}: a linked normal is not supported and has no effect", builder.place)
        lobes = closure.lobes(constants, properties)
        if lobes:
            number = len(closures)
            closures.append((closure, lobes, properties))
            scatter |= {(number, name): v for name, v in inputs.items() if name != "normal"}
            scatter[number, "weight"] = weight
        emission += _product(builder, weight, closure.emission, inputs)
        transparency += _product(builder, weight, closure.transparency, inputs)
    code = Code(builder, scatter)
    light, clear = _sum(builder, emission), _sum(builder, transparency)
    light = Code(builder, {"Le": light}) if light is not None else None
    clear = Code(builder, {"T": clear}) if clear is not None else None
    structure = tuple(
        (c.name, tuple((layer, id(lobe)) for layer, lobe in lobes.items()), properties.get("distribution"))
        for c, lobes, properties in closures
    )
    key = (structure, code.key, light and light.key, clear and clear.key)
    return Program(tuple(closures), code, light, clear), key


def _closures(material, builder):
    """Yield (closure, weight, inputs, properties) of every closure that reaches the surface with some weight."""
    if material.surface is None:
        return
    nodes = material.nodes
    order = post_order(nodes, material.surface)
    for index in order:  # every node once, from the leaves, so that no call nests as deep as the graph
        if nodes[index].op not in CLOSURES and nodes[index].op not in ("mix_shader", "add_shader"):
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
    return closure, weight, {name: v for name, v in inputs.items() if v is not None}, dict(node.properties)


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


def _table(rows):
    """Rows of one program as columns (C, rows)."""
    return np.ascontiguousarray(np.array(rows, np.float32).reshape(len(rows), -1).T)


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
