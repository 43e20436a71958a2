# SPDX-License-Identifier: GPL-3.0-or-later
"""A node graph of a material or a world to instructions; constants are folded and equal subexpressions shared."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from ..arena import Arena
from ..nodes import OPERATIONS
from ..nodes.base import Context, as_vector
from ..nodes.convert import OPERATIONS as ARITHMETIC
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
    """One operation with its arguments by name, at the lanes or `step` footprints beside them."""

    op: str
    arguments: dict
    properties: dict
    step: tuple
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

    Attributes
    ----------
    normal : Const, Register or None
        What an unlinked normal is; None is the surface's own.
    """

    material: object
    diagnostics: object
    subject: str = "material"
    instructions: list = field(default_factory=list)
    normal: Const | Register | None = None
    _open: set = field(default_factory=set)
    _known: dict = field(default_factory=dict)
    _shared: dict = field(default_factory=dict)
    _linked: dict = field(default_factory=dict)

    def __post_init__(self):
        nodes = self.material.nodes
        ends = [v for node in nodes for v in node.inputs.values()]
        for link in (v for v in (*ends, *getattr(self.material, "side_links", ())) if isinstance(v, Link)):
            self._linked.setdefault(id(nodes[link.node]), set()).add(link.output)

    @property
    def place(self):
        """Where a diagnostic occurred."""
        return f"{self.subject} '{self.material.name}'"

    def node_outputs(self, index):
        """Outputs of node `index`, a mapping of names to values; nodes below it were visited before."""
        if index in self._open:
            op = self.material.nodes[index].op
            self.diagnostics.warn(f"the node graph has a loop; it is cut at node '{op}'", self.place)
            return None
        if index not in self._known:
            self._open.add(index)
            self._known[index] = self.visit(self.material.nodes[index])
            self._open.discard(index)
        return self._known[index]

    def value(self, given, default):
        """The value of an input: a link followed, a constant, or the operation's `default`."""
        if isinstance(given, Link):
            outputs, op = self.node_outputs(given.node), self.material.nodes[given.node].op
            self._tell(op, given.output)
            is_normal = self.normal is not None and (op, given.output) == ("geometry", "normal")
            given = self.normal if is_normal else outputs.get(given.output) if outputs else None
        if isinstance(given, Const | Register):
            return self._fit(given, default)
        if given is None:
            given = default
        return None if given is None else self._fit(Const(as_vector(given)), default)

    def emit(self, op, **arguments):
        """The value of an operation that the compiler itself puts in."""
        outputs = self._apply(op, arguments, {})
        return next(iter(outputs.values()))

    def visit(self, node):
        """Outputs of a node, which need not be one of the graph's."""
        operation = OPERATIONS.get(node.op)
        if operation is None:
            label = node.properties.get("label", node.op)
            self.diagnostics.warn(
                f"node '{label}' is not supported; the value of the socket it feeds is used", self.place
            )
            return None
        arguments = {name: self.value(node.inputs.get(name), default) for name, default in operation.inputs.items()}
        if node.op in ARITHMETIC and None in arguments.values():
            return None  # what it reads is unknown, so whoever reads it takes a default
        for name, value in arguments.items():
            if value is None:
                self._tell(node.op, name)
        if "normal" in arguments and arguments["normal"] is None:
            arguments["normal"] = self.normal
        properties = dict(node.properties)
        if operation.prepare is not None:
            properties["linked"] = self._linked.get(id(node), ())
            properties = operation.prepare(properties, self.diagnostics, self.place)
            properties.pop("linked", None)
        if operation.displaced:
            self._displace(operation, arguments, properties)
        return self._apply(node.op, {k: v for k, v in arguments.items() if v is not None}, properties)

    def _displace(self, operation, arguments, properties):
        """Add the values of the displaced input one and two steps aside, and the steps' width."""
        name = operation.displaced
        width = arguments.pop("filter_width")
        if isinstance(width, Register):
            self.diagnostics.warn("a linked filter width of a Bump node has no effect", self.place)
            width = Const(as_vector(operation.inputs["filter_width"]))
        properties["width"] = width = max(float(width.value[0]), 1e-6)
        arguments[f"{name}_x"] = self._beside(arguments[name], (width, 0.0))
        arguments[f"{name}_y"] = self._beside(arguments[name], (0.0, width))

    def _beside(self, value, step):
        """`value` as it is `step` footprints beside the lanes.

        What another bump makes stays as it is here, as in Cycles: slopes of slopes are not taken.
        """
        if not isinstance(value, Register):
            return value
        moved = {}
        for index in live(self.instructions, [value]):
            old = self.instructions[index]
            if OPERATIONS[old.op].displaced:
                moved[index] = index
                continue
            arguments = {
                n: Register(moved[v.index], v.output) if isinstance(v, Register) else v
                for n, v in old.arguments.items()
            }
            moved[index] = self._append(old.op, arguments, old.properties, step)
        return Register(moved[value.index], value.output)

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
            with np.errstate(all="ignore"):  # what is not finite goes through
                outputs = operation.run(context, inputs, properties)
            return {name: Const(np.array(v, np.float32)) for name, v in outputs.items()}
        return _Outputs(self._append(op, arguments, properties, (0.0, 0.0)))

    def _append(self, op, arguments, properties, step):
        """Number of the instruction that does this."""
        key = (op, tuple((n, _key(v)) for n, v in arguments.items()), property_key(properties), step)
        index = self._shared.setdefault(key, len(self.instructions))
        if index == len(self.instructions):
            self.instructions.append(Instruction(op, arguments, properties, step, key))
        return index

    def _fit(self, value, default):
        dimension = dimension_of("", default)
        if dimension is None:
            return value
        if isinstance(value, Const) and value.value.ndim != (2 if dimension == 3 else 1):
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


_VECTORS = ("vector", "normal", "coat_normal", "tangent")  # inputs that have no default and are vectors


def dimension_of(name, default):
    """Rows of an input with that name and default: 3 of a vector, 1 of a number; None where any will do."""
    if default is None:
        return 3 if name in _VECTORS else None
    return 3 if isinstance(default, tuple) else 1


def live(instructions, results):
    """Numbers of the instructions that `results` need, ascending."""
    needed = {v.index for v in results if isinstance(v, Register)}
    for index in range(len(instructions) - 1, -1, -1):
        if index in needed:
            needed |= {v.index for v in instructions[index].arguments.values() if isinstance(v, Register)}
    return sorted(needed)


def _key(value):
    return ("constant", value.value.tobytes()) if isinstance(value, Const) else value


def property_key(properties, plain_only=False):
    """A key of an operation's properties; with `plain_only`, of two pictures or tables it only tells the kind."""

    def key(value):
        if isinstance(value, str | int | float | bool | tuple):
            return value
        return type(value).__name__ if plain_only else id(value)

    return tuple(sorted((name, key(v)) for name, v in properties.items()))
