"""The sidebar tab "Regraft", and Regraft's panels among the render and view layer properties."""

from __future__ import annotations

import math
from typing import Any

import bpy

from .. import compat, session
from ..handlers import ENGINE
from . import graph

# Panels of Blender's own that say nothing about Regraft's pictures.
FOREIGN = {"VIEWLAYER_PT_filter", "VIEWLAYER_PT_layer_passes"}
# Pixels of a letter, and of what else stands in a line, at a resolution scale of 1.
LETTER, MARGIN = 7.0, 70
MAX_SENTENCES = 8

TIMES = ("evaluate_ms", "extract_ms", "update_ms", "trace_ms", "shade_ms", "write_ms")
GROUPS = (
    ("Scene", ("triangles", "instances", "moved_instances", "deformed_meshes",
               "deformed_triangles")),
    ("Trees", ("policy", "structure", "layout", "nodes", "nodes_refitted", "nodes_rebuilt",
               "pairs_considered", "pairs_restructured", "late_updates", "late_update_ms",
               "kdtree_nodes", "kdtree_built_fraction", "kdtree_unbuilt_nodes",
               "kdtree_large_leaves",
               "culling_efficiency", "cost_ratio", "memory_bytes")),
    ("Rays", ("rays_primary", "rays_shadow", "rays_secondary", "nodes_visited", "triangle_tests",
              "observed_cost")),
)  # fmt: skip
SHOWN_EVEN_IF_ZERO = {"triangles", "instances"}


def room_for(context: bpy.types.Context) -> int:
    """How many letters fit into a line of a panel."""
    scale = context.preferences.system.ui_scale
    return max(16, int((context.region.width / scale - MARGIN) / LETTER))


def draw_settings(layout: bpy.types.UILayout, scene: bpy.types.Scene) -> None:
    """The settings, one a line."""
    layout.use_property_split = True
    layout.use_property_decorate = False
    settings = scene.regraft
    column = layout.column()
    column.prop(settings, "shading")
    column.prop(settings, "samples")
    column.prop(settings, "viewport_samples")
    column.prop(settings, "use_headlight")
    column = layout.column()
    column.prop(settings, "policy")
    column.prop(settings, "structure")
    column.prop(settings, "layout")
    column.prop(settings, "threads")


PREDICTED: graph.Colour = (0.35, 0.65, 0.95, 1.0)
OBSERVED: graph.Colour = (0.55, 0.85, 0.40, 1.0)
GRAPH_FRAMES = 100
GRAPH_SCALE = 8.0

_graph = graph.GraphIcon()


def draw_costs(layout: bpy.types.UILayout, rows: list[dict[str, Any]]) -> None:
    """Predicted and observed cost of the last frames as a graph."""
    rows = rows[-GRAPH_FRAMES:]
    predicted = [row.get("culling_efficiency") or math.nan for row in rows]
    observed = [row.get("observed_cost") or math.nan for row in rows]
    finite = [value for value in predicted + observed if math.isfinite(value)]
    if len(rows) < 2 or not finite:
        return
    highest = max(finite)
    rebuilt = [bool(row.get("nodes_rebuilt")) for row in rows]
    key = (len(rows), tuple(predicted), tuple(observed))
    lines = (graph.Line(predicted, PREDICTED), graph.Line(observed, OBSERVED))
    box = layout.box().column(align=True)
    box.label(text=f"Tests a ray, 0 to {readable('', highest)}")
    box.template_icon(_graph.icon(key, graph.draw(lines, rebuilt, highest)), scale=GRAPH_SCALE)
    box.label(text="Blue: predicted")
    box.label(text="Green: observed")
    box.label(text="Orange: nodes rebuilt")


def draw_problem(layout: bpy.types.UILayout, room: int) -> bool:
    """Say why the library cannot be used; True if that is so."""
    problem = compat.problem()
    if problem:
        draw_sentence(layout.box().column(align=True), problem, "ERROR", room)
    return bool(problem)


def draw_statistics(layout: bpy.types.UILayout, statistics: dict[str, Any], room: int) -> None:
    """One frame's statistics, grouped; what is zero and usually is, is left out."""
    total = readable("total_ms", statistics.get("total_ms", 0.0))
    layout.label(text=f"Frame {statistics.get('frame', 0)}: {total}", icon="TIME")
    box = layout.box().column(align=True)
    for name in TIMES:
        if statistics.get(name):
            draw_value(box, name, statistics[name])
    draw_sentences(layout, "Warnings", statistics.get("warnings", []), "ERROR", room)
    draw_sentences(layout, "Left out", statistics.get("left_out", []), "CHECKMARK", room)
    for title, names in GROUPS:
        box = layout.box().column(align=True)
        box.label(text=title)
        for name in names:
            value = statistics.get(name)
            if value or name in SHOWN_EVEN_IF_ZERO:
                draw_value(box, name, value)


def draw_value(layout: bpy.types.UILayout, name: str, value: Any) -> None:
    """A name on the left and its value on the right."""
    row = layout.split(factor=0.55)
    row.label(text=words(name))
    right = row.row()
    right.alignment = "RIGHT"
    right.label(text=readable(name, value))


def draw_sentences(
    layout: bpy.types.UILayout, title: str, sentences: list[str], icon: str, room: int
) -> None:
    """A list of sentences under a title, if there are any."""
    if not sentences:
        return
    box = layout.box().column(align=True)
    box.label(text=title)
    for sentence in sentences[:MAX_SENTENCES]:
        draw_sentence(box, sentence, icon, room)
    if len(sentences) > MAX_SENTENCES:
        box.label(text=f"and {len(sentences) - MAX_SENTENCES} more")


