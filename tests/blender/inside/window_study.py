"""Study This Shot with a window: it runs while one works, and the sidebar tells the outcome."""

from __future__ import annotations

import time
from typing import Any

import bpy
from harness import TEMPORARY, add, blank, grid, part
from window import Waiting, area, here, run, space


def stage(frames: int) -> Any:
    """A wave on a grid, and the sidebar open."""
    scene = blank()
    scene.frame_start, scene.frame_end = 1, frames
    ob = add("grid", grid("grid", 24))
    wave = ob.modifiers.new("wave", "WAVE")
    wave.height, wave.width, wave.time_offset = 0.5, 0.4, -20
    with here():
        space().show_region_ui = True
    return ob


def draw_panel() -> str:
    """Everything that the panel writes."""
    said: list[str] = []

    class Layout:
        """Takes what a panel puts into it."""

        def label(self, *, text: str = "", **_more: Any) -> None:
            said.append(text)

        def operator(self, name: str, **_more: Any) -> None:
            said.append(name)

        def __getattr__(self, _name: str) -> Any:
            return lambda *_args, **_kwargs: self

    panel = type("Panel", (), {"layout": Layout()})()
    with here():
        part("ui.study").REGRAFT_PT_study.draw(panel, bpy.context)
    return "\n".join(said)


def check_it_runs_in_the_background_and_tells_its_verdict() -> Waiting:
    ob = stage(4)
    assert "regraft.study_shot" in draw_panel()
    with here():
        assert bpy.ops.regraft.study_shot("INVOKE_DEFAULT") == {"RUNNING_MODAL"}
    study = part("shot_study").last()
    assert study.is_running()
    assert "regraft.cancel_study" in draw_panel()
    ob.location.x = 0.5
    yield lambda: not study.is_running()
    assert study.findings is not None, study.problem
    assert ob.location.x == 0.5
    said = draw_panel()
    assert "regraft.open_study" in said
    assert study.findings.verdict.split()[-1] in said
    assert "Blue: selective" in said
    assert "Seconds so far, to " in said
    area().tag_redraw()
    with here():
        bpy.ops.screen.screenshot(filepath=str(TEMPORARY / "study.png"))


def started() -> Any:
    """A study of a long shot, under way."""
    stage(250)
    with here():
        bpy.ops.regraft.study_shot("INVOKE_DEFAULT")
    return part("shot_study").last()


def check_it_is_cancelled_by_its_button() -> Waiting:
    study = started()
    yield lambda: study.progress()[1] != ""
    bpy.ops.regraft.cancel_study()
    yield lambda: not study.is_running()
    assert "Cancelled" in draw_panel()


def check_it_is_cancelled_by_escape_and_by_no_other_key() -> Waiting:
    study = started()
    yield lambda: study.progress()[1] != ""
    window = bpy.context.window_manager.windows[0]
    for key in ("A", "ESC"):
        assert study.is_running()
        for value in ("PRESS", "RELEASE"):
            window.event_simulate(type=key, value=value, x=400, y=400)
        handled = time.monotonic() + 1.0
        yield lambda until=handled: time.monotonic() > until
    assert not study.is_running()
    assert "Cancelled" in draw_panel()
    with here():
        assert bpy.ops.regraft.study_shot.poll()


run(globals())
