"""Hits on animated scenes equal brute force bit for bit; see tests/check_hits.py."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

CHECK = Path(__file__).resolve().parent.parent / "check_hits.py"


def check(path: Path) -> None:
    command = [sys.executable, str(CHECK), str(path), "--rays", "4000", "--frames", "3"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert ": equal" in done.stdout


@pytest.mark.parametrize("name", ["cloth", "robots", "n_body", "mixed"])
def test_hits_equal_brute_force_after_motion(blend_files: Path, name: str) -> None:
    check(blend_files / f"{name}.blend")


@pytest.mark.parametrize(
    "name",
    [
        "bart_kitchen/bart_kitchen",
        "robot_expressive/RobotExpressive",
        "gn_trees/gn_nested_instances",
        "armory_sims/particle_bunny",
    ],
)
def test_hits_equal_brute_force_in_scenes_of_others(scenes: Path, name: str) -> None:
    check(scenes / f"{name}.blend")
