"""The benchmark's arithmetic, and what it does with an engine that cannot."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest

from regraft.cli import bench_sync
from regraft.cli.errors import InputError
from regraft.cli.job import RenderJob, SceneInfo


@dataclass
class Engine:
    """A stand-in for a process that renders: costs depend on the frame and the engine only."""

    command: list[str]
    verbose: bool
    job: RenderJob = field(default_factory=lambda: RenderJob(""))
    log: list[tuple[str, int]] = field(default_factory=list)
    broken: tuple[str, ...] = ()

    def open(self, job: RenderJob) -> SceneInfo:
        self.job = job
        if job.engine in self.broken:
            raise InputError(f"{job.engine} cannot\nfor many reasons")
        return SceneInfo("0", tuple(range(1, 12)), job.width, job.height, 24.0)

    def render(self, frame: int, path: Path) -> dict[str, Any]:
        self.log.append((f"{self.job.engine} {self.job.shading} {self.job.policy}", frame))
        times = {"evaluate_ms": 5, "extract_ms": 1, "update_ms": 3, "trace_ms": 10, "shade_ms": 2}
        counts = {"triangles": 100, "memory_bytes": 7000, "rays_primary": 40, "deformed_meshes": 1}
        return {**times, **counts, "write_ms": 20, "total_ms": 100.0 * frame}

    def close(self) -> None:
        self.log.append((self.job.engine, 0))


def run(monkeypatch: pytest.MonkeyPatch, *broken: str) -> tuple[dict[str, Any], list[Any]]:
    log: list[tuple[str, int]] = []
    monkeypatch.setattr(bench_sync, "worker_command", lambda: ["blender"])
    monkeypatch.setattr(
        bench_sync, "SubprocessBackend", lambda c, v: Engine(c, v, log=log, broken=broken)
    )
    return bench_sync.measure(Path("a.blend"), 4, (64, 48), False), log


def test_medians_leave_the_first_frame_out(monkeypatch: pytest.MonkeyPatch) -> None:
    result, _ = run(monkeypatch)
    assert result["engines"]["CYCLES"] == {
        "with_file_s": pytest.approx(0.65),  # frames 5 to 8 of the eleven, after frame 4
        "without_file_s": pytest.approx(0.63),
        "net_s": pytest.approx(0.625),
        "first_frame_s": pytest.approx(0.4),
    }
    only = result["regraft_only"]
    assert only["bytes_a_triangle"] == 70
    assert only["read_and_refit_ms"] == 4
    assert only["primary_rays_per_second"] == 4000


def test_contestants_take_turns_and_are_closed(monkeypatch: pytest.MonkeyPatch) -> None:
    _, log = run(monkeypatch)
    turn = ["REGRAFT direct auto", "CYCLES direct auto", "BLENDER_WORKBENCH direct auto"]
    turn += ["REGRAFT clay auto", "REGRAFT clay refit"]
    assert log[:10] == [(name, frame) for frame in (4, 5) for name in turn]
    assert [frame for _, frame in log[-5:]] == [0] * 5


def test_another_engine_that_cannot_is_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    result, _ = run(monkeypatch, "BLENDER_WORKBENCH")
    assert result["engines"]["BLENDER_WORKBENCH"] == {"unavailable": "BLENDER_WORKBENCH cannot"}
    about = {"file": "a.blend", "frames": 4, "resolution": [64, 48], "processor": "p", "cores": 2}
    about |= {"simd": "sse", "load_average": 0.5, "regraft": "1", "commit": "abc+"}
    lines = list(bench_sync.table(about | result))
    assert "not measured: BLENDER_WORKBENCH cannot" in "\n".join(lines)
    assert lines[1] == "p, 2 cores, sse, load 0.5; regraft 1 abc+"


def test_a_regraft_that_cannot_ends_the_benchmark(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(InputError, match="REGRAFT cannot"):
        run(monkeypatch, "REGRAFT")
