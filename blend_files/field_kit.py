"""Geometry nodes written as formulas: `position + velocity * time` instead of boxes and wires.

A `Graph` is one geometry-nodes tree; a `Field` is an output socket that takes part in arithmetic.
Only nodes that mean the same in Blender 3.4 to 5.0 are used, so the scenes play back alike in every
version.
"""

from typing import Union

import bpy

Operand = Union["Field", float, tuple[float, float, float]]
_ATTRIBUTE_TYPES = {"float": "FLOAT", "int": "INT", "vector": "FLOAT_VECTOR"}


class Field:
    """A float or vector per point, as the output socket of a node."""

    def __init__(self, graph: "Graph", socket: bpy.types.NodeSocket) -> None:
        self.graph, self.socket = graph, socket

    @property
    def is_vector(self) -> bool:
        return bool(self.socket.type == "VECTOR")

    def __add__(self, other: Operand) -> "Field":
        return self._combine("ADD", other)

    def __sub__(self, other: Operand) -> "Field":
        return self._combine("SUBTRACT", other)

    def __mul__(self, other: Operand) -> "Field":
        """Product; a vector times a float scales it."""
        scalar = isinstance(other, int | float) or (
            isinstance(other, Field) and not other.is_vector
        )
        if self.is_vector and scalar:
            node = self.graph.node("ShaderNodeVectorMath", operation="SCALE")
            self.graph.connect(self, node.inputs[0])
            self.graph.connect(other, node.inputs["Scale"])
            return Field(self.graph, node.outputs["Vector"])
        return self._combine("MULTIPLY", other)

    def minimum(self, other: Operand) -> "Field":
        return self._combine("MINIMUM", other)

    def maximum(self, other: Operand) -> "Field":
        return self._combine("MAXIMUM", other)

    def dot(self, other: Operand) -> "Field":
        return self._combine("DOT_PRODUCT", other, output="Value")

    def cross(self, other: Operand) -> "Field":
        return self._combine("CROSS_PRODUCT", other)

    def length(self) -> "Field":
        return self.graph.vector_math("LENGTH", self, output="Value")

    def normalised(self) -> "Field":
        return self.graph.vector_math("NORMALIZE", self)

    def sine(self) -> "Field":
        return self.graph.math("SINE", self)

    def cosine(self) -> "Field":
        return self.graph.math("COSINE", self)

    def split(self) -> tuple["Field", "Field", "Field"]:
        """The three components of a vector."""
        node = self.graph.node("ShaderNodeSeparateXYZ")
        self.graph.connect(self, node.inputs[0])
        x, y, z = (Field(self.graph, socket) for socket in node.outputs)
        return x, y, z

    def _combine(self, operation: str, other: Operand, output: str = "Vector") -> "Field":
        if self.is_vector:
            return self.graph.vector_math(operation, self, other, output=output)
        return self.graph.math(operation, self, other)


class Graph:
    """A geometry-nodes tree under construction, with the group's geometry at `geometry`."""

    def __init__(self, name: str) -> None:
        self.tree = bpy.data.node_groups.new(name, "GeometryNodeTree")
        self.tree.inputs.new("NodeSocketGeometry", "Geometry")
        self.tree.outputs.new("NodeSocketGeometry", "Geometry")
        self.geometry = self.node("NodeGroupInput").outputs[0]
        self._output = self.node("NodeGroupOutput").inputs[0]

    def node(self, kind: str, **settings: object) -> bpy.types.Node:
        """A new node with its properties set."""
        made = self.tree.nodes.new(kind)
        made.location = (180 * (len(self.tree.nodes) % 12), -220 * (len(self.tree.nodes) // 12))
        for name, value in settings.items():
            setattr(made, name, value)
        return made

    def connect(self, value: object, socket: bpy.types.NodeSocket) -> None:
        """Feeds a field, an output socket or a constant into an input socket."""
        if isinstance(value, Field):
            self.tree.links.new(value.socket, socket)
        elif isinstance(value, bpy.types.NodeSocket):
            self.tree.links.new(value, socket)
        else:
            socket.default_value = value

    def math(self, operation: str, *operands: Operand) -> Field:
        node = self.node("ShaderNodeMath", operation=operation)
        for socket, operand in zip(node.inputs, operands, strict=False):
            self.connect(operand, socket)
        return Field(self, node.outputs[0])

    def vector_math(self, operation: str, *operands: Operand, output: str = "Vector") -> Field:
        node = self.node("ShaderNodeVectorMath", operation=operation)
        for socket, operand in zip(node.inputs, operands, strict=False):
            self.connect(operand, socket)
        return Field(self, node.outputs[output])

    def vector(self, x: Operand, y: Operand, z: Operand) -> Field:
        """A vector of three floats."""
        node = self.node("ShaderNodeCombineXYZ")
        for socket, part in zip(node.inputs, (x, y, z), strict=True):
            self.connect(part, socket)
        return Field(self, node.outputs[0])

    def seconds(self) -> Field:
        """Scene time, the same for every point."""
        return Field(self, self.node("GeometryNodeInputSceneTime").outputs["Seconds"])

    def position(self) -> Field:
        return Field(self, self.node("GeometryNodeInputPosition").outputs[0])

    def named(self, name: str, kind: str) -> Field:
        """A stored attribute; `kind` is float, int or vector."""
        node = self.node("GeometryNodeInputNamedAttribute", data_type=_ATTRIBUTE_TYPES[kind])
        node.inputs["Name"].default_value = name
        return Field(self, next(s for s in node.outputs if s.enabled and s.name == "Attribute"))

    def store(self, name: str, value: Field) -> None:
        """Writes a field as a point attribute of the geometry."""
        kind = "FLOAT_VECTOR" if value.is_vector else "FLOAT"
        node = self.node("GeometryNodeStoreNamedAttribute", data_type=kind, domain="POINT")
        node.inputs["Name"].default_value = name
        self.connect(value, next(s for s in node.inputs if s.enabled and s.name == "Value"))
        self.pass_through(node)

    def pass_through(self, node: bpy.types.Node, name: str = "Geometry") -> bpy.types.Node:
        """Sends the geometry through a node, so that what follows works on its result."""
        self.connect(self.geometry, node.inputs[0])
        self.geometry = node.outputs[0]
        return node

    def object_geometry(self, source: bpy.types.Object) -> bpy.types.NodeSocket:
        """The evaluated geometry of another object, in its own frame."""
        node = self.node("GeometryNodeObjectInfo", transform_space="ORIGINAL")
        node.inputs["Object"].default_value = source
        return node.outputs["Geometry"]

    def move_by(self, offset: Field, only: Field | None = None) -> None:
        """Adds an offset to every point's position, or only where a field is positive."""
        node = self.pass_through(self.node("GeometryNodeSetPosition"))
        self.connect(offset, node.inputs["Offset"])
        if only is not None:
            self.connect(only, node.inputs["Selection"])

    def set_material(self, material: bpy.types.Material, where: Field) -> None:
        """Gives a material to the faces where a field is positive."""
        node = self.pass_through(self.node("GeometryNodeSetMaterial"))
        node.inputs["Material"].default_value = material
        self.connect(where, node.inputs["Selection"])

    def put_on(self, thing: bpy.types.Object) -> None:
        """Closes the tree and makes it a modifier of an object."""
        self.connect(self.geometry, self._output)
        modifier = thing.modifiers.new(self.tree.name, "NODES")
        modifier.node_group = self.tree
