"""Runs the scripts of checks in inside/, each in a process of every Blender with our add-on."""

from __future__ import annotations

from pathlib import Path

import pytest

from blenders import Blender

CHECKS = sorted((Path(__file__).parent / "inside").glob("check_*.py"))


@pytest.mark.parametrize("script", CHECKS, ids=lambda path: path.stem.removeprefix("check_"))
def test_all_checks_pass(addon_blender: Blender, script: Path, tmp_path: Path) -> None:
    done = addon_blender.run(script, tmp_path)
    assert " checks passed" in done.stdout
