"""Talking to a Blender in another process, and what is said when it dies."""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path

import pytest

from regraft.cli import errors, protocol
from regraft.cli.backend_subprocess import SubprocessBackend
from regraft.cli.job import RenderJob

WORKER = """
import json, os, signal, sys
answers = os.fdopen(os.dup(1), "w")
print("noise before the greeting", flush=True)
os.dup2(2, 1)
answers.write("regraft worker ready\\n"); answers.flush()
print("noise on what was stdout", flush=True)
for line in sys.stdin:
    request = json.loads(line)
    if request.get("frame") == 13:
        print("a last word", flush=True)
        os.kill(os.getpid(), signal.SIGSEGV)
    answers.write(json.dumps(ANSWERS[request["call"]]) + "\\n"); answers.flush()
"""


def worker(tmp_path: Path, **answers: object) -> list[str]:
    """Command of a worker that gives these answers, and dies on frame 13."""
    script = tmp_path / "worker.py"
    script.write_text(
        f"ANSWERS = json.loads({json.dumps(answers)!r})\n".join(["import json\n", WORKER])
    )
    return [sys.executable, str(script)]


def test_noise_does_not_disturb_the_talk(tmp_path: Path) -> None:
    backend = SubprocessBackend(worker(tmp_path, probe={"ok": {"blender": "9"}}), False)
    assert backend.probe() == {"blender": "9"}
    backend.close()


@pytest.mark.parametrize("kind", [errors.InputError, errors.OutputError, errors.SelfCheckError])
def test_an_error_keeps_its_exit_code(tmp_path: Path, kind: type[errors.CommandError]) -> None:
    answer = {"error": "no such thing", "exit_code": kind.exit_code}
    backend = SubprocessBackend(worker(tmp_path, render=answer), False)
    with pytest.raises(kind, match="no such thing"):
        backend.render(1, tmp_path / "a.png")
    backend.close()


def test_a_worker_that_dies_is_reported_with_its_last_words(tmp_path: Path) -> None:
    backend = SubprocessBackend(worker(tmp_path), False)
    with pytest.raises(errors.InputError, match=r"Blender died \(SIGSEGV\)\n.*\n.*a last word"):
        backend.render(13, tmp_path / "a.png")
    backend.close()


def test_a_program_that_is_no_blender_is_reported(tmp_path: Path) -> None:
    command = [sys.executable, "-c", "import sys; sys.exit('not Blender')"]
    with pytest.raises(errors.InputError, match=r"did not start \(exit code 1\)\n +not Blender"):
        SubprocessBackend(command, False)


class Worker:
    """Stands in for the BlenderWorker that `serve` would call."""

    def probe(self) -> dict[str, str]:
        return {"blender": "1"}

    def open(self, job: RenderJob) -> None:
        raise errors.InputError(f"{job.source} is bad")

    def render(self, frame: int, path: Path) -> dict[str, object]:
        raise ZeroDivisionError(f"frame {frame}")

    def close(self) -> None:
        pass


def serve_lines(monkeypatch: pytest.MonkeyPatch, *requests: object) -> list[dict[str, object]]:
    """What `serve` answers, run on pipes in place of stdin and stdout."""
    monkeypatch.setattr("regraft.cli.blender_worker.BlenderWorker", Worker)
    monkeypatch.setattr(sys, "excepthook", lambda *_: None)
    request_end, request_in = os.pipe()
    answer_out, answer_in = os.pipe()
    saved = [os.dup(0), os.dup(1)]
    os.write(request_in, "".join(json.dumps(r) + "\n" for r in requests).encode())
    os.close(request_in)
    os.dup2(request_end, 0)
    os.dup2(answer_in, 1)
    try:
        protocol.serve()
    finally:
        for number, old in enumerate(saved):
            os.dup2(old, number)
            os.close(old)
    for descriptor in (request_end, answer_in):
        os.close(descriptor)
    with os.fdopen(answer_out, "rb") as answers:
        assert answers.readline() == protocol.GREETING
        return [json.loads(line) for line in answers]


def test_requests_are_answered_in_order(monkeypatch: pytest.MonkeyPatch) -> None:
    job = RenderJob("x.blend").as_json()
    answers = serve_lines(
        monkeypatch,
        {"call": "probe"},
        {"call": "open", "job": job},
        {"call": "render", "frame": 7, "path": "a"},
    )
    assert answers == [
        {"ok": {"blender": "1"}},
        {"error": "x.blend is bad", "exit_code": 3},
        {"error": "ZeroDivisionError: frame 7", "exit_code": 1},
    ]
