"""The add-on packages: what is in them, where their version comes from, what is refused."""

from __future__ import annotations

import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import pytest

import build_zips
from blenders import ROOT

WHEEL_NAME = "regraft-7.8.9-cp311-cp311-linux_x86_64.whl"


@pytest.fixture
def wheel(tmp_path: Path) -> Path:
    path = tmp_path / WHEEL_NAME
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("regraft/__init__.py", "")
        archive.writestr("regraft/cli/__init__.py", "")
        archive.writestr("regraft_blender/__init__.py", "")
        archive.writestr("regraft-7.8.9.dist-info/METADATA", "")
    return path


@pytest.fixture
def packages(wheel: Path, tmp_path: Path) -> tuple[zipfile.ZipFile, zipfile.ZipFile]:
    extension, legacy = build_zips.build(wheel, tmp_path / "dist")
    return zipfile.ZipFile(extension), zipfile.ZipFile(legacy)


def test_the_extension_carries_the_wheel_unmodified_and_names_it(
    wheel: Path, packages: tuple[zipfile.ZipFile, zipfile.ZipFile]
) -> None:
    extension, _ = packages
    manifest = tomllib.loads(extension.read("blender_manifest.toml").decode())
    assert manifest["wheels"] == [f"./wheels/{WHEEL_NAME}"]
    assert extension.read(f"wheels/{WHEEL_NAME}") == wheel.read_bytes()


def test_the_legacy_package_carries_the_library_alone(
    packages: tuple[zipfile.ZipFile, zipfile.ZipFile],
) -> None:
    names = packages[1].namelist()
    library = {name for name in names if name.startswith("regraft_blender/lib/")}
    assert library == {
        "regraft_blender/lib/regraft/__init__.py",
        "regraft_blender/lib/regraft/cli/__init__.py",
    }
    assert all(name.startswith("regraft_blender/") for name in names)
    assert "regraft_blender/blender_manifest.toml" not in names


def test_the_version_is_the_wheels(packages: tuple[zipfile.ZipFile, zipfile.ZipFile]) -> None:
    extension, legacy = packages
    manifest = tomllib.loads(extension.read("blender_manifest.toml").decode())
    assert manifest["version"] == "7.8.9"
    assert b'"version": (7, 8, 9)' in extension.read("__init__.py")
    assert b'"version": (7, 8, 9)' in legacy.read("regraft_blender/__init__.py")


def test_both_packages_hold_the_licence_and_no_caches(
    packages: tuple[zipfile.ZipFile, zipfile.ZipFile],
) -> None:
    extension, legacy = packages
    text = (ROOT / "LICENSE").read_bytes()
    assert extension.read("LICENSE") == text
    assert legacy.read("regraft_blender/LICENSE") == text
    names = extension.namelist() + legacy.namelist()
    assert not [n for n in names if "__pycache__" in n or n.endswith((".pyc", ".orig"))]


def test_equal_inputs_give_equal_bytes(wheel: Path, tmp_path: Path) -> None:
    first = build_zips.build(wheel, tmp_path / "first")
    second = build_zips.build(wheel, tmp_path / "second")
    assert [p.read_bytes() for p in first] == [p.read_bytes() for p in second]


@pytest.mark.parametrize("name", ["other-1.2.3-cp311-cp311-linux_x86_64.whl", "regraft-1.2.3.zip"])
def test_another_file_than_our_wheel_is_refused_by_name(name: str, tmp_path: Path) -> None:
    with pytest.raises(build_zips.PackageError, match=name):
        build_zips.build(tmp_path / name, tmp_path)


def test_a_manifest_without_a_version_line_is_refused() -> None:
    with pytest.raises(build_zips.PackageError, match="manifest: expected one place"):
        build_zips.substitute_once('^version = ".*"$', "", 'id = "x"\n', "manifest")


def test_the_command_says_what_is_wrong_and_exits_with_1(tmp_path: Path) -> None:
    script, missing = ROOT / "addon" / "build_zips.py", tmp_path / WHEEL_NAME
    command = [sys.executable, script, "--wheel", missing, "--output", tmp_path / "dist"]
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True)
    assert done.returncode == 1
    assert WHEEL_NAME in done.stderr
    assert not list((tmp_path / "dist").glob("*.zip"))
