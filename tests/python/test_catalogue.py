"""docs/catalogue.md: no case of the catalogue is missing, and every test that it names exists."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "catalogue.md").read_text("utf-8")
ROWS = re.findall(r"^\| (\d+) \| (.+?) \| (.+?) \|$", PAGE, re.MULTILINE)
NATIVE = re.compile(r"\b(?:TEST|TEST_F|TEST_P|RC_GTEST_PROP)\(\s*(\w+),\s*(\w+)")
PYTHON = re.compile(r"^ *def ((?:test|check)_\w+)", re.MULTILINE)


def native_tests() -> set[str]:
    sources = (ROOT / "tests" / "native").rglob("*.cpp")
    return {".".join(name) for path in sources for name in NATIVE.findall(path.read_text("utf-8"))}


def python_tests() -> set[str]:
    sources = [*ROOT.glob("tests/*/test_*.py"), *ROOT.glob("tests/blender/inside/check_*.py")]
    return {
        f"{path.name}::{name}"
        for path in sources
        for name in PYTHON.findall(path.read_text("utf-8"))
    }


def test_every_case_has_its_row() -> None:
    assert [int(number) for number, _, _ in ROWS] == list(range(1, 101))


def test_every_test_that_is_named_exists() -> None:
    existing = native_tests() | python_tests()
    assert len(existing) > 500
    for number, case, tests in ROWS:
        named = re.findall(r"`([^`]+)`", tests)
        assert named, f"case {number}, {case}"
        assert set(named) <= existing, f"case {number}, {case}: {set(named) - existing}"


def test_the_counts_are_those_of_the_tables() -> None:
    families = re.split(r"^## ", PAGE, flags=re.MULTILINE)[1:]
    for family in families:
        title = family.splitlines()[0]
        count = len(re.findall(r"^\| \d+ \|", family, re.MULTILINE))
        assert f"| {title} | {count} |" in PAGE
    assert "| all | 100 |" in PAGE
    assert len(families) == 9


@pytest.mark.parametrize(
    "source",
    [
        "TEST(Suite, Name) {",
        "TEST_F(Suite, Name) {",
        "TEST(Suite,\n     Name) {",
        "RC_GTEST_PROP(Suite, Name, ()) {",
    ],
)
def test_native_names_are_read_from_their_sources(source: str) -> None:
    assert NATIVE.findall(source) == [("Suite", "Name")]
