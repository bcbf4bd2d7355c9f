"""Study This Shot: a process of its own tells what the shot needs; the scene stays as it is."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from harness import add, grid, part, run


def stage(frames: int = 3) -> Any:
    """A grid that a wave bends, and a small file to leave alone."""
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = 1, frames
    scene.render.engine = "BLENDER_WORKBENCH"
    ob = add("<b>grid</b>", grid("grid", 12))
    wave = ob.modifiers.new("wave", "WAVE")
    wave.height, wave.width, wave.time_offset = 0.5, 0.4, -20
    return ob


def check_a_shot_is_studied_and_the_scene_left_alone() -> None:
    ob = stage()
    scene = bpy.context.scene
    before = (bpy.data.filepath, bpy.data.is_dirty, scene.frame_current, scene.render.engine)
    assert bpy.ops.regraft.study_shot() == {"FINISHED"}
    after = (bpy.data.filepath, bpy.data.is_dirty, scene.frame_current, scene.render.engine)
    assert after == before
    assert ob.name in scene.objects
    study = part("shot_study").last()
    assert not study.is_running()
    assert len(study.findings.verdict) > 40
    page = study.findings.page.read_text(encoding="utf-8")
    assert study.findings.verdict.replace("'", "&#x27;") in page
    assert "<b>grid" not in page
    rows = part("ui.study").by_policy(study.findings.rows)
    assert {len(found) for found in rows.values()} == {3}
    assert set(rows) == {"refit", "selective", "auto", "rebuild"}
    part("shot_study").close()
    assert not page_exists(study)


def page_exists(study: Any) -> bool:
    return bool(study.findings.page.exists())


def check_a_study_can_be_cancelled() -> None:
    stage(200)
    shots = part("shot_study")
    study = shots.start(bpy.context.scene, 1)
    assert study.is_running()
    assert study.progress()[0] == 0.0
    assert not bpy.ops.regraft.study_shot.poll()
    assert bpy.ops.regraft.cancel_study() == {"FINISHED"}
    assert not study.is_running()
    assert study.findings is None
    assert study.problem == "cancelled"
    assert bpy.ops.regraft.study_shot.poll()
    folder = study._folder
    shots.close()
    assert not os.path.exists(folder)
    assert shots.last() is None


def check_what_went_wrong_is_told() -> None:
    for ob in list(bpy.context.scene.objects):
        bpy.data.objects.remove(ob)
    assert bpy.ops.regraft.study_shot() == {"CANCELLED"}
    assert "geometry" in part("shot_study").last().problem
    part("shot_study").close()


def check_files_of_studies_go_with_the_add_on() -> None:
    stage()
    study = part("shot_study").start(bpy.context.scene, 1)
    folder = Path(study._folder)
    part("ui.study").detach()
    assert not folder.exists()
    assert not study.is_running()


def check_graphs_end_where_a_policy_was_given_up() -> None:
    graph = part("ui.graph")
    line = graph.Line([1.0, 0.5, np.nan, np.nan], (1.0, 0.0, 0.0, 1.0))
    pixels = graph.draw((line,), [], 1.0)
    drawn = np.flatnonzero((pixels[..., 0] == 1.0).any(axis=0))
    assert drawn.min() == 0
    assert drawn.max() < graph.SIZE[0] / 2


run(globals())
