# SPDX-License-Identifier: GPL-3.0-or-later
"""Straight-line code over lanes, shared by the materials whose graphs are built alike."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from ..nodes import OPERATIONS
from ..nodes.convert import to_dimension
from ..nodes.displaced import beside
from .graph import Register, dimension_of, live, property_key

# A graph of thousands of nodes is run over few lanes at a time, so that its memory stays bounded.
_MOST_VALUES, _FEWEST_LANES = 1 << 24, 1 << 10


class Table:
    """Constants of all materials of one code.

    Parameters
    ----------
    rows : sequence of (C,) float32
        Of each material.
    """

    def __init__(self, rows):
        self.values = np.ascontiguousarray(np.array(rows, np.float32).reshape(len(rows), -1).T)
        self.is_same = (self.values == self.values[:, :1]).all(axis=1).tolist()

    def over(self, rows, arena):
        """`Constants` of the materials `rows` (N,)."""
        return Constants(self, rows if self.values.shape[1] > 1 else None, arena)


class Constants:
    """Constants over lanes; what is the same for all materials stays constant.

    Parameters
    ----------
    table : Table
    rows : (N,) int32 or None
        None where there is one material.
    arena : Arena
    """

    def __init__(self, table, rows, arena):
        self._table, self.rows, self._arena = table, rows, arena

    @property
    def shape(self):
        """(C, N), or (C, 1)."""
        return len(self._table.values), 1 if self.rows is None else self.rows.size

    def __getitem__(self, index):
        """Number or slice `index` of the constants, (N,) or (·, N); with a slice of lanes, `Constants` of these."""
        if isinstance(index, tuple):
            return Constants(self._table, self.rows[index[1]], self._arena)
        part, same = self._table.values[index], self._table.is_same[index]
        if self.rows is None or (all(same) if isinstance(index, slice) else same):
            return part[..., :1]
        return self._arena.take(part, self.rows)


class Code:
    """Straight-line code that computes `results` of a builder, with constants in a table.

    Materials share it whose graphs differ in constants, pictures and tables alone.

    Parameters
    ----------
    builder : Builder
    results : mapping of hashable to Const or Register
    dimensions : mapping of hashable to int, optional
        Rows that results are to have; others stay as they come.

    Attributes
    ----------
    operations : frozenset of str
        Names of those that run.
    """

    def __init__(self, builder, results, dimensions=None):
        self._constants = []
        self._slots = 0
        used = live(builder.instructions, results.values())
        number = {old: new for new, old in enumerate(used)}
        self._steps = []
        for old in used:
            instruction = builder.instructions[old]
            operation = OPERATIONS[instruction.op]
            arguments = {
                name: (self._place(v, number), dimension_of(name, operation.inputs[name]))
                for name, v in instruction.arguments.items()
            }
            self._steps.append(_Step(operation.run, arguments, instruction.step, [instruction.properties]))
        self.operations = frozenset(builder.instructions[i].op for i in used)
        self._beside = {step.aside for step in self._steps} - {(0.0, 0.0)}
        self.results = {name: self._place(v, number) for name, v in results.items()}
        self._dimensions = {n: rows for n, rows in (dimensions or {}).items() if n in results and rows}
        for name in [n for n, rows in self._dimensions.items() if self.results[n][0::2] == ("constant", rows)]:
            del self._dimensions[name]
        self.row = np.concatenate(self._constants) if self._constants else np.zeros(0, np.float32)
        self.key = (
            tuple((builder.instructions[i].op, builder.instructions[i].step) for i in used),
            tuple(property_key(builder.instructions[i].properties, plain_only=True) for i in used),
            tuple(tuple(step.arguments.items()) for step in self._steps),
            tuple(self.results.items()),
        )
        for place in (*self.results.values(), *(p for s in self._steps for p, _ in s.arguments.values())):
            if place[0] == "register":
                self._steps[place[1]].outputs.add(place[2])

    def adopt(self, other):
        """Run for the next material too, whose code is `other`, of the same key."""
        for own, step in zip(self._steps, other._steps, strict=True):
            own.adopt(step.variants[0])

    @property
    def is_constant(self):
        """Whether the results are the same at every point of a material."""
        return not self._steps

    def constant(self, place, table):
        """The value (M,) or (3, M) of `place` in all rows of `table` (C, M); None where it is computed."""
        kind, index, part = place
        return None if kind != "constant" else table[index] if part == 1 else table[index : index + 3]

    def run(self, context, constants, wanted=None):
        """Results over lanes, those whose names are in `wanted` (None: all).

        `constants` are `Constants` or an array (C, N), or (C, 1) when all lanes share one row.
        """
        if len(self._steps) * context.count <= _MOST_VALUES:
            return self._run(context, constants, wanted)
        size, parts = max(_MOST_VALUES // len(self._steps), _FEWEST_LANES), []
        for start in range(0, context.count, size):
            lanes = slice(start, min(start + size, context.count))
            with context.arena.frame():
                own = constants if constants.shape[-1] == 1 else constants[:, lanes]
                found = self._run(context.at(lanes), own, wanted)
                count = lanes.stop - lanes.start
                parts.append({name: np.array(np.broadcast_to(v, (*v.shape[:-1], count))) for name, v in found.items()})
        return {name: np.concatenate([part[name] for part in parts], axis=-1) for name in found}

    def _run(self, context, constants, wanted):
        registers = []
        contexts = {(0.0, 0.0): context}
        if self._beside:
            contexts |= beside(context, self._beside)

        def fetch(place):
            kind, index, part = place
            if kind == "constant":
                return constants[index] if part == 1 else constants[index : index + 3]
            return registers[index][part]

        with np.errstate(all="ignore"):  # what is not finite goes through: the film leaves it out and counts it
            for step in self._steps:
                inputs = {}
                for name, (place, dimension) in step.arguments.items():
                    value = fetch(place)
                    inputs[name] = value if dimension is None else to_dimension(value, dimension, context.arena)
                registers.append(step.over(contexts[step.aside], inputs, getattr(constants, "rows", None)))
            found = {name: fetch(place) for name, place in self.results.items() if wanted is None or name in wanted}
            for name in found.keys() & self._dimensions.keys():
                found[name] = to_dimension(found[name], self._dimensions[name], context.arena)
            return found

    def _place(self, value, number):
        if isinstance(value, Register):
            return ("register", number[value.index], value.output)
        flat = value.value.reshape(-1)
        slot = self._slots
        self._constants.append(flat)
        self._slots += flat.size
        return ("constant", slot, flat.size)


@dataclass(eq=False)
class _Step:
    """An instruction of a code. Its properties are one of `variants` for each material."""

    run: Callable
    arguments: dict
    aside: tuple
    variants: list
    outputs: set = field(default_factory=set)
    variant_of: list = field(default_factory=lambda: [0])

    def adopt(self, properties):
        keys = [property_key(v) for v in self.variants]
        key = property_key(properties)
        if key not in keys:
            self.variants.append(properties)
            keys.append(key)
        self.variant_of.append(keys.index(key))

    def over(self, context, inputs, rows):
        """Outputs over the lanes of the materials `rows` (N,), None for the first."""
        if len(self.variants) == 1 or rows is None:
            return self.run(context, inputs, self.variants[0])
        arena, out = context.arena, {}
        chosen = np.take(np.array(self.variant_of, np.int32), rows)
        for number, properties in enumerate(self.variants):
            lanes = np.flatnonzero(chosen == number)
            if lanes.size == 0:
                continue
            own = {name: v if v.shape[-1] == 1 else v[..., lanes] for name, v in inputs.items()}
            found = self.run(context.at(lanes), own, properties)
            for name in self.outputs:
                if name not in out:
                    out[name] = arena.empty((*found[name].shape[:-1], context.count))
                for row, values in zip(np.atleast_2d(out[name]), np.atleast_2d(found[name]), strict=True):
                    row[lanes] = values
        return out
