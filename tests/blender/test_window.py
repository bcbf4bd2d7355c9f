"""The add-on in a Blender with a window, where there is one and a display to be had."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

from blenders import RUNNER, Blender, available

INSIDE = Path(__file__).parent / "inside"
# bpy has no windows; the display is a virtual one.
WINDOWED = [v for v in available() if v == "3.4" and shutil.which("xvfb-run")]
SCREEN = "-screen 0 1280x800x24"


def run_in_window(blender: Blender, script: Path, folder: Path) -> str:
    """Run a script that ends Blender by itself; all it wrote."""
    options = ["--factory-startup", "--enable-event-simulate"]
    options += ["--window-geometry", "0", "0", "1280", "800"]
    inside = ["--python", str(RUNNER), "--", "--addon", str(script), str(folder)]
    done = subprocess.run(
        ["xvfb-run", "-a", "-s", SCREEN, str(blender.executable), *options, *inside],
        env=blender.environment(),
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=900,
    )
    assert done.returncode == 0, done.stdout
    return done.stdout


if WINDOWED:

    @pytest.mark.parametrize("blender", WINDOWED, indirect=True)
    def test_boxes_of_nodes(addon_blender: Blender, tmp_path: Path) -> None:
        output = run_in_window(addon_blender, INSIDE / "window_nodes.py", tmp_path)
        assert " checks passed" in output
        assert "Traceback" not in output

    @pytest.mark.parametrize("blender", WINDOWED, indirect=True)
    def test_study_in_the_sidebar(addon_blender: Blender, tmp_path: Path) -> None:
        output = run_in_window(addon_blender, INSIDE / "window_study.py", tmp_path)
        assert " checks passed" in output
        assert "Traceback" not in output
        assert (tmp_path / "study.png").stat().st_size > 10_000

    @pytest.mark.parametrize("blender", WINDOWED, indirect=True)
    def test_viewport_and_buttons(addon_blender: Blender, tmp_path: Path) -> None:
        output = run_in_window(addon_blender, INSIDE / "window_viewport.py", tmp_path)
        assert " checks passed" in output
        # The one error that the script causes on purpose is logged where it was caught; no other.
        tracebacks = output.split("Traceback")[1:]
        assert all("ValueError: pretended" in text for text in tracebacks), output
        assert tracebacks, output
