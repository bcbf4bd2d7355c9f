"""Whatever a frame leaves out, its picture is the same bit for bit; and less was done."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from regraft.cli import bench_omissions, main
from regraft.study import omissions

Row = dict[str, Any]
SMALL = omissions.Settings(triangles=1200, size=24, frames=3, threads=1)


@pytest.mark.parametrize("omission", omissions.OMISSIONS, ids=lambda omission: omission.name)
def test_the_picture_is_the_same(omission: omissions.Omission) -> None:
    with_it, without = (omission.make(SMALL, omit) for omit in (True, False))
    seen = []
    for frame in range(SMALL.frames):
        one, other = with_it(frame), without(frame)
        assert one.picture == other.picture
        assert any(one.picture)
        seen.append(one.picture)
    moves = omission.name.startswith(("camera", "rigid"))
    assert (len(set(seen)) > 1) == moves


# What the work that is left out counts as, by the statistics.
WORK = {
    "still scene: no update": "nodes_refitted",
    "camera alone moves: no update": "nodes_refitted",
    "rigid motion: no refit": "nodes_refitted",
    "hidden mesh deforms: not updated": "nodes_refitted",
    "no ray near a mesh: only bounded": "nodes_refitted",
    "no second light: no shadow rays to it": "rays_shadow",
}


@pytest.mark.parametrize("name", WORK)
def test_the_other_side_does_the_work(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    omission = next(o for o in omissions.OMISSIONS if o.name == name)
    counts: list[Row] = []
    render = omissions.render

    def watched(*args: Any) -> Any:
        frame = render(*args)
        counts.append(frame.statistics.as_dict())
        return frame

    monkeypatch.setattr(omissions, "render", watched)
    done = {}
    for omit in (True, False):
        side = omission.make(SMALL, omit)
        for frame in range(SMALL.frames):
            side(frame)
        done[omit] = counts[-1][WORK[name]]
    assert done[True] < done[False]


def test_a_picture_that_differs_ends_with_1(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)

    def make(_settings: omissions.Settings, omit: bool) -> omissions.Side:
        return lambda frame: omissions.Drawn(b"same" if omit or frame < 2 else b"other", 10)

    wrong = omissions.Omission("nothing", "something", make)
    monkeypatch.setattr(omissions, "OMISSIONS", (wrong,))
    assert main(("bench", "omissions", "--frames", "3")) == 1
    assert "pictures differ: nothing" in capsys.readouterr().err
    (row,) = json.loads(Path("bench_omissions.json").read_text("utf-8"))["rows"]
    assert row["pictures_that_differ"] == 1


def test_bytes_not_read_are_taken_from_the_sentence() -> None:
    row = {"left_out": ["no deformation", "1,200 of 3,400 bytes of geometry not read"]}
    assert bench_omissions._bytes(row) == (1200, 3400)
    assert bench_omissions._bytes({"left_out": []}) == (0, 0)
