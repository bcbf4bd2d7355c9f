"""Measures whole frames in Blender, engine against engine."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path
from statistics import median
from typing import Any

from regraft.cli.backend import find_program
from regraft.cli.backend_subprocess import SubprocessBackend, blender_command, bpy_command
from regraft.cli.errors import CommandError
from regraft.cli.job import RenderJob

ENGINES = ("REGRAFT", "CYCLES", "BLENDER_WORKBENCH")
Row = dict[str, Any]


def measure(source: Path, count: int, size: tuple[int, int], verbose: bool) -> dict[str, Any]:
    """Medians by engine over `count` frames, and what Regraft alone can tell.

    Raises InputError if Regraft cannot render the file; another engine that cannot is left out
    with its reason.
    """
    command = _worker_command()
    engines: dict[str, Any] = {}
    for engine in ENGINES:
        job = RenderJob(str(source), *size, engine=engine)
        try:
            rows = _render(command, job, count, verbose)
        except CommandError as error:
            if engine == "REGRAFT":
                raise
            engines[engine] = {"unavailable": str(error).splitlines()[0]}
            continue
        engines[engine] = _medians(rows)
        if engine == "REGRAFT":
            details = _details(rows)
    clay = _render(command, RenderJob(str(source), *size, shading="clay"), count, verbose)
    details["primary_rays_per_second"] = _rays_per_second(clay[1:] or clay)
    return {"engines": engines, "regraft_only": details}


def table(result: dict[str, Any]) -> Iterator[str]:
    """The result as lines for people."""
    width, height = result["resolution"]
    yield f"{result['file']}, {width} x {height}, median of {result['frames']} frames"
    yield f"{result['processor']}, {result['cores']} cores, {result['simd']}; " + (
        f"regraft {result['regraft']} {result['commit']}".rstrip()
    )
    yield f"{'':<18}{'s a frame':>12}{'no file':>10}{'no file, no evaluation':>24}{'first':>8}"
    for name, values in result["engines"].items():
        yield _engine_line(name, values)
    only = result["regraft_only"]
    yield f"deforming mesh: read {only['extract_ms']:.1f} ms, update {only['update_ms']:.1f} ms"
    yield f"trees: {only['bytes_a_triangle']:.1f} bytes a triangle"
    yield f"primary rays: {only['primary_rays_per_second'] / 1e6:.1f} million a second"


def _engine_line(name: str, values: dict[str, Any]) -> str:
    if "unavailable" in values:
        return f"{name:<18} not measured: {values['unavailable']}"
    return (
        f"{name:<18}{values['with_file_s']:>12.3f}{values['without_file_s']:>10.3f}"
        f"{values['net_s']:>24.3f}{values['first_frame_s']:>8.2f}"
    )


def _worker_command() -> list[str]:
    program = find_program()
    return bpy_command() if program is None else blender_command(program)


def _render(command: list[str], job: RenderJob, count: int, verbose: bool) -> list[Row]:
    """Statistics of the first `count` + 1 frames, rendered in a fresh process."""
    backend = SubprocessBackend(command, verbose)
    try:
        frames = backend.open(job).frames[: count + 1]
        with tempfile.TemporaryDirectory() as folder:
            return [backend.render(frame, Path(folder, f"{frame}.png")) for frame in frames]
    finally:
        backend.close()


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
