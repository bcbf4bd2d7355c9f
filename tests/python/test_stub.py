"""The stub says what the module says, and every public thing of the module says something."""

from __future__ import annotations

import ast
import inspect

import pytest

import regraft
from make_stub import STUB, stub_text
from regraft import _regraft

CLASSES = [value for _, value in inspect.getmembers(_regraft, inspect.isclass)]


def test_stub_is_what_make_stub_writes() -> None:
    kept = ast.parse(STUB.read_text(encoding="utf-8"))
    assert ast.dump(kept) == ast.dump(ast.parse(stub_text(_regraft))), (
        "run python tests/make_stub.py"
    )


def test_stub_names_every_class_and_function_of_the_module() -> None:
    defined = {getattr(node, "name", None) for node in ast.parse(STUB.read_text("utf-8")).body}
    public = {n for n in vars(_regraft) if not n.startswith("_")}
    assert public <= defined


def test_package_exports_the_public_classes_of_the_module() -> None:
    assert {cls.__name__ for cls in CLASSES} <= set(regraft.__all__)


def members(cls: type) -> dict[str, object]:
    """The public members of a class that the module defines."""
    return {name: value for name, value in vars(cls).items() if not name.startswith("_")}


@pytest.mark.parametrize("cls", CLASSES, ids=lambda cls: cls.__name__)
def test_every_public_member_has_a_docstring(cls: type) -> None:
    for name, value in members(cls).items():
        lines = str(value.__doc__ or "").strip().splitlines()
        # That of a method begins with its signature.
        said = lines[1:] if inspect.isroutine(value) else lines
        assert any(said), f"{cls.__name__}.{name} says nothing"