def draw_sentence(layout: bpy.types.UILayout, sentence: str, icon: str, room: int) -> None:
    """A sentence, broken into lines, because Blender's labels do not."""
    for number, line in enumerate(wrapped(sentence, room)):
        layout.label(text=line, icon=icon if number == 0 else "BLANK1")


def wrapped(sentence: str, width: int) -> list[str]:
    """Lines of at most `width` characters, words longer than that left whole."""
    lines = [""]
    for word in sentence.split():
        if lines[-1] and len(lines[-1]) + 1 + len(word) > width:
            lines.append("")
        lines[-1] = f"{lines[-1]} {word}".strip()
    return lines


def words(name: str) -> str:
    """A statistic's name for people."""
    name = name.removesuffix("_ms").removesuffix("_bytes").replace("kdtree", "k-d tree")
    return name.replace("_", " ").capitalize()


def readable(name: str, value: Any) -> str:
    """A statistic's value with its unit."""
    if isinstance(value, str):
        return value
    if name.endswith("_ms"):
        return f"{value:,.0f} ms" if value >= 100 else f"{value:.2f} ms"
    if name.endswith("_bytes"):
        return f"{value / 2**20:,.1f} MiB"
    if name.endswith("_fraction"):
        return f"{value:.1%}"
    return f"{value:,.3g}" if isinstance(value, float) else f"{value:,}"


class SidebarPanel:
    """Where the sidebar's panels are."""

    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Regraft"


class REGRAFT_PT_preview(SidebarPanel, bpy.types.Panel):
    """Settings and buttons"""

    bl_label = "Preview"

    def draw(self, context: bpy.types.Context) -> None:
        """Buttons first, then the settings."""
        layout = self.layout
        if draw_problem(layout, room_for(context)):
            return
        column = layout.column(align=True)
        column.operator("regraft.render_preview", icon="RENDER_STILL")
        column.operator("regraft.preview_animation", icon="RENDER_ANIMATION")
        draw_settings(layout, context.scene)


class REGRAFT_PT_statistics(SidebarPanel, bpy.types.Panel):
    """What the last frame cost"""

    bl_label = "Last Frame"

    def draw(self, context: bpy.types.Context) -> None:
        """The button that saves the statistics, and the statistics."""
        statistics = session.last_statistics()
        if statistics is None:
            self.layout.label(text="Nothing was rendered yet")
            return
        self.layout.operator("regraft.save_statistics", icon="FILE_TICK")
        draw_costs(self.layout, session.history())
        draw_statistics(self.layout, statistics, room_for(context))


class REGRAFT_PT_overlay(SidebarPanel, bpy.types.Panel):
    """What is drawn over the viewports"""

    bl_label = "Overlay"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        """The switch and the depth."""
        layout = self.layout
        layout.use_property_split = True
        settings = context.scene.regraft
        layout.prop(settings, "show_nodes")
        column = layout.column()
        column.active = settings.show_nodes
        column.prop(settings, "node_depth")


class PropertiesPanel:
    """Where the panels among the properties are; they show while the engine is Regraft."""

    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Only for Regraft."""
        return bool(context.engine == ENGINE)


class REGRAFT_PT_render(PropertiesPanel, bpy.types.Panel):
    """Settings among the render properties"""

    bl_label = "Preview"
    bl_context = "render"

    def draw(self, context: bpy.types.Context) -> None:
        """The settings."""
        if not draw_problem(self.layout, room_for(context)):
            draw_settings(self.layout, context.scene)


class REGRAFT_PT_film(PropertiesPanel, bpy.types.Panel):
    """What is seen where nothing is"""

    bl_label = "Film"
    bl_context = "render"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        """Transparent or not."""
        self.layout.use_property_split = True
        self.layout.prop(context.scene.render, "film_transparent", text="Transparent")


class REGRAFT_PT_passes(PropertiesPanel, bpy.types.Panel):
    """The passes that Regraft delivers"""

    bl_label = "Passes"
    bl_context = "view_layer"

    def draw(self, context: bpy.types.Context) -> None:
        """One box a pass."""
        self.layout.use_property_split = True
        column = self.layout.column(heading="Include")
        layer = context.view_layer
        column.prop(layer, "use_pass_z", text="Depth")
        column.prop(layer, "use_pass_normal", text="Normal")
        column.prop(layer, "use_pass_object_index", text="Object Index")
        column.prop(layer.regraft, "use_pass_cost")


def blenders_panels() -> list[Any]:
    """Blender's own panels that every engine wants: output, camera, lights and so on."""
    panels = []
    for panel in bpy.types.Panel.__subclasses__():
        engines: set[str] = getattr(panel, "COMPAT_ENGINES", set())
        if "BLENDER_RENDER" in engines and panel.__name__ not in FOREIGN:
            panels.append(panel)
    return panels


SIDEBAR = (REGRAFT_PT_preview, REGRAFT_PT_statistics, REGRAFT_PT_overlay)
PROPERTIES = (REGRAFT_PT_render, REGRAFT_PT_film, REGRAFT_PT_passes)


def attach() -> None:
    """Show Blender's panels for Regraft as well."""
    for panel in blenders_panels():
        panel.COMPAT_ENGINES.add(ENGINE)


def detach() -> None:
    """Take Regraft off Blender's panels."""
    _graph.close()
    for panel in blenders_panels():
        panel.COMPAT_ENGINES.discard(ENGINE)
