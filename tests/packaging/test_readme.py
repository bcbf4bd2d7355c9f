"""What the README tells people to type works."""

from __future__ import annotations

import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from blenders import ROOT

README = (ROOT / "README.md").read_text()


def blocks(language: str) -> list[str]:
    """Contents of the README's code blocks in one language."""
    return re.findall(rf"^```{language}\n(.*?)^```$", README, re.MULTILINE | re.DOTALL)


def commands(program: str) -> list[list[str]]:
    """The README's shell commands that start with `program`, as words without comments."""
    rows = "".join(blocks("sh")).splitlines()
    lines = (shlex.split(row, comments=True) for row in rows)
    return [words for words in lines if words[:1] == [program]]


def test_the_regraft_commands_succeed_in_their_order(tmp_path: Path) -> None:
    (tmp_path / "blend_files").symlink_to(ROOT / "blend_files")
    assert len(commands("regraft")) >= 3
    for words in commands("regraft"):
        program = [sys.executable, "-m", "regraft", *words[1:]]
        done = subprocess.run(program, cwd=tmp_path, capture_output=True, text=True)
        assert done.returncode == 0, f"{words}\n{done.stdout}{done.stderr}"
    assert len(list((tmp_path / "frames").glob("*.png"))) == 6
    assert (tmp_path / "robots.mp4").stat().st_size > 0


@pytest.mark.parametrize("target", [words[1] for words in commands("make")])
def test_the_make_targets_exist(target: str) -> None:
    assert re.search(rf"^{target}:.*## ", (ROOT / "Makefile").read_text(), re.MULTILINE)


def test_the_python_example_runs() -> None:
    (example,) = blocks("python")
    done = subprocess.run([sys.executable, "-c", example], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("link", re.findall(r"\]\(([^)#:]+)\)", README))
def test_the_links_lead_somewhere(link: str) -> None:
    assert (ROOT / link).exists()
