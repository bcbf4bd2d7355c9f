"""Blender in a process of its own: the `blender` program, or a Python that has bpy."""

from __future__ import annotations

import importlib.util
import json
import signal
import subprocess
import sys
import tempfile
from contextlib import suppress
from pathlib import Path
from typing import Any

from regraft.cli import protocol
from regraft.cli.errors import InputError
from regraft.cli.job import RenderJob, SceneInfo

_BOOTSTRAP = Path(__file__).with_name("bootstrap.py")
# Lines of Blender's own output shown when it dies.
_LAST_WORDS = 12


def blender_command(program: str) -> list[str]:
    """Starts the worker in the program `blender`."""
    return [
        program,
        "-b",
        "--factory-startup",
        "-noaudio",
        "--python-exit-code",
        "3",
        "--python",
        str(_BOOTSTRAP),
        "--",
        _import_roots(),
    ]


def bpy_command() -> list[str]:
    """Starts the worker in a fresh process of this Python, with its bpy."""
    return [sys.executable, str(_BOOTSTRAP), "--", _import_roots()]


class SubprocessBackend:
    """Talks to a worker over its stdin and stdout; what else Blender says goes to a file."""

    def __init__(self, command: list[str], verbose: bool) -> None:
        self.place = f"{Path(command[0]).name}, in a process of its own"
        self._log = None if verbose else tempfile.TemporaryFile()  # noqa: SIM115
        self._process = subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._log,
            # Ctrl-C is for the command to answer; the worker finishes its frame.
            start_new_session=True,
        )
        self._wait_for_greeting()

    def probe(self) -> dict[str, Any]:
        """See BlenderWorker.probe."""
        found: dict[str, Any] = self._ask({"call": "probe"})
        return found

    def open(self, job: RenderJob) -> SceneInfo:
        """See BlenderWorker.open."""
        return SceneInfo.from_json(self._ask({"call": "open", "job": job.as_json()}))

    def render(self, frame: int, path: Path) -> dict[str, Any]:
        """See BlenderWorker.render."""
        row: dict[str, Any] = self._ask({"call": "render", "frame": frame, "path": str(path)})
        return row

    def read_everything(self) -> None:
        """See BlenderWorker.read_everything."""
        self._ask({"call": "read_everything"})

    def begin_recording(self, folder: Path) -> None:
        """See BlenderWorker.begin_recording."""
        self._ask({"call": "begin_recording", "folder": str(folder)})

    def record_frame(self, frame: int) -> None:
        """See BlenderWorker.record_frame."""
        self._ask({"call": "record_frame", "frame": frame})

    def end_recording(self, is_complete: bool) -> None:
        """See BlenderWorker.end_recording."""
        self._ask({"call": "end_recording", "is_complete": is_complete})

    def plan(self, folder: Path) -> None:
        """See BlenderWorker.plan."""
        self._ask({"call": "plan", "folder": str(folder)})

    def close(self) -> None:
        """Ends the worker: it stops by itself when its requests end."""
        assert self._process.stdin
        assert self._process.stdout
        with suppress(BrokenPipeError):
            self._process.stdin.close()
        try:
            self._process.wait(timeout=20)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self._process.stdout.close()
        if self._log:
            self._log.close()

    def _wait_for_greeting(self) -> None:
        assert self._process.stdout
        for line in self._process.stdout:
            if line == protocol.GREETING:
                return
        death = self._death("did not start")
        self.close()
        raise death

    def _ask(self, request: dict[str, Any]) -> Any:
        assert self._process.stdin
        assert self._process.stdout
        try:
            return protocol.ask(self._process.stdin, self._process.stdout, request)
        except EOFError:
            raise self._death("died") from None

    def _death(self, what: str) -> InputError:
        code = self._process.wait()
        reason = signal.Signals(-code).name if code < 0 else f"exit code {code}"
        return InputError(f"Blender {what} ({reason}){self._last_words()}")

    def _last_words(self) -> str:
        if not self._log:
            return ""
        self._log.seek(0)
        lines = self._log.read().decode(errors="replace").strip().splitlines()
        return "".join(f"\n    {line}" for line in lines[-_LAST_WORDS:])


def _import_roots() -> str:
    """JSON: folders from which the worker can import regraft and its add-on, and the native file.

    The native module may lie apart from the package (editable installs).
    """
    import regraft
    from regraft import _regraft

    addon = importlib.util.find_spec("regraft_blender")
    folders = [str(Path(regraft.__file__).parents[1])]
    if addon and addon.origin:
        folders.append(str(Path(addon.origin).parents[1]))
    return json.dumps({"folders": folders, "native": _regraft.__file__})
