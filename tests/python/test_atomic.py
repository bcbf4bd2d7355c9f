"""Files appear whole or not at all, whatever happens to their writer."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from regraft.formats import atomic


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def test_a_finished_file_takes_the_place_of_the_old_one(tmp_path: Path) -> None:
    target = tmp_path / "a.txt"
    target.write_text("old")
    with atomic.replacing(target) as temporary:
        temporary.write_text("new")
        assert target.read_text() == "old"
    assert target.read_text() == "new"
    assert names(tmp_path) == ["a.txt"]


def test_a_failed_writer_leaves_the_old_file_and_nothing_else(tmp_path: Path) -> None:
    target = tmp_path / "a.txt"
    target.write_text("old")

    def write_half() -> None:
        with atomic.replacing(target) as temporary:
            temporary.write_text("half")
            raise RuntimeError("half way")

    with pytest.raises(RuntimeError, match="half way"):
        write_half()
    assert target.read_text() == "old"
    assert names(tmp_path) == ["a.txt"]


def test_a_temporary_name_is_hidden_and_keeps_the_ending(tmp_path: Path) -> None:
    temporary = atomic.temporary_path(tmp_path / "shot_0001.png")
    assert temporary.name.startswith(".")
    assert temporary.suffix == ".png"
    assert temporary.parent == tmp_path


def dead_process() -> int:
    child = subprocess.Popen([sys.executable, "-c", ""])
    child.wait()
    return child.pid


def test_preparing_a_folder_clears_only_what_dead_runs_left(tmp_path: Path) -> None:
    own = atomic.temporary_path(tmp_path / "frame.png")
    stray = own.with_name(own.name.replace(str(own.name.split("-")[-1]), f"{dead_process()}.png"))
    foreign = tmp_path / f".frame.regraft-another_machine-{dead_process()}.png"
    other = tmp_path / ".frame.png"
    for path in (own, stray, foreign, other):
        path.write_bytes(b"x")
    atomic.prepare_folder(tmp_path)
    assert names(tmp_path) == sorted([own.name, foreign.name, other.name])


def test_a_folder_is_made_with_its_parents(tmp_path: Path) -> None:
    atomic.prepare_folder(tmp_path / "a" / "b")
    assert names(tmp_path / "a") == ["b"]
    assert names(tmp_path / "a" / "b") == []


def test_a_folder_that_cannot_be_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(OSError, match="file"):
        atomic.prepare_folder(tmp_path / "file" / "below")
