# SPDX-License-Identifier: GPL-3.0-or-later
"""A node graph of a material or a world to straight-line code over lanes.

Constants are folded and equal subexpressions shared. What is left constant stands in a table, one row a material, so
that graphs of equal structure share one program.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from ..arena import Arena
from ..nodes import OPERATIONS
from ..nodes.base import Context, as_vector
from ..nodes.convert import to_dimension
from ..scene import Link


class Const(NamedTuple):
    """A value known at compile: (1,) or (3, 1) float32."""

    value: np.ndarray


class Register(NamedTuple):
    """Output `output` of instruction number `index`."""

    index: int
    output: str


@dataclass(frozen=True, eq=False)
class Instruction:
    """One operation with its arguments by name."""

    op: str
    arguments: dict
    properties: dict
    key: tuple


@dataclass
class Builder:
    """Collects the instructions of one graph.

    Parameters
    ----------
    material : core.scene.Material or core.scene.World
    diagnostics : Diagnostics
    subject : str
        What diagnostics call it.
    """

    material: object
    diagnostics: object
    subject: str = "material"
    instructions: list = field(default_factory=list)
    _known: dict = field(default_factory=dict)
    _shared: dict = field(default_factory=dict)

    @property
    def place(self):
        """Where a diagnostic occurred."""
        return f"{self.subject} '{self.material.name}'"

    def node_outputs(self, index):
        """Outputs of node `index`, a mapping of names to values; nodes below it were visited before."""
        if index not in self._known:
            self._known[index] = self._visit(self.material.nodes[index])
        return self._known[index]

    def value(self, given, default):
        """The value of an input: a link followed, a constant, or the operation's `default`."""
        if isinstance(given, Link):
            outputs = self.node_outputs(given.node)
            self._tell(self.material.nodes[given.node].op, given.output)
            given = outputs.get(given.output) if outputs else None
        if isinstance(given, Const | Register):
            return self._fit(given, default)
        if given is None:
            given = default
        return None if given is None else self._fit(Const(as_vector(given)), default)

    def emit(self, op, **arguments):
        """The value of an operation that the compiler itself puts in."""
        outputs = self._apply(op, arguments, {})
        return next(iter(outputs.values()))

    def _visit(self, node):
        operation = OPERATIONS.get(node.op)
        if operation is None:
            label = node.properties.get("label", node.op)
            self.diagnostics.warn(
                f"node '{label}' is not supported; the value of the socket it feeds is used", self.place
            )
            return None
        arguments = {name: self.value(node.inputs.get(name), default) for name, default in operation.inputs.items()}
        for name, value in arguments.items():
            if value is None:
                self._tell(node.op, name)
        properties = dict(node.properties)
        if operation.prepare is not None:
            properties = operation.prepare(properties, self.diagnostics, self.place)
        return self._apply(node.op, {k: v for k, v in arguments.items() if v is not None}, properties)

    def _tell(self, op, socket):
        """Say what `socket` of an operation asks for and does not get."""
        message = OPERATIONS[op].unsupported.get(socket) if op in OPERATIONS else None
        if message:
            self.diagnostics.warn(message, self.place)

    def _apply(self, op, arguments, properties):
        operation = OPERATIONS[op]
        if operation.foldable and all(isinstance(v, Const) for v in arguments.values()):
            context = Context(Arena(4096), 1)
            inputs = {name: v.value for name, v in arguments.items()}
            outputs = operation.run(context, inputs, properties)
            return {name: Const(np.array(v, np.float32)) for name, v in outputs.items()}
        key = (op, tuple((n, _key(v)) for n, v in arguments.items()), _property_key(properties))
        index = self._shared.setdefault(key, len(self.instructions))
        if index == len(self.instructions):
            self.instructions.append(Instruction(op, arguments, properties, key))
        return _Outputs(index)

    def _fit(self, value, default):
        dimension = None if default is None else (3 if isinstance(default, tuple) else 1)
        if dimension is None:
            return value
        if isinstance(value, Const):
            return Const(np.array(to_dimension(value.value, dimension, Arena(4096)), np.float32))
        return value


