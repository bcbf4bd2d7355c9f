"""Measures whole frames in Blender, engine against engine."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from statistics import median
from typing import Any

from regraft.cli.backend import find_program
from regraft.cli.backend_subprocess import SubprocessBackend, blender_command, bpy_command
from regraft.cli.errors import CommandError
from regraft.cli.job import RenderJob
from regraft.cli.machine import machine_line

ENGINES = ("REGRAFT", "CYCLES", "BLENDER_WORKBENCH")
# Further jobs of Regraft alone: tracing without shadow rays, and refitting without much tracing.
CLAY, REFIT = "clay", "refit"
REFIT_SIZE = (64, 36)
Row = dict[str, Any]


@dataclass
class Contestant:
    """A process of its own that renders the file in one way; `reason`: why it cannot."""

    job: RenderJob
    backend: SubprocessBackend | None = None
    frames: tuple[int, ...] = ()
    rows: list[Row] = field(default_factory=list)
    reason: str = ""


def measure(source: Path, count: int, size: tuple[int, int], verbose: bool) -> dict[str, Any]:
    """Medians by engine over `count` frames, and what Regraft alone can tell.

    The contestants take turns frame by frame, so that whatever else the machine does hits all
    alike. Raises InputError if Regraft cannot render the file; another engine that cannot is left
    out with its reason.
    """
    file = str(source)
    contestants = {engine: Contestant(RenderJob(file, *size, engine=engine)) for engine in ENGINES}
    contestants[CLAY] = Contestant(RenderJob(file, *size, shading="clay"))
    contestants[REFIT] = Contestant(RenderJob(file, *REFIT_SIZE, shading="clay", policy="refit"))
    with tempfile.TemporaryDirectory() as folder:
        try:
            for contestant in contestants.values():
                _attempt(contestant, partial(_open, count=count + 1, verbose=verbose))
            for turn in range(count + 1):
                for contestant in contestants.values():
                    _attempt(contestant, partial(_render, turn=turn, folder=Path(folder)))
        finally:
            for contestant in contestants.values():
                if contestant.backend:
                    contestant.backend.close()
    return _result(contestants)


def _attempt(contestant: Contestant, step: Callable[[Contestant], None]) -> None:
    """One step, unless the contestant is out. A failing Regraft ends the benchmark."""
    if contestant.reason:
        return
    try:
        step(contestant)
    except CommandError as error:
        if contestant.job.engine == "REGRAFT":
            raise
        contestant.reason = str(error).splitlines()[0]


def _open(contestant: Contestant, count: int, verbose: bool) -> None:
    """Starts the process; its frames are `count` in a row from the middle of the file's range."""
    contestant.backend = SubprocessBackend(worker_command(), verbose)
    frames = contestant.backend.open(contestant.job).frames
    first = max(0, (len(frames) - count) // 2)
    contestant.frames = frames[first : first + count]


def _render(contestant: Contestant, turn: int, folder: Path) -> None:
    assert contestant.backend
    if turn < len(contestant.frames):
        path = folder / "frame.png"
        contestant.rows.append(contestant.backend.render(contestant.frames[turn], path))


def _result(contestants: dict[str, Contestant]) -> dict[str, Any]:
    engines = {
        name: {"unavailable": c.reason} if (c := contestants[name]).reason else _medians(c.rows)
        for name in ENGINES
    }
    details = _details(contestants["REGRAFT"].rows)
    refits = [row for row in contestants[REFIT].rows[1:] if row["deformed_meshes"]]
    if refits:
        details["read_and_refit_ms"] = median(r["extract_ms"] + r["update_ms"] for r in refits)
    clay = contestants[CLAY].rows
    details["primary_rays_per_second"] = _rays_per_second(clay[1:] or clay)
    return {"engines": engines, "regraft_only": details}


def table(result: dict[str, Any]) -> Iterator[str]:
    """The result as lines for people."""
    width, height = result["resolution"]
    yield f"{result['file']}, {width} x {height}, median of {result['frames']} frames"
    yield machine_line(result)
    yield f"{'':<18}{'s a frame':>12}{'no file':>10}{'no file, no evaluation':>24}{'first':>8}"
    for name, values in result["engines"].items():
        yield _engine_line(name, values)
    only = result["regraft_only"]
    if "read_and_refit_ms" in only:
        yield f"deforming meshes: read and refitted in {only['read_and_refit_ms']:.1f} ms a frame"
    yield f"trees: {only['bytes_a_triangle']:.1f} bytes a triangle"
    yield f"primary rays: {only['primary_rays_per_second'] / 1e6:.1f} million a second"


def _engine_line(name: str, values: dict[str, Any]) -> str:
    if "unavailable" in values:
        return f"{name:<18} not measured: {values['unavailable']}"
    return (
        f"{name:<18}{values['with_file_s']:>12.3f}{values['without_file_s']:>10.3f}"
        f"{values['net_s']:>24.3f}{values['first_frame_s']:>8.2f}"
    )


def worker_command() -> list[str]:
    """Starts a Blender of its own."""
    program = find_program()
    return bpy_command() if program is None else blender_command(program)


def _medians(rows: Sequence[Row]) -> dict[str, float]:
    """Seconds a frame; the first frame counts only if it is the only one."""
    steady = rows[1:] or rows
    return {
        "with_file_s": median(r["total_ms"] for r in steady) / 1e3,
        "without_file_s": median(r["total_ms"] - r["write_ms"] for r in steady) / 1e3,
        "net_s": median(r["total_ms"] - r["write_ms"] - r["evaluate_ms"] for r in steady) / 1e3,
        "first_frame_s": rows[0]["total_ms"] / 1e3,
    }


def _details(rows: Sequence[Row]) -> dict[str, Any]:
    steady, last = rows[1:] or rows, rows[-1]
    names = ("evaluate_ms", "extract_ms", "update_ms", "trace_ms", "shade_ms", "write_ms")
    return {
        **{name: median(row[name] for row in steady) for name in names},
        "triangles": last["triangles"],
        "memory_bytes": last["memory_bytes"],
        "bytes_a_triangle": last["memory_bytes"] / max(1, last["triangles"]),
    }


def _rays_per_second(rows: Sequence[Row]) -> float:
    return float(median(row["rays_primary"] / max(row["trace_ms"], 1e-6) * 1e3 for row in rows))
