# SPDX-License-Identifier: GPL-3.0-or-later
"""A shader node tree of Blender's as the core's flat graph.

Links are followed backwards from the output; groups, reroutes and muted nodes dissolve on the way, conversions
between socket types become nodes of their own. Nothing here recurses, so a chain may be thousands of nodes long.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise
from typing import NamedTuple

from ...core import scene as description
from ...core.nodes import OPERATIONS
from ...core.nodes.convert import luminance_in
from . import sockets, versions
from .node_table import NODES, NodeType
from .sockets import LUMINANCE, constant, convert, kind
from .texture_mapping import texture_mapping


class Source(NamedTuple):
    """Where a value comes from: output `socket` of `node` in frame number `frame`, or without a node the value shown
    in `socket`. `kinds` are the socket types that the value passes through, the reader's first.
    """

    frame: int
    node: object
    socket: object
    kinds: tuple[str, ...]


class _Frame(NamedTuple):
    """A tree that is being read: the root, or one group node's. `parent` is the number of its frame."""

    tree: object
    parent: int
    group: object


@dataclass
class _Open:
    """A node whose inputs are being read."""

    key: tuple
    type: NodeType | None
    bl_node: object
    inputs: dict = field(default_factory=dict)
    waiting: list = field(default_factory=list)


