"""Writes native/python/regraft/_regraft.pyi from the signatures and docstrings of the module.

`python tests/make_stub.py` after a change of the bindings; test_stub.py compares.
"""

from __future__ import annotations

import inspect
import re
import subprocess
import textwrap
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

STUB = Path(__file__).resolve().parent.parent / "native/python/regraft/_regraft.pyi"

HEADER = '''"""{doc}"""

# Written by tests/make_stub.py.

from collections.abc import Callable, Sequence
from typing import Any, SupportsIndex

import numpy as np
import numpy.typing as npt

from regraft.camera import Camera
from regraft.light import Light

__version__: str
'''

SHORT_NAMES = {
    "numpy.typing.": "npt.",
    "numpy.": "np.",
    "collections.abc.": "",
    "typing.": "",
    "regraft.camera.": "",
    "regraft.light.": "",
    "regraft._regraft.": "",
    "= inf": '= float("inf")',
}


def signature(text: str) -> str:
    """A signature as pybind11 writes it, in the stub's short names, without the type of self."""
    text = re.sub(r"\((self|arg0): [\w.]+", "(self", text)
    for long, short in SHORT_NAMES.items():
        text = re.sub(rf"(?<![\w.]){re.escape(long)}", short, text)
    return text


def docstring(text: str, indent: str) -> str:
    """A docstring's lines; a long single line is wrapped."""
    text = text.strip()
    if "\n" not in text:
        text = textwrap.fill(text, 88)
    end = "\n" if "\n" in text else ""
    return textwrap.indent(f'"""{text}{end}"""', indent)


def function(doc: str, indent: str) -> Iterator[str]:
    """Lines of a function whose docstring begins with its signature."""
    head, _, body = doc.partition("\n")
    yield f"{indent}def {signature(head)}:" + ("" if body.strip() else " ...")
    if body.strip():
        yield docstring(body, indent + "    ")


def attribute(name: str, value: property) -> Iterator[str]:
    """Lines of a property: as an attribute where it can be set, else with its docstring."""
    kind = signature(str(value.fget.__doc__).partition("-> ")[2].strip())
    if value.fset is None:
        yield f"    @property\n    def {name}(self) -> {kind}:"
        yield docstring(str(value.__doc__), "        ")
    else:
        yield f"    {name}: {kind}"


def class_lines(cls: type) -> Iterator[str]:
    """Lines of a class: what it adds to `object`."""
    yield f"class {cls.__name__}:"
    yield docstring(str(cls.__doc__), "    ")
    for name, value in vars(cls).items():
        if isinstance(value, property):
            yield from attribute(name, value)
        elif inspect.isroutine(value) and str(value.__doc__).startswith(f"{name}("):
            yield from function(str(value.__doc__), "    ")


def stub_text(module: ModuleType) -> str:
    """The stub, not formatted."""
    lines = [HEADER.format(doc=module.__doc__)]
    for _, value in sorted(vars(module).items()):
        if inspect.isclass(value):
            lines += class_lines(value)
        elif inspect.isroutine(value):
            lines += function(str(value.__doc__), "")
    return "\n".join(lines) + "\n"


def main() -> None:
    from regraft import _regraft

    STUB.write_text(stub_text(_regraft), encoding="utf-8")
    subprocess.run(["ruff", "format", "--quiet", str(STUB)], check=True)


if __name__ == "__main__":
    main()
