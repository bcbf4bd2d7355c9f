"""What --resume leaves alone, and what it does again."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from regraft.cli.job import RenderJob, SceneInfo, fingerprint
from regraft.cli.ledger import LEDGER, Ledger


def finish(folder: Path, frames: range, mark: str = "a") -> dict[int, Path]:
    targets = {f: folder / f"f_{f}.png" for f in frames}
    for frame, target in targets.items():
        target.write_text(f"picture {frame}")
        Ledger(folder, mark).record(target)
    return targets


def test_finished_frames_stay_and_missing_ones_are_rendered(tmp_path: Path) -> None:
    targets = finish(tmp_path, range(1, 4)) | {9: tmp_path / "f_9.png"}
    plan = Ledger(tmp_path, "a").plan(targets)
    assert (plan.done, plan.todo) == ([1, 2, 3], [9])
    assert plan.describe() == "resume: 3 finished frames stay, 1 to render"


def test_a_changed_file_is_rendered_again(tmp_path: Path) -> None:
    targets = finish(tmp_path, range(1, 3))
    targets[2].write_text("pict")
    plan = Ledger(tmp_path, "a").plan(targets)
    assert (plan.done, plan.damaged) == ([1], [2])


def test_frames_of_other_settings_are_rendered_again(tmp_path: Path) -> None:
    targets = finish(tmp_path, range(1, 3), "a")
    finish(tmp_path, range(2, 3), "b")
    plan = Ledger(tmp_path, "a").plan(targets)
    assert (plan.done, plan.other_settings) == ([1], [2])
    assert "other settings" in plan.describe()


def test_a_file_that_nobody_recorded_is_rendered_again(tmp_path: Path) -> None:
    (tmp_path / "f_1.png").write_text("from elsewhere")
    assert Ledger(tmp_path, "a").plan({1: tmp_path / "f_1.png"}).todo == [1]


def test_a_torn_ledger_costs_only_its_last_frame(tmp_path: Path) -> None:
    targets = finish(tmp_path, range(1, 4))
    ledger = tmp_path / LEDGER
    ledger.write_bytes(ledger.read_bytes()[:-10])
    assert Ledger(tmp_path, "a").plan(targets).todo == [3]


@pytest.fixture
def job(tmp_path: Path) -> RenderJob:
    source = tmp_path / "shot.blend"
    source.write_text("scene")
    return RenderJob(str(source))


INFO = SceneInfo("4.5", (1, 2), 64, 48, 24.0)


def test_the_same_settings_have_the_same_fingerprint(job: RenderJob) -> None:
    again = RenderJob.from_json(job.as_json())
    assert fingerprint(job, INFO, "1") == fingerprint(again, INFO, "1")
    assert fingerprint(job, INFO, "1") == fingerprint(replace(job, threads=2), INFO, "1")


@pytest.mark.parametrize(
    "change",
    [
        {"shading": "clay"},
        {"samples": 2},
        {"format": "exr"},
        {"passes": ("combined", "depth")},
        {"policy": "rebuild"},
        {"layout": "flat"},
    ],
)
def test_another_setting_has_another_fingerprint(job: RenderJob, change: dict[str, str]) -> None:
    assert fingerprint(job, INFO, "1") != fingerprint(replace(job, **change), INFO, "1")  # type: ignore[arg-type]


def test_size_versions_and_the_file_itself_count(job: RenderJob) -> None:
    before = fingerprint(job, INFO, "1")
    assert before != fingerprint(job, replace(INFO, width=65), "1")
    assert before != fingerprint(job, replace(INFO, blender="5.0"), "1")
    assert before != fingerprint(job, INFO, "2")
    Path(job.source).write_text("another scene")
    assert before != fingerprint(job, INFO, "1")


def test_a_linked_library_counts(job: RenderJob, tmp_path: Path) -> None:
    library = tmp_path / "library.blend"
    library.write_text("chair")
    info = replace(INFO, libraries=(str(library),))
    before = fingerprint(job, info, "1")
    library.write_text("table")
    assert before != fingerprint(job, info, "1")


def test_an_info_survives_its_journey() -> None:
    info = replace(INFO, notes=("a note",), libraries=("x",))
    assert SceneInfo.from_json(info.as_json()) == info
