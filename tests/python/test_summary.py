"""The last lines of a render."""

from __future__ import annotations

from regraft.cli.summary import frame_line, plan, summarise, warnings

ROWS = [
    {"total_ms": 30.0, "trace_ms": 10.0, "left_out": ["no deformation: no refit"]},
    {"total_ms": 10.0, "trace_ms": 6.0, "left_out": ["no deformation: no refit", "x: not read"]},
    {"total_ms": 20.0, "trace_ms": 8.0, "left_out": []},
]


def test_medians_are_of_all_frames() -> None:
    medians, _ = summarise(ROWS)
    assert medians.startswith("median ms a frame: evaluate 0.0 | ")
    assert medians.endswith("| trace 8.0 | shade 0.0 | write 0.0 | total 20.0")


def test_what_was_left_out_most_often_comes_first() -> None:
    _, left_out = summarise(ROWS)
    assert (
        left_out
        == "left out: no deformation: no refit (2 of 3 frames); x: not read (1 of 3 frames)"
    )


def test_a_run_without_frames_has_no_summary() -> None:
    assert summarise([]) == []


def test_a_frame_is_one_line() -> None:
    line = frame_line(ROWS[0], "a_0001.png")
    assert line.startswith("a_0001.png: 30 ms (evaluate 0,")
    assert "\n" not in line


def test_a_warning_is_told_once_with_its_frames() -> None:
    rows = [{"frame": f, "warnings": ["bad", "odd"] if f == 2 else ["bad"]} for f in (1, 2, 3)]
    assert warnings(rows) == ["bad (frames 1-3)", "odd (frames 2)"]


def test_the_plan_tells_what_was_needed_and_what_was_not() -> None:
    row = {
        "policy": "auto",
        "structure": "bvh",
        "layout": "flat",
        "deformed_meshes": 1,
        "deformed_triangles": 12345,
        "nodes": 2000,
        "nodes_refitted": 1999,
        "rays_primary": 64,
        "left_out": ["no lights: no shadow rays"],
    }
    assert plan(row) == [
        "changed: 1 meshes of 12,345 triangles deformed, 0 instances moved",
        "trees (auto, bvh, flat): 1,999 of 2,000 nodes refitted, 0 rebuilt, 0 of 0 pairs mended",
        "rays: 64 primary, 0 shadow, 0 secondary",
        "left out: no lights: no shadow rays",
    ]
    assert plan({"left_out": ["all"]}) == ["left out: all"], "nothing was done"
