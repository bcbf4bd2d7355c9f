"""The set-up script where something is missing: what it says and how it ends.

It runs in a sandbox with stand-ins for the system's commands, so nothing is installed.
"""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

import pytest

from blenders import ROOT


class Sandbox:
    """A checkout with only the set-up script, and a PATH where stand-ins come first."""

    def __init__(self, folder: Path) -> None:
        self.checkout = folder / "checkout"
        self.commands = folder / "bin"
        self.commands.mkdir()
        shutil.copytree(ROOT / ".ci", self.checkout / ".ci")

    def command(self, name: str, body: str) -> None:
        """Put a stand-in for one of the system's commands on the PATH."""
        path = self.commands / name
        path.write_text(f"#!/bin/sh\n{body}\n")
        path.chmod(0o755)

    def setup(self, *arguments: str, **environment: str) -> subprocess.CompletedProcess[str]:
        """Run the script to its end."""
        env = {**os.environ, **environment, "PATH": f"{self.commands}:{os.environ['PATH']}"}
        command = [str(self.checkout / ".ci" / "setup"), *arguments]
        return subprocess.run(command, env=env, capture_output=True, text=True, timeout=60)


@pytest.fixture
def sandbox(tmp_path: Path) -> Sandbox:
    made = Sandbox(tmp_path)
    made.command("dpkg-query", 'for last; do :; done; [ "$last" = ninja-build ] || echo installed')
    made.command("apt-get", 'echo "apt-get $*" >> "$APT_CALLS"; exit "${APT_EXIT:-0}"')
    return made


def test_without_root_the_missing_packages_are_named(sandbox: Sandbox, tmp_path: Path) -> None:
    sandbox.command("id", "echo 1000")
    done = sandbox.setup("preview", APT_CALLS=str(tmp_path / "calls"))
    assert done.returncode == 1
    assert "apt-get install --no-install-recommends ninja-build\n" in done.stderr
    assert not (tmp_path / "calls").exists()


def test_root_installs_just_what_is_missing(sandbox: Sandbox, tmp_path: Path) -> None:
    sandbox.command("id", "echo 0")
    done = sandbox.setup("preview", APT_CALLS=str(tmp_path / "calls"), PYTHON="no-such-python")
    calls = (tmp_path / "calls").read_text().splitlines()
    assert calls == ["apt-get update", "apt-get install -y --no-install-recommends ninja-build"]
    assert "installing 1 Debian packages: ninja-build" in done.stdout


def test_a_failing_step_is_named_and_ends_the_setup(sandbox: Sandbox, tmp_path: Path) -> None:
    sandbox.command("id", "echo 0")
    done = sandbox.setup("preview", APT_CALLS=str(tmp_path / "calls"), APT_EXIT="100")
    assert done.returncode == 1
    assert "failed: apt-get update" in done.stderr


def test_another_python_than_3_11_is_refused(sandbox: Sandbox) -> None:
    sandbox.command("dpkg-query", "echo installed")
    sandbox.command("python3.10", "exit 1")
    done = sandbox.setup("preview", PYTHON="python3.10")
    assert done.returncode == 1
    assert "Python 3.11 not found" in done.stderr


def test_an_unknown_goal_is_refused(sandbox: Sandbox) -> None:
    done = sandbox.setup("everything")
    assert done.returncode == 1
    assert "unknown goal: everything" in done.stderr