class GraphReader:
    """Reads the graph below one output socket.

    Parameters
    ----------
    tree : bpy.types.ShaderNodeTree
    place : str
        Said in diagnostics, e.g. ``"material 'Wood'"``.
    images : callable
        bpy image, and its user, to core image.
    diagnostics : Diagnostics

    Attributes
    ----------
    nodes : list of core.scene.Node
        Each after those that it reads.
    """

    def __init__(self, tree, place, images, diagnostics):
        self.nodes = []
        self._place = place
        self._images = images
        self._diagnostics = diagnostics
        self._frames = [_Frame(tree, -1, None)]
        self._frame_numbers = {}
        self._links = {}
        self._numbers = {}
        self._constant = []
        self._open = set()
        self._working_space = versions.to_working_space()
        self._luminance = LUMINANCE if self._working_space is None else luminance_in(self._working_space)

    def link(self, socket):
        """What reaches input `socket` of the root tree as a `Link`, None where nothing does."""
        value = self._value(self._trace(0, socket))
        return value if isinstance(value, description.Link) else None

    def closure(self, socket):
        """Number of the closure node that reaches input `socket` of the root tree, None where there is none."""
        value = self._value(self._trace(0, socket))
        return value.node if isinstance(value, description.Link) else None

    def aovs(self):
        """(name, colour, value) of each AOV Output node of the tree and of the groups in it."""
        found, frames = {}, [0]
        while frames:
            frame = frames.pop()
            for node in self._frames[frame].tree.nodes:
                if node.mute:
                    continue
                if node.bl_idname == "ShaderNodeGroup" and node.node_tree is not None:
                    frames.append(self._enter(frame, node, node.node_tree))
                elif node.bl_idname == "ShaderNodeOutputAOV" and node.aov_name:
                    sockets = (node.inputs["Color"], node.inputs["Value"])
                    found[node.aov_name] = tuple(self._value(self._trace(frame, socket)) for socket in sockets)
        return tuple((name, *values) for name, values in found.items())

    def append(self, node):
        """Add a core node after all that it reads; its number."""
        operation, links = OPERATIONS.get(node.op), (v for v in node.inputs.values() if isinstance(v, description.Link))
        foldable = operation is not None and operation.foldable and node.op not in versions.LEFT_TO_ENGINES
        self._constant.append(foldable and all(self._constant[link.node] for link in links))
        self.nodes.append(node)
        return len(self.nodes) - 1

    # -- following links --------------------------------------------------------------------------------------------

    def _trace(self, frame, socket):
        """The `Source` of input `socket`.

        A link is as good as absent where it ends in nothing: at a reroute without input, or at a muted node that
        passes on an unlinked socket. Then the last socket before counts, as in Blender.
        """
        home = frame, socket, (kind(socket),)
        kinds, seen = home[2], set()
        while True:
            link = self._linked(frame, socket)
            if link is None:
                return Source(home[0], None, home[1], home[2])
            node, output = link.from_node, link.from_socket
            if (frame, output.as_pointer()) in seen:
                self._cut(node)
                return Source(home[0], None, home[1], home[2])
            seen.add((frame, output.as_pointer()))
            kinds = _passing(kinds, kind(output))
            if kinds is None:
                return Source(home[0], None, home[1], home[2])
            if node.mute or node.bl_idname == "NodeReroute":
                socket = _passed_through(node, output)
                if socket is None:
                    return Source(home[0], None, home[1], home[2])
                kinds = _passing(kinds, kind(socket))
                continue
            inside = self._other_side(frame, node, output)
            if inside is None:
                return Source(frame, node, output, kinds)
            frame, socket = inside
            kinds = _passing(kinds, kind(socket))
            home = frame, socket, kinds

    def _linked(self, frame, socket):
        """The link into `socket`, None where there is none or it is muted."""
        tree = self._frames[frame].tree
        links = self._links.get(tree.as_pointer())
        if links is None:
            links = {link.to_socket.as_pointer(): link for link in tree.links if _counts(link)}
            self._links[tree.as_pointer()] = links
        return links.get(socket.as_pointer())

    def _other_side(self, frame, node, output):
        """Frame and input socket behind a group's border, None where `node` is no border."""
        if node.bl_idname == "NodeGroupInput":
            outer = self._frames[frame]
            inputs = () if outer.group is None else outer.group.inputs
            socket = next((s for s in inputs if s.identifier == output.identifier), None)
            return None if socket is None else (outer.parent, socket)
        tree = getattr(node, "node_tree", None)
        end = None if tree is None else _group_output(tree)
        if end is None:
            return None
        socket = next((s for s in end.inputs if s.identifier == output.identifier), None)
        return None if socket is None else (self._enter(frame, node, tree), socket)

    def _enter(self, frame, node, tree):
        """Number of the frame inside group `node`."""
        key = frame, node.as_pointer()
        if key not in self._frame_numbers:
            self._frame_numbers[key] = len(self._frames)
            self._frames.append(_Frame(tree, frame, node))
        return self._frame_numbers[key]

    # -- writing nodes ----------------------------------------------------------------------------------------------

    def _value(self, source):
        """What the core's input takes: a constant, a Link, or None for the operation's default."""
        if source.node is None or _node_type(source.node).op is None:
            return self._converted(constant(source.socket), source.kinds)
        key = source.frame, source.node.as_pointer()
        self._write(source.frame, source.node)
        output = _output_name(source.socket)
        output = _node_type(source.node).outputs.get(output, output)
        link = description.Link(self._numbers[key], output)
        if self._working_space is not None and _is_rec709(source, self.nodes[link.node].properties):
            link = description.Link(self.append(self._in_working_space(link)), "color")
        return self._converted(link, source.kinds)

    def _in_working_space(self, link):
        return description.Node("to_working_space", {"color": link}, {"working_space": self._working_space})

    def _write(self, frame, node):
        """Append `node` after all that it reads."""
        stack = []
        self._begin(stack, frame, node)
        while stack:
            item = stack[-1]
            if not item.waiting:
                stack.pop()
                self._finish(item)
                continue
            name, source = item.waiting[-1]
            if self._is_ready(source):
                item.waiting.pop()
                value = self._value(source)
                if value is not None:
                    item.inputs[name] = value
            elif (source.frame, source.node.as_pointer()) in self._open:
                item.waiting.pop()
                self._cut(source.node)
            else:
                self._begin(stack, source.frame, source.node)

    def _is_ready(self, source):
        node = source.node
        return node is None or _node_type(node).op is None or (source.frame, node.as_pointer()) in self._numbers

    def _begin(self, stack, frame, node):
        key = frame, node.as_pointer()
        if key in self._numbers:
            return
        self._open.add(key)
        item = _Open(key, NODES.get(node.bl_idname), node)
        if item.type is not None:
            for socket in node.inputs:
                if socket.enabled:
                    name = sockets.name(socket)
                    item.waiting.append((item.type.inputs.get(name, name), self._trace(frame, socket)))
            item.waiting.reverse()
        stack.append(item)

    def _finish(self, item):
        self._open.discard(item.key)
        if item.type is None:
            node = self._unsupported(item.bl_node)
        else:
            mapping = texture_mapping(item.bl_node, item.inputs.get("vector"))
            if mapping is not None:
                item.inputs["vector"] = description.Link(self.append(mapping), "vector")
            op = item.type.operation(item.bl_node)
            node = description.Node(op, item.inputs, self._properties(item.bl_node, item.type))
        self._numbers[item.key] = self.append(node)

    def _properties(self, node, node_type):
        properties = dict(node_type.fixed)
        if node_type.op in ("blackbody", "wavelength", "rgb_to_bw") and self._working_space is not None:
            properties["working_space"] = self._working_space
        if node_type.read is not None:
            properties |= node_type.read(node)
        for theirs, ours in node_type.properties.items():
            value = getattr(node, theirs, None)
            if value is not None:
                properties[ours] = self._images(value, node.image_user) if theirs == "image" else value
        for name, expected in node_type.expected.items():
            if getattr(node, name, expected) != expected:
                self._warn(f"setting '{name}' of node '{node.bl_label}' is not supported and ignored")
        return properties

    def _unsupported(self, node):
        outputs = {_output_name(s): kind(s) for s in node.outputs if s.enabled}
        properties = {"label": node.bl_label or node.bl_idname, "type": node.bl_idname, "outputs": outputs}
        return description.Node("unsupported", {}, properties)

    def _converted(self, value, kinds):
        """`value` as it arrives after the conversions along `kinds`, the last of which is its own."""
        if isinstance(value, description.Link) and not (self._constant[value.node] or versions.groups_convert()):
            kinds = kinds[0], kinds[-1]
        for to, have in reversed(tuple(pairwise(kinds))):
            if value is None or to == have:
                continue
            if to == "shader":
                # Blender shows a plain value as emitted light.
                name = "color" if have in ("color", "vector") else "strength"
                value = description.Link(self.append(description.Node("emission", {name: value})), "bsdf")
            elif not isinstance(value, description.Link):
                value = convert(value, have, to, self._luminance)
            elif {to, have} != {"color", "vector"}:
                properties = {"from": have, "to": to}
                if self._working_space is not None and have == "color":
                    properties["working_space"] = self._working_space
                node = description.Node("convert", {"value": value}, properties)
                value = description.Link(self.append(node), "value")
        return value

    # -- telling ----------------------------------------------------------------------------------------------------

    def _cut(self, node):
        self._warn(f"the node graph has a loop; it is cut at node '{node.label or node.name}'")

    def _warn(self, message):
        self._diagnostics.warn(message, self._place)


