"""The Blenders that the tests run in, and how to run a Python script inside one."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
RUNNER = ROOT / "tests" / "run_in_blender.py"
VERSIONS = ("3.4", "4.2", "4.5", "5.0")
SCRIPT_FAILED = 3


@dataclass(frozen=True)
class Blender:
    """One Blender, with a private profile and, where `addon` is set, our add-on enabled in it.

    `executable` is Debian's `blender` for 3.4, and for the others a Python that has that `bpy`.
    """

    version: str
    executable: Path
    profile: Path
    addon: bool = False

    def command(self, script: Path, *arguments: object) -> list[str]:
        """Command line that runs `script` with `arguments` in `sys.argv[1:]`, headless."""
        if self.version == "3.4":
            options = ["-b", "--factory-startup", "--python-exit-code", str(SCRIPT_FAILED)]
            head = [*options, "--python", str(RUNNER), "--"]
        else:
            head = [str(RUNNER), "--"]
        words = ["--addon"] if self.addon else []
        return [str(self.executable), *head, *words, str(script), *map(str, arguments)]

    def environment(self) -> dict[str, str]:
        """The caller's environment with the profile in place of the user's, and no Python paths."""
        kept = {k: v for k, v in os.environ.items() if not k.startswith(("PYTHON", "XDG_CONFIG"))}
        return kept | {"HOME": str(self.profile), "BLENDER_USER_RESOURCES": str(self.profile)}

    def run(
        self, script: Path, *arguments: object, check: bool = True, timeout: float = 300
    ) -> subprocess.CompletedProcess[str]:
        """Run `script` to its end; `check` raises with the whole output when it failed."""
        done = subprocess.run(
            self.command(script, *arguments),
            env=self.environment(),
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            timeout=timeout,
        )
        if check and done.returncode != 0:
            raise AssertionError(f"Blender {self.version}: exit {done.returncode}\n{done.stdout}")
        return done


def executable_of(version: str) -> Path | None:
    """Where one Blender is: REGRAFT_BLENDER_4_2 and so on, else where the set-up puts it."""
    named = os.environ.get(f"REGRAFT_BLENDER_{version.replace('.', '_')}")
    if named:
        return Path(named)
    if version == "3.4":
        found = shutil.which("blender")
        return Path(found) if found else None
    folder = ".venv" if version == "4.5" else f".venv-{version}"
    path = ROOT / folder / "bin" / "python"
    return path if path.exists() else None


def available() -> dict[str, Path]:
    """Executables of the Blenders found here, by version."""
    found = {version: executable_of(version) for version in VERSIONS}
    return {version: path for version, path in found.items() if path is not None}


def package_for(version: str) -> Path:
    """The add-on package that this Blender installs, from REGRAFT_PACKAGES or dist/."""
    folder = Path(os.environ.get("REGRAFT_PACKAGES", ROOT / "dist"))
    legacy = version == "3.4"
    fitting = [p for p in folder.glob("regraft_blender-*.zip") if ("-legacy" in p.name) == legacy]
    if len(fitting) != 1:
        sys.exit(f"{folder}: expected one add-on package for {version}, found {len(fitting)}")
    return fitting[0]
