"""The wheel that the set-up built: what is in it and what it asks for."""

from __future__ import annotations

import tomllib
import zipfile
from email.message import Message
from email.parser import Parser

import pytest

from blenders import ROOT


@pytest.fixture(scope="module")
def wheel() -> zipfile.ZipFile:
    (path,) = (ROOT / "build" / "wheels").glob("regraft-*.whl")
    return zipfile.ZipFile(path)


@pytest.fixture(scope="module")
def metadata(wheel: zipfile.ZipFile) -> Message:
    (name,) = (n for n in wheel.namelist() if n.endswith(".dist-info/METADATA"))
    return Parser().parsestr(wheel.read(name).decode())


def test_the_version_is_the_project_files(metadata: Message) -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    assert metadata["Version"] == project["version"]


def test_it_holds_the_module_the_types_and_the_addon(wheel: zipfile.ZipFile) -> None:
    names = wheel.namelist()
    assert sum(n.startswith("regraft/_regraft.") and n.endswith(".so") for n in names) == 1
    assert {"regraft/py.typed", "regraft/cli/__init__.py"} <= set(names)
    assert {"regraft_blender/__init__.py", "regraft_blender/blender_manifest.toml"} <= set(names)


def test_it_holds_every_python_file_of_both_packages_and_nothing_else(
    wheel: zipfile.ZipFile,
) -> None:
    packages = [ROOT / "native/python/regraft", ROOT / "addon/regraft_blender"]
    expected = {
        path.relative_to(package.parent).as_posix()
        for package in packages
        for path in package.rglob("*.py")
    }
    assert {name for name in wheel.namelist() if name.endswith(".py")} == expected


def test_it_carries_the_licence(wheel: zipfile.ZipFile, metadata: Message) -> None:
    (name,) = (n for n in wheel.namelist() if n.endswith("licenses/LICENSE"))
    assert wheel.read(name) == (ROOT / "LICENSE").read_bytes()
    assert metadata["License-Expression"] == "GPL-3.0-or-later"


def test_bpy_comes_only_with_the_blender_extra(metadata: Message) -> None:
    needed = metadata.get_all("Requires-Dist", [])
    assert [n for n in needed if n.startswith("bpy")] == ['bpy<5.1,>=4.2; extra == "blender"']
    assert any(n.startswith("numpy") and "extra" not in n for n in needed)
