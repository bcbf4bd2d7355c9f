"""The words that the command and a Blender in another process exchange, one JSON line each."""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path
from typing import IO, Any

from regraft.cli import errors
from regraft.cli.job import RenderJob
from regraft.formats import jsonl

GREETING = b"regraft worker ready\n"
_ERRORS = {
    kind.exit_code: kind
    for kind in (errors.SelfCheckError, errors.UsageError, errors.InputError, errors.OutputError)
}


def serve() -> None:
    """Answers requests on stdin until it ends; runs inside Blender.

    The real stdout is kept for answers; whatever Blender prints goes to stderr from here on.
    """
    from regraft.cli.blender_worker import BlenderWorker

    with os.fdopen(os.dup(1), "wb", buffering=0) as answers, os.fdopen(os.dup(0), "rb") as requests:
        os.dup2(2, 1)
        worker = BlenderWorker()
        answers.write(GREETING)
        try:
            for line in requests:
                answers.write(jsonl.encode(_answer(worker, json.loads(line))))
        finally:
            worker.close()


def _answer(worker: Any, request: dict[str, Any]) -> dict[str, Any]:
    try:
        return {"ok": _call(worker, request)}
    except errors.CommandError as error:
        return {"error": str(error), "exit_code": error.exit_code}
    except Exception as error:  # noqa: BLE001 - the other process shows it, this one lives on
        sys.excepthook(type(error), error, error.__traceback__)
        return {"error": f"{type(error).__name__}: {error}", "exit_code": 1}


def _call(worker: Any, request: dict[str, Any]) -> Any:
    if request["call"] == "open":
        return worker.open(RenderJob.from_json(request["job"])).as_json()
    if request["call"] == "probe":
        return worker.probe()
    if request["call"] == "read_everything":
        return worker.read_everything()
    if request["call"] == "begin_recording":
        return worker.begin_recording(Path(request["folder"]))
    if request["call"] == "record_frame":
        return worker.record_frame(request["frame"])
    if request["call"] == "end_recording":
        return worker.end_recording(request["is_complete"])
    if request["call"] == "plan":
        return worker.plan(Path(request["folder"]))
    return worker.render(request["frame"], Path(request["path"]))


def ask(requests: IO[bytes], answers: IO[bytes], request: dict[str, Any]) -> Any:
    """Sends one request and returns the answer.

    Raises the error the worker met, or EOFError if it is gone.
    """
    try:
        requests.write(jsonl.encode(request))
        requests.flush()
        line = answers.readline()
    except BrokenPipeError as error:
        raise EOFError from error
    if not line.endswith(b"\n"):
        raise EOFError
    answer = json.loads(line)
    if "ok" in answer:
        return answer["ok"]
    raise _ERRORS.get(answer["exit_code"], errors.CommandError)(answer["error"])
