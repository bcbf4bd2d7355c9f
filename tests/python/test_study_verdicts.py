"""What each study says is what its own table says: sentences made of the written CSV are equal."""

from __future__ import annotations

import csv
import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import pytest

from regraft.cli import main, recording
from regraft.study import (
    lazy_report,
    plots,
    prediction,
    prediction_report,
    scan,
    scan_report,
    stability,
    stability_report,
    update_verdict,
)
from stand_in_recording import RecordingStandIn

Row = dict[str, Any]


def value(text: str) -> Any:
    """A cell as it was."""
    if text in ("", "True", "False"):
        return {"": None, "True": True, "False": False}[text]
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return text


def rows(path: Path) -> list[Row]:
    if not path.is_file() or not path.stat().st_size:
        return []
    with path.open(newline="", encoding="utf-8") as file:
        return [{k: value(v) for k, v in row.items()} for row in csv.DictReader(file)]


def of_predictions(folder: Path) -> str:
    table = prediction.summary(rows(folder / "prediction.csv"))
    return prediction_report.sentence(table, rows(folder / "prediction_operations.csv"))


STUDIES: dict[str, tuple[Callable[[Path], str], Sequence[str]]] = {
    "update": (
        lambda folder: update_verdict.sentence(rows(folder / "update_totals.csv")),
        ("--size", "8", "--repeats", "1", "--policies", "refit,auto"),
    ),
    "scan": (
        lambda folder: scan_report.sentence(rows(folder / "scan_settings.csv")),
        ("--size", "8", "--repeats", "1"),
    ),
    "prediction": (of_predictions, ("--size", "8")),
    "lazy": (lambda folder: lazy_report.sentence(rows(folder / "lazy.csv")), ("--size", "8")),
    "stability": (
        lambda folder: stability_report.sentence(rows(folder / "stability.csv"))[0],
        ("--size", "8"),
    ),
}


@pytest.mark.parametrize("kind", STUDIES)
def test_the_verdict_is_that_of_the_table(
    kind: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(recording, "choose_backend", lambda _verbose: RecordingStandIn(2))
    monkeypatch.setattr(prediction, "_RESAMPLES", 50)
    monkeypatch.setattr(stability, "EXPONENTS", dict.fromkeys(stability.EXPONENTS, (4,)))
    monkeypatch.setattr(stability, "TIME_STEPS", (10.0,))
    few = tuple(s for s in scan.SPLITTERS if s.label in ("exact", "k = 4", scan.DEFAULT))
    monkeypatch.setattr(scan, "SPLITTERS", few)
    # --no-plots holds for the whole process: put it back for the tests that come later.
    monkeypatch.setattr(plots, "are_wanted", plots.are_wanted)
    source, folder = tmp_path / "hills.blend", tmp_path / "study"
    source.touch()
    sentence, words = STUDIES[kind]
    more = ("--threads", "1", "--no-plots", "--output", str(folder))
    assert main(("study", kind, str(source), *words, *more)) == 0
    (told,) = map(json.loads, (folder / "verdicts.jsonl").read_text("utf-8").splitlines())
    assert told["verdict"] == sentence(folder)
    assert told["verdict"][:-1] in (folder / "index.html").read_text("utf-8")
    assert not list(folder.glob("*.png"))
