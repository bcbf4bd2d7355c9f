"""Study This Shot: the button, and a panel with the verdict and two graphs."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import accumulate
from typing import Any

import bpy

from .. import compat, session, shot_study
from . import graph
from .panels import SidebarPanel, draw_sentence, room_for, wrapped

Result = set[str]
Row = dict[str, Any]

# Seconds between two looks at a study in the background.
LOOK_EVERY = 0.5
SCALE = 7.0
# Letters that fit into a line without an icon beyond those beside one.
NO_ICON = 4
COLOURS: dict[str, tuple[str, graph.Colour]] = {
    "refit": ("Orange", (0.90, 0.62, 0.00, 1.0)),
    "selective": ("Blue", (0.35, 0.65, 0.95, 1.0)),
    "auto": ("Green", (0.55, 0.85, 0.40, 1.0)),
    "rebuild": ("White", (0.85, 0.85, 0.85, 1.0)),
}

_age, _time = graph.GraphIcon(), graph.GraphIcon()


class REGRAFT_OT_study_shot(bpy.types.Operator):
    """Replay the shot with every policy, in the background, and say which one to use.
    The scene stays as it is; ESC cancels"""

    bl_idname = "regraft.study_shot"
    bl_label = "Study This Shot"

    _timer: Any = None

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be a library and a scene, and no study under way."""
        study = shot_study.last()
        if compat.problem():
            cls.poll_message_set(compat.problem())
        elif study is not None and study.is_running():
            cls.poll_message_set("A study is running")
        else:
            return context.scene is not None
        return False

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> Result:
        """Start, and look again from time to time."""
        if not self._start(context):
            return {"CANCELLED"}
        manager = context.window_manager
        self._timer = manager.event_timer_add(LOOK_EVERY, window=context.window)
        manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> Result:
        """Everybody else gets all events, too."""
        study = shot_study.last()
        if study is None:
            return self._end(context, {"CANCELLED"})
        if event.type == "ESC" and event.value == "PRESS" and study.is_running():
            study.cancel()
            return self._end(context, {"CANCELLED"})
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        redraw(context)
        if study.is_running():
            return {"PASS_THROUGH"}
        return self._end(context, self._say(study))

    def execute(self, context: bpy.types.Context) -> Result:
        """Wait for it: without a window nothing can be done meanwhile."""
        if not self._start(context):
            return {"CANCELLED"}
        study = shot_study.last()
        assert study is not None
        study.wait()
        return self._say(study)

    def _start(self, context: bpy.types.Context) -> bool:
        try:
            shot_study.start(context.scene, session.Options.of(context.scene).threads)
        except (OSError, RuntimeError) as error:
            self.report({"ERROR"}, f"The shot cannot be studied: {error}")
            return False
        return True

    def _say(self, study: shot_study.ShotStudy) -> Result:
        if study.findings is None:
            self.report({"WARNING"}, f"Study: {study.problem}")
            return {"CANCELLED"}
        self.report({"INFO"}, study.findings.verdict)
        return {"FINISHED"}

    def _end(self, context: bpy.types.Context, result: Result) -> Result:
        context.window_manager.event_timer_remove(self._timer)
        redraw(context)
        return result


class REGRAFT_OT_cancel_study(bpy.types.Operator):
    """Stop the study that is running"""

    bl_idname = "regraft.cancel_study"
    bl_label = "Cancel Study"

    def execute(self, context: bpy.types.Context) -> Result:
        """Stop it."""
        study = shot_study.last()
        if study is None or not study.is_running():
            return {"CANCELLED"}
        study.cancel()
        redraw(context)
        return {"FINISHED"}


class REGRAFT_OT_open_study(bpy.types.Operator):
    """Open the page with all figures of the study"""

    bl_idname = "regraft.open_study"
    bl_label = "Open Page"

    @classmethod
    def poll(cls, _context: bpy.types.Context) -> bool:
        """There must be one."""
        study = shot_study.last()
        return study is not None and study.findings is not None

    def execute(self, _context: bpy.types.Context) -> Result:
        """In the browser."""
        study = shot_study.last()
        assert study is not None
        assert study.findings is not None
        return set(bpy.ops.wm.url_open(url=study.findings.page.as_uri()))


