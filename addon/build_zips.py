"""Build both add-on packages from the add-on's sources and a wheel of regraft.

The extension (Blender 4.2 to 5.x) carries the wheel as it is; Blender unpacks it. The legacy
package (Blender 3.4) carries the wheel's `regraft` folder as `regraft_blender/lib/regraft`. The
version in both comes from the wheel's name, hence from pyproject.toml. Equal inputs give equal
bytes.
"""

from __future__ import annotations

import argparse
import re
import sys
import zipfile
from pathlib import Path

ADDON = Path(__file__).resolve().parent / "regraft_blender"
LICENSE = ADDON.parent.parent / "LICENSE"
MANIFEST = "blender_manifest.toml"
TIMESTAMP = (1980, 1, 1, 0, 0, 0)
Files = dict[str, bytes]


class PackageError(Exception):
    """An input is not what a package can be made from."""


def wheel_version(wheel: Path) -> str:
    """Version in a wheel's file name, `name-version-python-abi-platform.whl`."""
    match = re.fullmatch(r"regraft-(\d+\.\d+\.\d+)-[^-]+-[^-]+-[^-]+\.whl", wheel.name)
    if match is None:
        raise PackageError(f"{wheel.name} is not the name of a regraft wheel")
    return match[1]


def substitute_once(pattern: str, replacement: str, text: str, where: str) -> str:
    """Replace the single place where `pattern` matches; none or several is an error."""
    text, count = re.subn(pattern, lambda _: replacement, text, flags=re.MULTILINE)
    if count != 1:
        raise PackageError(f"{where}: expected one place like {pattern}, found {count}")
    return text


def addon_files(version: str) -> Files:
    """The add-on's sources by their path in its folder, with `bl_info` carrying `version`."""
    paths = (path.relative_to(ADDON) for path in ADDON.rglob("*") if path.is_file())
    files = {
        path.as_posix(): (ADDON / path).read_bytes()
        for path in paths
        if not any(part.startswith((".", "__pycache__")) for part in path.parts)
    }
    numbers = ", ".join(version.split("."))
    init = files["__init__.py"].decode()
    stamped = substitute_once(
        r'"version": \(\d+, \d+, \d+\)', f'"version": ({numbers})', init, "__init__.py"
    )
    return files | {"__init__.py": stamped.encode(), "LICENSE": LICENSE.read_bytes()}


def extension_files(wheel: Path, version: str) -> Files:
    """Contents of the extension: sources, manifest naming the wheel, and the wheel unmodified."""
    files = addon_files(version)
    manifest = files[MANIFEST].decode()
    manifest = substitute_once(r'^version = ".*"$', f'version = "{version}"', manifest, MANIFEST)
    bundled = f"wheels/{wheel.name}"
    manifest = substitute_once(
        r"^wheels = \[.*\]$", f'wheels = ["./{bundled}"]', manifest, MANIFEST
    )
    return files | {MANIFEST: manifest.encode(), bundled: wheel.read_bytes()}


def legacy_files(wheel: Path, version: str) -> Files:
    """Contents of the legacy package: sources and the unpacked library under one folder."""
    files = addon_files(version)
    del files[MANIFEST]
    with zipfile.ZipFile(wheel) as archive:
        library = {
            f"lib/{name}": archive.read(name)
            for name in archive.namelist()
            if name.startswith("regraft/")
        }
    return {f"regraft_blender/{name}": data for name, data in (files | library).items()}


def write_zip(path: Path, files: Files) -> None:
    """Write `files` in sorted order with a fixed time, so that the bytes depend on nothing else."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name in sorted(files):
            entry = zipfile.ZipInfo(name, TIMESTAMP)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = 0o644 << 16
            archive.writestr(entry, files[name])


def build(wheel: Path, output: Path) -> tuple[Path, Path]:
    """Write both packages into `output`; gives the paths (extension, legacy)."""
    version = wheel_version(wheel)
    output.mkdir(parents=True, exist_ok=True)
    extension = output / f"regraft_blender-{version}.zip"
    legacy = output / f"regraft_blender-{version}-legacy.zip"
    write_zip(extension, extension_files(wheel, version))
    write_zip(legacy, legacy_files(wheel, version))
    return extension, legacy


def main() -> int:
    """Command line: a wheel in, two packages out, their paths printed."""
    parser = argparse.ArgumentParser(description="Build the add-on packages.")
    parser.add_argument("--wheel", type=Path, required=True, help="a built wheel of regraft")
    parser.add_argument("--output", type=Path, default=Path("dist"), help="folder to write into")
    arguments = parser.parse_args()
    try:
        for path in build(arguments.wheel, arguments.output):
            print(path)
    except (PackageError, OSError) as error:
        print(f"build_zips: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