class _Outputs(dict):
    """Outputs of an instruction; any name asked for is a register of it."""

    def __init__(self, index):
        super().__init__()
        self._index = index

    def __bool__(self):
        return True

    def get(self, name, default=None):
        return Register(self._index, name)

    def values(self):
        return iter((Register(self._index, "value"),))


class Code:
    """Straight-line code that computes `results` of a builder, with constants in a table.

    Parameters
    ----------
    builder : Builder
    results : mapping of hashable to Const or Register
    """

    def __init__(self, builder, results):
        self._constants = []
        self._slots = 0
        used = _live(builder.instructions, results.values())
        number = {old: new for new, old in enumerate(used)}
        self._steps = []
        for old in used:
            instruction = builder.instructions[old]
            operation = OPERATIONS[instruction.op]
            arguments = {
                name: (self._place(v, number), _dimension(operation.inputs[name]))
                for name, v in instruction.arguments.items()
            }
            self._steps.append((operation.run, arguments, instruction.properties))
        self._results = {name: self._place(v, number) for name, v in results.items()}
        self.row = np.concatenate(self._constants) if self._constants else np.zeros(0, np.float32)
        self.key = (
            tuple((builder.instructions[i].op, builder.instructions[i].key[2]) for i in used),
            tuple(tuple(a.items()) for _, a, _ in self._steps),
            tuple(self._results.items()),
        )

    @property
    def is_constant(self):
        """Whether the results are the same at every point of a material."""
        return not self._steps

    def run(self, context, constants):
        """Results over lanes; `constants` is (C, N), or (C, 1) when all lanes share one row."""
        registers = []

        def fetch(place):
            kind, index, part = place
            if kind == "constant":
                return constants[index] if part == 1 else constants[index : index + 3]
            return registers[index][part]

        for run, arguments, properties in self._steps:
            inputs = {}
            for name, (place, dimension) in arguments.items():
                value = fetch(place)
                inputs[name] = value if dimension is None else to_dimension(value, dimension, context.arena)
            registers.append(run(context, inputs, properties))
        return {name: fetch(place) for name, place in self._results.items()}

    def _place(self, value, number):
        if isinstance(value, Register):
            return ("register", number[value.index], value.output)
        flat = value.value.reshape(-1)
        slot = self._slots
        self._constants.append(flat)
        self._slots += flat.size
        return ("constant", slot, flat.size)


def post_order(nodes, root):
    """Node numbers below `root`, each after those it reads; links that would close a loop are left out.

    Iterative, because graphs of thousands of nodes exist.
    """
    order, state = [], {}
    stack = [(root, iter(_children(nodes[root])))]
    state[root] = "open"
    while stack:
        index, children = stack[-1]
        child = next((c for c in children if c not in state), None)
        if child is None:
            stack.pop()
            state[index] = "done"
            order.append(index)
        else:
            state[child] = "open"
            stack.append((child, iter(_children(nodes[child]))))
    return order


def _children(node):
    return [v.node for v in node.inputs.values() if isinstance(v, Link)]


def _live(instructions, results):
    """Numbers of the instructions that `results` need, ascending."""
    needed = {v.index for v in results if isinstance(v, Register)}
    for index in range(len(instructions) - 1, -1, -1):
        if index in needed:
            needed |= {v.index for v in instructions[index].arguments.values() if isinstance(v, Register)}
    return sorted(needed)


def _dimension(default):
    return None if default is None else (3 if isinstance(default, tuple) else 1)


def _key(value):
    return ("constant", value.value.tobytes()) if isinstance(value, Const) else value


def _property_key(properties):
    return tuple(
        sorted((name, v if isinstance(v, str | int | float | bool) else id(v)) for name, v in properties.items())
    )