class REGRAFT_PT_study(SidebarPanel, bpy.types.Panel):
    """Which policy the shot needs"""

    bl_label = "Study"

    def draw(self, context: bpy.types.Context) -> None:
        """A button; while it runs how far it is; then what it found."""
        layout, study = self.layout, shot_study.last()
        if study is not None and study.is_running():
            draw_progress(layout, study)
            return
        layout.operator("regraft.study_shot", icon="VIEWZOOM")
        if study is None:
            return
        room = room_for(context)
        if study.findings is not None:
            draw_findings(layout, study.shot, study.findings, room)
        elif study.problem:
            draw_sentence(layout.column(align=True), study.problem.capitalize(), "ERROR", room)


def draw_progress(layout: bpy.types.UILayout, study: shot_study.ShotStudy) -> None:
    """How far a study is, and the button that ends it."""
    share, step = study.progress()
    column = layout.column(align=True)
    column.label(text=study.shot, icon="TIME")
    column.label(text=f"{share:.0%}: {step}" if share else step.capitalize())
    layout.operator("regraft.cancel_study", text="Cancel", icon="X")


def draw_findings(
    layout: bpy.types.UILayout, shot: str, found: shot_study.Findings, room: int
) -> None:
    """The verdict, both graphs, and the button to the page."""
    box = layout.box().column(align=True)
    box.label(text=shot)
    for line in wrapped(found.verdict[:1].upper() + found.verdict[1:], room + NO_ICON):
        box.label(text=line)
    ages = {
        name: [(row["ratio"] or math.nan) - 1.0 for row in rows]
        for name, rows in by_policy(found.rows).items()
        if name != "rebuild"
    }
    draw_graph(layout, _age, "Tests over fresh tree's, to {:+.0%}", ages)
    spent = {
        name: list(accumulate((row["update_ms"] + row["trace_ms"]) / 1e3 for row in rows[1:]))
        for name, rows in by_policy(found.rows).items()
    }
    draw_graph(layout, _time, "Seconds so far, to {:.3g}", spent)
    layout.operator("regraft.open_study", icon="URL")


def by_policy(rows: Sequence[Row]) -> dict[str, list[Row]]:
    """Rows of the policies that the graphs show, frame by frame."""
    return {
        name: found
        for name in COLOURS
        if (found := [r for r in rows if r["policy"] == name and r["structure"] == "bvh"])
    }


def draw_graph(
    layout: bpy.types.UILayout,
    icon: graph.GraphIcon,
    title: str,
    series: dict[str, list[float]],
) -> None:
    """A line for each policy, all from 0 to the highest value, which the title tells, and a
    legend."""
    finite = [value for values in series.values() for value in values if math.isfinite(value)]
    longest = max(map(len, series.values()), default=0)
    if longest < 2 or not finite:
        return
    highest = max(*finite, 1e-3)
    # One that was given up ends before the others.
    lines = [
        graph.Line([*values, *[math.nan] * (longest - len(values))], COLOURS[name][1])
        for name, values in series.items()
    ]
    pixels = graph.draw(lines, [], highest)
    key = tuple((name, tuple(values)) for name, values in series.items())
    box = layout.box().column(align=True)
    box.label(text=title.format(highest))
    box.template_icon(icon.icon(key, pixels), scale=SCALE)
    grid = box.grid_flow(columns=2, align=True)
    for name in series:
        grid.label(text=f"{COLOURS[name][0]}: {name}")


def redraw(context: bpy.types.Context) -> None:
    """The sidebars."""
    for window in context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                area.tag_redraw()


CLASSES = (
    REGRAFT_OT_study_shot,
    REGRAFT_OT_cancel_study,
    REGRAFT_OT_open_study,
    REGRAFT_PT_study,
)


def detach() -> None:
    """End what runs, and give the graphs back."""
    shot_study.close()
    _age.close()
    _time.close()