def _counts(link):
    """Whether a link carries anything: sockets that a node's mode hides are as good as absent."""
    return not link.is_muted and link.from_socket.enabled and link.to_socket.enabled


def _is_rec709(source, properties):
    """Whether a texture's colour is of Linear Rec.709 whatever the working space is.

    Data is no colour, and the floats that Blender holds are of the working space.
    """
    if kind(source.socket) != "color" or _node_type(source.node).op not in ("image", "environment", "sky"):
        return False
    image, read = getattr(source.node, "image", None), properties.get("image")
    if image is None or read is None:
        return True
    return not (image.colorspace_settings.is_data or (read.pixels is not None and read.pixels.dtype.kind == "f"))


def _node_type(node):
    return NODES.get(node.bl_idname, _UNKNOWN)


_UNKNOWN = NodeType("unsupported")


def _passing(kinds, after):
    """`kinds` with one more, None where Blender refuses the link: a closure is no value."""
    if after == "shader" and kinds[-1] != "shader":
        return None
    return kinds if after == kinds[-1] else (*kinds, after)


def _passed_through(node, output):
    """Input socket that a muted node or a reroute passes on to `output`, None where it passes nothing."""
    if node.bl_idname == "NodeReroute":
        return node.inputs[0]
    return next((link.from_socket for link in node.internal_links if link.to_socket == output), None)


def _group_output(tree):
    """The active Group Output node of a group's tree."""
    nodes = [n for n in tree.nodes if n.bl_idname == "NodeGroupOutput"]
    return next((n for n in nodes if n.is_active_output), nodes[0] if nodes else None)


def _output_name(socket):
    """Name of an output: all closures are called ``"bsdf"``."""
    return "bsdf" if kind(socket) == "shader" else sockets.name(socket)
