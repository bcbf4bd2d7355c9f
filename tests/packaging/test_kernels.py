"""The kernels for stronger instruction sets keep their code to themselves.

The linker keeps one copy of an inline function that several files share. Were that the copy from a
file compiled for AVX2, a machine without AVX2 would die in code that never asked for it. So such a
file may define no shared function outside the namespace named for its instruction set.
"""

from __future__ import annotations

import subprocess

import pytest

from blenders import ROOT

OBJECTS = ROOT / "build/wheel/native/CMakeFiles/regraft_core.dir/regraft/trace"


def shared_functions(listing: str) -> list[str]:
    """Names of weak and unique symbols in the output of `nm -C`."""
    rows = (row.split(maxsplit=2) for row in listing.splitlines())
    return [row[2] for row in rows if len(row) == 3 and row[1] in "WVu"]


def test_the_reading_of_symbols_tells_shared_from_own() -> None:
    listing = "0000000000000000 T own()\n0000000000000010 W std::f(int)\n                 U gone\n"
    assert shared_functions(listing) == ["std::f(int)"]


@pytest.mark.parametrize("isa", ["sse", "avx2", "avx512"])
def test_a_kernel_file_shares_no_function_with_others(isa: str) -> None:
    command = ["nm", "-C", "--defined-only", str(OBJECTS / f"kernels_{isa}.cpp.o")]
    listing = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    assert [f for f in shared_functions(listing) if f"::{isa}::" not in f] == []
