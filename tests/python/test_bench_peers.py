"""`regraft bench update --peers`: shots as the native program reads them, its rows as tables."""

from __future__ import annotations

import argparse
import json
import struct
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import regraft
from regraft.cli import bench_peers, native_program, peer_shot_file
from regraft.cli.console import Console
from regraft.cli.errors import InputError, SelfCheckError
from regraft.cli.interrupt import Interrupt
from regraft.study import local_motion
from regraft.study.shot import Shot, ShotWriter

CORNERS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], np.float32)
FACE = np.array([[0, 1, 2]], np.uint32)


def row(repeat: int, frame: int, contender: str, update: float, trace: float) -> dict[str, Any]:
    times = {"update": update, "primary": trace, "shadow": 1.0}
    times |= {"primary_single": 9.0, "shadow_single": 9.0}
    clocks = {f"{name}{clock}_ms": ms for name, ms in times.items() for clock in ("", "_cpu")}
    return {"repeat": repeat, "frame": frame, "contender": contender, "bytes": 5_000_000, **clocks}


ROWS = [
    row(repeat, frame, contender, update + (frame == 1) * 100 + (repeat == 2) * 50, trace)
    for repeat in range(3)
    for frame in (1, 2, 3)
    for contender, update, trace in (
        ("regraft auto flat", 2.0, 3.0),
        ("regraft refit flat", 1.0, 3.0),
        ("embree refit instances", 4.0, 1.0),
        ("embree sah one mesh", 40.0, 1.0),
    )
]


def program(folder: Path, rows: list[dict[str, Any]], code: int = 0) -> Path:
    """A program that prints `rows`, writes its arguments beside itself and fails with `code`."""
    path = folder / "program"
    text = "\n".join(json.dumps(r) for r in rows)
    path.write_text(
        f"#!{sys.executable}\nimport sys\nprint({text!r})\nprint('why', file=sys.stderr)\n"
        f"open({str(folder / 'arguments')!r}, 'w').write(' '.join(sys.argv[2:]))\n"
        f"sys.exit({code})\n"
    )
    path.chmod(0o755)
    return path


def moving_shot(folder: Path) -> Shot:
    """Two placed triangles: one moves, then the other deforms, then one is hidden."""
    place = np.eye(4)
    place[:3, 3] = (0, 0, 5)
    folder.mkdir()
    with ShotWriter(folder) as writer:
        writer.add_call("add_mesh", (CORNERS, FACE), {"name": "a"})
        writer.add_call("add_mesh", (CORNERS, FACE), {})
        both = np.array([0, 1], np.uint32)
        writer.add_call("add_instances", (both, np.stack([np.eye(4)] * 2)), {})
        writer.end_frame(1, local_motion.view())
        writer.add_call("set_transform", (1, place), {})
        writer.end_frame(2, local_motion.view())
        writer.add_call("set_vertices", (0, CORNERS * 2), {})
        writer.end_frame(3, local_motion.view())
        writer.add_call("set_visible", (0, False), {})
        writer.end_frame(4, local_motion.view())
    return Shot(folder)


def test_frames_after_the_first_are_summed_over_medians_of_replays() -> None:
    totals = bench_peers.totals(ROWS)
    assert [r["contender"] for r in totals][:2] == ["regraft refit flat", "regraft auto flat"]
    auto = totals[1]
    assert auto["update_s"] == pytest.approx(0.004)
    assert auto["trace_s"] == pytest.approx(0.008), "packets were faster than single rays"
    assert auto["update_worst_ms"] == 2.0


def test_ours_is_set_against_the_best_of_embrees_ways() -> None:
    ratios = bench_peers.ratios(bench_peers.totals(ROWS))
    assert ratios["auto"] == pytest.approx(6 / 6)
    assert ratios["best"] == pytest.approx(6 / 5)
    ours = [r for r in ROWS if r["contender"].startswith("regraft")]
    assert bench_peers.ratios(bench_peers.totals(ours)) == {}
    shots = {"a": {"ratios": {**ratios, "best": 4.0}}, "b": {"ratios": {**ratios, "best": 1.0}}}
    assert "our best 2.00x as fast" in next(iter(bench_peers.summary(shots)))


def test_the_program_is_given_the_shot_and_what_was_asked_for(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    args = argparse.Namespace(
        program=program(tmp_path, ROWS),
        size=64,
        threads=2,
        repeats=3,
        policies=("auto", "refit", "shot"),
        layouts=("flat",),
    )
    shot = moving_shot(tmp_path / "shot")
    with Console() as console:
        found = bench_peers.measure("made", shot, args, console, Interrupt(console))
    assert (tmp_path / "arguments").read_text() == "64 2 3 auto,refit flat"
    assert found["rows"] == ROWS
    assert "against Embree's best way" in capsys.readouterr().out


def test_a_program_that_is_missing_or_fails_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="make bench"):
        list(native_program.lines(tmp_path / "none"))
    with pytest.raises(SelfCheckError, match="failed with 3: why"):
        list(native_program.lines(program(tmp_path, [], 3)))


def test_a_shot_is_written_edit_by_edit(tmp_path: Path) -> None:
    path = tmp_path / "shot.bin"
    peer_shot_file.write(moving_shot(tmp_path / "shot"), path)
    mesh = struct.pack("<3I", 1, 3, 1) + CORNERS.tobytes() + FACE.tobytes()
    still = [struct.pack("<2I", 5, i) + np.eye(4).tobytes() for i in (0, 1)]
    first = struct.pack("<I", 4) + mesh * 2 + b"".join(still) + struct.pack("<2I", 0, 1)
    data = path.read_bytes()
    assert data.startswith(first)
    camera = 12 * 8
    moved = data[len(first) + camera :]
    assert struct.unpack_from("<2I", moved) == (6, 1)
    assert struct.unpack_from("<3d", moved, 8 + 12 * 8) == (0.0, 0.0, 5.0), "by columns"
    assert data[-camera - 20 : -camera] == struct.pack("<5I", 7, 0, 0, 0, 4)


def test_only_perspectives_are_written(tmp_path: Path) -> None:
    with ShotWriter(tmp_path) as writer:
        writer.end_frame(1, regraft.Camera("orthographic", np.eye(4)))
    with pytest.raises(InputError, match="orthographic"):
        peer_shot_file.write(Shot(tmp_path), tmp_path / "shot.bin")
