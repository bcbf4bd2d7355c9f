"""One run of `regraft render`, from checking the outputs to the last line of the summary."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import regraft
from regraft.cli import summary
from regraft.cli.backend import RecordingBackend, choose_backend
from regraft.cli.console import Console, Progress
from regraft.cli.errors import (
    EXIT_OK,
    InputError,
    InterruptedRunError,
    OutputError,
    describe_write_failure,
)
from regraft.cli.interrupt import Interrupt
from regraft.cli.job import RenderJob, SceneInfo, fingerprint
from regraft.cli.ledger import Ledger, ResumePlan
from regraft.cli.shot_plan import planned
from regraft.formats import atomic, images, jsonl, movie

Row = dict[str, Any]


@dataclass(frozen=True)
class Outputs:
    """Where the results go."""

    folder: Path
    stem: str
    suffix: str
    statistics: Path | None
    movie: Path | None
    resume: bool

    def frame_path(self, frame: int) -> Path:
        """`shot_0001.png`, as Blender numbers its frames."""
        sign = "-" if frame < 0 else ""
        return self.folder / f"{self.stem}_{sign}{abs(frame):04d}{self.suffix}"


@dataclass
class RenderRun:
    """Does the work of one command; `frames` None: the file's range."""

    job: RenderJob
    outputs: Outputs
    frames: Sequence[int] | None
    console: Console
    verbose: bool = False
    explain: bool = False
    choose: Callable[[bool], RecordingBackend] = choose_backend

    def run(self) -> int:
        """Raises CommandError with the exit code that fits."""
        prepare(self.outputs)
        with Interrupt(self.console).watching() as interrupt:
            backend = self.choose(self.verbose)
            try:
                return self._render_file(backend, interrupt)
            finally:
                backend.close()

    def _render_file(self, backend: RecordingBackend, interrupt: Interrupt) -> int:
        info = backend.open(self.job)
        for note in info.notes:
            self.console.note(note)
        targets = {f: self.outputs.frame_path(f) for f in self.frames or info.frames}
        ledger = Ledger(self.outputs.folder, fingerprint(self.job, info, regraft.__version__))
        plan = self._plan(ledger, targets)
        with planned(self.job, backend, plan.todo, self.console, interrupt):
            recorder = Recorder(self.outputs, info, ledger)
            rows = self._render_frames(backend, interrupt, plan, recorder)
        for warning in summary.warnings(rows):
            self.console.warn(warning)
        if interrupt.asked:
            raise InterruptedRunError(_interrupted(len(rows), len(plan.todo)))
        if rows and not any(row.get("triangles") for row in rows):
            raise InputError(f"{self.job.source}: nothing is visible in any of the frames")
        self._finish(info, list(targets.values()), rows)
        return EXIT_OK

    def _plan(self, ledger: Ledger, targets: dict[int, Path]) -> ResumePlan:
        try:
            plan = ResumePlan(missing=list(targets))
            if self.outputs.resume:
                plan = ledger.plan(targets)
                self.console.say(plan.describe())
            start_statistics(self.outputs.statistics, set(plan.done))
        except OSError as error:
            raise describe_write_failure(self.outputs.folder, error) from error
        return plan

    def _render_frames(
        self, backend: RecordingBackend, interrupt: Interrupt, plan: ResumePlan, recorder: Recorder
    ) -> list[Row]:
        rows: list[Row] = []
        with self.console.progress(len(plan.todo), "render") as progress:
            for frame in plan.todo:
                if interrupt.asked:
                    break
                rows.append(self._render_frame(backend, interrupt, frame, recorder))
                self._show(rows[-1], progress)
        return rows

    def _render_frame(
        self, backend: RecordingBackend, interrupt: Interrupt, frame: int, recorder: Recorder
    ) -> Row:
        target = self.outputs.frame_path(frame)
        temporary = interrupt.temporary = atomic.temporary_path(target).absolute()
        try:
            row = backend.render(frame, temporary)
            return recorder.keep(row, temporary, target)
        except (OSError, OutputError, images.DamagedImageError) as error:
            raise describe_write_failure(target, error) from error
        finally:
            temporary.unlink(missing_ok=True)
            interrupt.temporary = None

    def _show(self, row: Row, progress: Progress) -> None:
        name = self.outputs.frame_path(row["frame"]).name
        progress.step(summary.frame_line(row, name), f"frame {row['frame']}")
        for line in summary.plan(row) if self.explain else ():
            progress.say(f"    {line}")

    def _finish(self, info: SceneInfo, files: list[Path], rows: list[Row]) -> None:
        if self.outputs.movie:
            self._write_movie(self.outputs.movie, info.fps, files)
        self.console.say(f"frames: {self.outputs.folder} ({len(files)} files)")
        if self.outputs.movie:
            self.console.say(f"movie: {self.outputs.movie}")
        if self.outputs.statistics:
            self.console.say(f"statistics: {self.outputs.statistics}")
        for line in summary.summarise(rows):
            self.console.say(line)

    def _write_movie(self, target: Path, fps: float, files: list[Path]) -> None:
        self.console.note(f"putting {len(files)} frames together in {target}")
        try:
            movie.write_movie(target, files, fps)
        except (OSError, ValueError, RuntimeError) as error:
            raise describe_write_failure(target, error) from error


@dataclass(frozen=True)
class Recorder:
    """Checks a frame that was written, puts it in place and keeps its books."""

    outputs: Outputs
    info: SceneInfo
    ledger: Ledger

    def keep(self, row: Row, temporary: Path, target: Path) -> Row:
        """The completed row. Raises OSError or DamagedImageError; then `target` is untouched."""
        started = time.perf_counter()
        images.verify(temporary, self.info.width, self.info.height)
        atomic.commit(temporary, target)
        self.ledger.record(target)
        spent = (time.perf_counter() - started) * 1e3
        row = {**row, "write_ms": row["write_ms"] + spent, "total_ms": row["total_ms"] + spent}
        if self.outputs.statistics:
            jsonl.append(self.outputs.statistics, row)
        return row


def prepare(outputs: Outputs) -> None:
    """Finds out before any work whether the outputs can be written. Raises OutputError."""
    try:
        atomic.prepare_folder(outputs.folder)
    except OSError as error:
        raise describe_write_failure(outputs.folder, error) from error
    for target in (outputs.statistics, outputs.movie):
        if target:
            _check_target(target)
    try:
        images.load_decoder(outputs.suffix)
        if outputs.movie:
            movie.available()
    except (ImportError, RuntimeError) as error:
        raise OutputError(f"a package that writes or checks the output: {error}") from error


def start_statistics(path: Path | None, kept_frames: set[int]) -> None:
    """Leaves in the file the rows of frames that are not rendered again. Raises OSError."""
    if path:
        jsonl.rewrite(path, [r for r in jsonl.read(path) if r.get("frame") in kept_frames])


def _check_target(target: Path) -> None:
    if target.is_dir():
        raise OutputError(f"cannot write {target}: it is a folder")
    try:
        with atomic.probe(target):
            pass
    except OSError as error:
        raise describe_write_failure(target, error) from error


def _interrupted(done: int, wanted: int) -> str:
    return (
        f"interrupted: {done} of {wanted} frames were rendered and are complete; "
        "the same command with --resume renders the others"
    )
