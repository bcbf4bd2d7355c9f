"""The packages that `make addon` built: accepted by Blender's own checker, installed, enabled."""

from __future__ import annotations

from pathlib import Path

import pytest

from blenders import Blender, available, package_for

WITH_EXTENSIONS = [version for version in available() if version != "3.4"]

VALIDATE = """
import subprocess, sys
from pathlib import Path
import bpy
tools = Path(bpy.utils.resource_path("LOCAL")) / "scripts/addons_core/bl_pkg/cli/blender_ext.py"
sys.exit(subprocess.run([sys.executable, tools, "validate", sys.argv[1]]).returncode)
"""

IMPORT = """
import sys
from importlib.metadata import distributions
from pathlib import Path
import bpy
import regraft
print("VERSION", regraft.__version__)
print("LIBRARY", Path(regraft.__file__).parent)
print("HEAVY", sorted({"PIL", "tqdm", "OpenEXR", "imageio_ffmpeg"} & set(sys.modules)))
"""


def line(output: str, key: str) -> str:
    (found,) = (row for row in output.splitlines() if row.startswith(f"{key} "))
    return found.removeprefix(f"{key} ")


@pytest.mark.parametrize("version", WITH_EXTENSIONS)
def test_blenders_own_checker_accepts_the_extension(version: str, tmp_path: Path) -> None:
    blender = Blender(version, available()[version], tmp_path)
    script = tmp_path / "validate.py"
    script.write_text(VALIDATE)
    assert "Success" in blender.run(script, package_for(version)).stdout


def test_the_packaged_library_is_what_the_addon_imports(
    addon_blender: Blender, tmp_path: Path
) -> None:
    script = tmp_path / "import.py"
    script.write_text(IMPORT)
    output = addon_blender.run(script).stdout
    assert Path(line(output, "LIBRARY")).is_relative_to(addon_blender.profile)
    assert line(output, "HEAVY") == "[]"
    assert f"-{line(output, 'VERSION')}" in package_for(addon_blender.version).name
