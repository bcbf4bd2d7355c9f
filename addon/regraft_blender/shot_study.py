"""`regraft study update` on a copy of the open file, in a process of its own."""

from __future__ import annotations

import importlib.util
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import bpy

from . import compat

POLICIES = ("refit", "selective", "selective+rotate", "auto")
# What the command prints after each step.
_STEP = re.compile(r"^\[(\d+)/(\d+)\] (.*)$", re.MULTILINE)
_ENDED_WELL, _ASKED_TO_END = 0, 130
_PATIENCE = 10.0

Row = dict[str, Any]


@dataclass(frozen=True)
class Findings:
    """What a study found: its verdict, a row for each frame and policy, and its page."""

    verdict: str
    rows: list[Row]
    page: Path


class ShotStudy:
    """One run; `findings` or `problem` are there when it has ended."""

    def __init__(self, scene: bpy.types.Scene, threads: int) -> None:
        """Saves a copy of the file, as it is now, and starts. Raises OSError, RuntimeError."""
        self.shot = f"{scene.name}, frames {scene.frame_start} to {scene.frame_end}"
        self.findings: Findings | None = None
        self.problem = ""
        self._folder = Path(tempfile.mkdtemp(prefix="regraft_study_", dir=bpy.app.tempdir or None))
        copy = self._folder / f"{_stem()}.blend"
        bpy.ops.wm.save_as_mainfile(filepath=str(copy), copy=True, check_existing=False)
        self._output = self._folder / "study"
        with (self._folder / "log").open("wb") as log:
            self._process = subprocess.Popen(
                _command(copy, self._output, threads),
                env=_environment(),
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=subprocess.STDOUT,
                cwd=self._folder,
            )

    def is_running(self) -> bool:
        """Whether it still runs; takes in what it found as soon as it does not."""
        if self.findings or self.problem:
            return False
        code = self._process.poll()
        if code is None:
            return True
        self._take_in(code)
        return False

    def wait(self) -> None:
        """Until it has ended."""
        self._process.wait()
        self.is_running()

    def progress(self) -> tuple[float, str]:
        """Share of the steps done, and the last step in words."""
        steps = _STEP.findall(self._said())
        if not steps:
            return 0.0, "reading the shot"
        done, total, step = steps[-1]
        return int(done) / int(total), step

    def cancel(self) -> None:
        """Ends it, and what it started; nothing is found then."""
        if self._process.poll() is None:
            self._process.terminate()
            try:
                self._process.wait(_PATIENCE)
            except subprocess.TimeoutExpired:
                self._process.kill()
                self._process.wait()
        if not self.findings:
            self.problem = self.problem or "cancelled"

    def close(self) -> None:
        """Cancels, and removes all files."""
        self.cancel()
        shutil.rmtree(self._folder, ignore_errors=True)

    def _said(self) -> str:
        return (self._folder / "log").read_text(encoding="utf-8", errors="replace")

    def _take_in(self, code: int) -> None:
        if code != _ENDED_WELL:
            last = self._said().strip().splitlines()[-1:] or [f"exit code {code}"]
            self.problem = "cancelled" if code == _ASKED_TO_END else last[0]
            return
        (found,) = _json_lines(self._output / "verdicts.jsonl")
        rows = _json_lines(self._output / "update.jsonl")
        self.findings = Findings(found["verdict"], rows, self._output / "index.html")


def _stem() -> str:
    return Path(bpy.data.filepath).stem or "untitled"


def _json_lines(path: Path) -> list[Row]:
    return [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines()]


def _command(copy: Path, output: Path, threads: int) -> list[str]:
    words = [_python(), "-m", "regraft", "study", "update", str(copy)]
    words += ["--output", str(output), "--policies", ",".join(POLICIES), "--threads", str(threads)]
    # Blender's own Python has no matplotlib; the panel draws for itself.
    return words if importlib.util.find_spec("matplotlib") else [*words, "--no-plots"]


def _python() -> str:
    """The Python whose packages Blender uses: a Blender that has none of its own takes
    `sys.executable` from the PATH, where another one may come first."""
    own = Path(sys.prefix) / "bin" / f"python{sys.version_info.major}.{sys.version_info.minor}"
    return str(own) if own.exists() else sys.executable


def _environment() -> dict[str, str]:
    """With a Python that finds the library, the add-on under its plain name, and this Blender."""
    folders = [compat.library_folder()]
    if __package__ == "regraft_blender":
        folders.append(str(Path(__file__).parents[1]))
    kept = {k: v for k, v in os.environ.items() if k != "PYTHONHOME"}
    found = kept | {"PYTHONPATH": os.pathsep.join(folders), "PYTHONUNBUFFERED": "1"}
    if not getattr(bpy.app, "module", False):
        found["REGRAFT_BLENDER"] = bpy.app.binary_path
    return found


_studies: list[ShotStudy] = []


def last() -> ShotStudy | None:
    """The study started last, running or ended."""
    return _studies[-1] if _studies else None


def start(scene: bpy.types.Scene, threads: int) -> ShotStudy:
    """A new one in the place of the last. Raises OSError, RuntimeError."""
    close()
    _studies.append(ShotStudy(scene, threads))
    return _studies[-1]


def close() -> None:
    """Ends the last and removes its files."""
    while _studies:
        _studies.pop().close()
