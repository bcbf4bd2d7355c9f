"""Image errors against what they are of pictures made by hand, and `study image` end to end."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from regraft.cli import main, recording
from regraft.study import image, image_error, image_report
from stand_in_recording import RecordingStandIn

GREY = np.full((16, 24, 3), 0.5, np.float32)
Row = dict[str, Any]


def test_errors_of_known_pictures() -> None:
    assert image_error.rmse(GREY + np.float32(0.1), GREY) == pytest.approx(0.1, rel=1e-5)
    assert image_error.relative_mse(GREY * 1.1, GREY) == pytest.approx(0.0025 / 0.26, rel=1e-4)
    assert image_error.flip(GREY, GREY) == pytest.approx(0.0, abs=1e-6)
    black, white = np.zeros_like(GREY), np.ones_like(GREY)
    assert image_error.flip(black, white) > 0.9
    slight = image_error.flip(GREY * np.float32(1.05), GREY)
    assert 0.0 < slight < image_error.flip(GREY * np.float32(1.5), GREY)


def test_what_a_screen_shows() -> None:
    linear = np.array([[[0.0, 0.0031308, 0.2140411], [1.0, 7.0, -1.0]]], np.float32)
    wanted = np.array([[[0.0, 0.04045, 0.5], [1.0, 1.0, 0.0]]])
    assert np.allclose(image_error.shown(linear), wanted, atol=1e-5)


def rows(mode: str, errors: list[float]) -> list[Row]:
    return [
        {
            "mode": mode,
            "samples": 1 << k,
            "seconds": 0.1 * (k + 1),
            "rmse": e,
            "relative_mse": e * e,
            "flip": e / 2,
        }
        for k, e in enumerate(errors)
    ]


def test_the_time_to_reach_an_error() -> None:
    (reached,) = image.times_to_reach(rows("direct", [0.2, 0.09, 0.05]))
    assert reached["rmse 0.1"] == pytest.approx(0.2)
    assert reached["rmse 0.03"] is None
    assert reached["flip 0.1"] == pytest.approx(0.1)


def test_bias_is_what_samples_do_not_mend() -> None:
    noisy = [(0.3**2 + 0.5**2 / n) ** 0.5 for n in (1, 2, 4, 8)]
    assert image.bias(rows("clay", noisy), "clay") == pytest.approx(0.3)
    pure = [0.5 / n**0.5 for n in (1, 2, 4, 8)]
    assert image.bias(rows("direct", pure), "direct") == pytest.approx(0.0, abs=1e-6)


def test_the_command(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    backend = RecordingStandIn(2)
    monkeypatch.setattr(recording, "choose_backend", lambda _verbose: backend)
    monkeypatch.setattr(image, "MODES", ("clay", "reflection"))
    monkeypatch.chdir(tmp_path)
    Path("hills.blend").touch()
    quick = ("--resolution", "24x16", "--samples", "2", "--reference", "8", "--threads", "1")
    assert main(("study", "image", "hills.blend", *quick)) == 0
    assert backend.job.shading == image.TRUE_MODE, "all that the fullest mode reads is recorded"
    with Path("study_image/image.csv").open(newline="") as file:
        found = list(csv.DictReader(file))
    assert [r["mode"] for r in found] == ["reference", *(m for m in image.MODES for _ in range(2))]
    measured: list[Row] = [
        {k: v if k in ("scene", "mode") else float(v or "nan") for k, v in row.items()}
        for row in found
    ]
    true = [r["rmse"] for r in measured if r["mode"] == image.TRUE_MODE]
    assert true[0] > true[-1] > 0.0, "more samples, less error"
    floor = measured[0]["rmse"]
    assert 0.0 < floor < true[-1]
    said = image_report.sentence([{**r, "samples": int(r["samples"])} for r in measured])
    assert said in capsys.readouterr().out
