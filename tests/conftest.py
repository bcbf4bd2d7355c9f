"""Fixtures that every test may use.

`blend_files`, `scenes`, `blender` (each supported Blender in turn), `addon_blender` (the same with
the add-on installed from its package and enabled). A test that asks for `scenes` is collected only
where REGRAFT_SCENES names a folder. REGRAFT_ALL_BLENDERS=1 makes a missing Blender an error.
"""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

import pytest

from blenders import ROOT, VERSIONS, Blender, available, package_for

BLENDERS = available()


def pytest_configure() -> None:
    # The same everywhere, whatever was measured on this machine.
    os.environ["REGRAFT_COSTS"] = "default"
    missing = [version for version in VERSIONS if version not in BLENDERS]
    if missing and os.environ.get("REGRAFT_ALL_BLENDERS") == "1":
        raise pytest.UsageError(f"no Blender {', '.join(missing)}: run .ci/setup test")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    if "REGRAFT_SCENES" not in os.environ:
        items[:] = [i for i in items if "scenes" not in getattr(i, "fixturenames", ())]


@pytest.fixture(scope="session")
def blend_files() -> Path:
    """Folder of the project's own scenes."""
    return ROOT / "blend_files"


@pytest.fixture(scope="session")
def scenes() -> Path:
    """Folder of further scenes, which are not part of the project."""
    return Path(os.environ["REGRAFT_SCENES"])


@pytest.fixture(scope="session", params=BLENDERS, ids=lambda version: f"blender{version}")
def blender(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Blender:
    """Each supported Blender in turn, with an empty profile and without the add-on."""
    version: str = request.param
    return Blender(version, BLENDERS[version], tmp_path_factory.mktemp(f"profile-{version}"))


@pytest.fixture(scope="session")
def addon_blender(blender: Blender, tmp_path_factory: pytest.TempPathFactory) -> Blender:
    """Each supported Blender in turn, the add-on installed from its package and enabled."""
    profile = tmp_path_factory.mktemp(f"addon-profile-{blender.version}")
    installed = replace(blender, profile=profile, addon=True)
    bare = replace(installed, addon=False)
    bare.run(Path("--install"), package_for(blender.version))
    return installed
