"""`regraft study …` as a shell sees it, on recordings made without Blender."""

from __future__ import annotations

import csv
import os
import signal
from pathlib import Path
from typing import Any

import pytest

from regraft.cli import main, recording
from regraft.study import fingerprint, plots
from stand_in_recording import RecordingStandIn

QUICK = ("--policies", "refit,auto", "--repeats", "2", "--size", "8", "--threads", "1")


@pytest.fixture
def backend(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> RecordingStandIn:
    found = RecordingStandIn()
    monkeypatch.setattr(recording, "choose_backend", lambda _verbose: found)
    monkeypatch.chdir(tmp_path)
    for name in ("hills.blend", "other/hills.blend"):
        Path(name).parent.mkdir(exist_ok=True)
        Path(name).touch()
    return found


def rows(path: str) -> list[dict[str, str]]:
    with Path(path).open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_update_writes_a_page_and_its_tables(
    backend: RecordingStandIn, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ("study", "update", "hills.blend", "other/hills.blend", *QUICK)
    assert main(words) == 0
    said = capsys.readouterr().out
    page = Path("study_update", "index.html").read_text("utf-8")
    verdicts = [line.partition(": ")[2] for line in said.splitlines() if line.startswith("hills")]
    assert len(verdicts) == 2
    assert all(verdict in page for verdict in verdicts)
    assert page.count("data:image/svg+xml") == 10
    measured = rows("study_update/update.csv")
    assert len(measured) == 2 * 2 * 3 * 3, "scenes, replays, frames, policies"
    assert {row["scene"] for row in measured} == {"hills", "hills (2)"}
    assert len(rows("study_update/update_totals.csv")) == 6
    assert backend.closed


def test_frames_can_be_chosen(backend: RecordingStandIn) -> None:
    assert main(("study", "update", "hills.blend", *QUICK, "--frames", "2-9")) == 0
    assert {row["frame"] for row in rows("study_update/update.csv")} == {"2", "3"}
    assert main(("study", "update", "hills.blend", *QUICK, "--frames", "7")) == 3


def test_hits_that_differ_end_with_1(
    backend: RecordingStandIn, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    letters = iter(range(1000))
    monkeypatch.setattr(fingerprint, "of", lambda *_: str(next(letters)))
    assert main(("study", "update", "hills.blend", *QUICK)) == 1
    assert "an identity failed: hills" in capsys.readouterr().err
    assert "policies do not agree" in Path("study_update/index.html").read_text("utf-8")


def test_an_interrupt_leaves_nothing_half_done(
    backend: RecordingStandIn, capsys: pytest.CaptureFixture[str]
) -> None:
    temporary: list[Path] = []

    def stop(frame: int) -> None:
        temporary.append(Path(backend._writer._folder))
        if frame == 2:
            os.kill(os.getpid(), signal.SIGINT)

    backend._at_frame = stop
    assert main(("study", "update", "hills.blend", *QUICK)) == 130
    assert "interrupted" in capsys.readouterr().err
    assert list(Path("study_update").iterdir()) == []
    assert not temporary[0].exists()
    assert backend.closed


def test_an_interrupt_while_measuring(
    backend: RecordingStandIn, monkeypatch: pytest.MonkeyPatch
) -> None:
    true_fingerprint = fingerprint.of

    def stop(*args: Any) -> str:
        os.kill(os.getpid(), signal.SIGINT)
        monkeypatch.setattr(fingerprint, "of", true_fingerprint)
        return true_fingerprint(*args)

    monkeypatch.setattr(fingerprint, "of", stop)
    assert main(("study", "update", "hills.blend", *QUICK)) == 130
    assert list(Path("study_update").iterdir()) == []


def test_without_matplotlib_the_cure_is_told(
    backend: RecordingStandIn, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(__import__("sys").modules, "matplotlib.pyplot", None)
    assert main(("study", "update", "hills.blend", *QUICK)) == 4
    assert plots.HOW_TO_GET in capsys.readouterr().err
    assert "pip install 'regraft[study]'" in plots.HOW_TO_GET
    assert not backend.closed, "nothing was begun"


def test_a_file_that_is_not_there_is_bad_input(backend: RecordingStandIn) -> None:
    assert main(("study", "update", "hills.blend", "missing.blend", *QUICK)) == 3


def test_an_output_that_cannot_be_made(backend: RecordingStandIn) -> None:
    Path("taken").touch()
    assert main(("study", "update", "hills.blend", *QUICK, "--output", "taken")) == 4
