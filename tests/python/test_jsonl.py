"""JSON Lines: whole lines, strict JSON, torn tails cut."""

from __future__ import annotations

import json
import math
import resource
import subprocess
import sys
from pathlib import Path

import numpy as np

from regraft.formats import jsonl


def test_appended_rows_are_read_back(tmp_path: Path) -> None:
    path = tmp_path / "s.jsonl"
    rows: list[dict[str, object]] = [{"frame": 1, "words": ["ä", "b"]}, {"frame": 2, "ms": 0.25}]
    for row in rows:
        jsonl.append(path, row)
    assert jsonl.read(path) == rows


def test_numpy_and_infinite_numbers_become_strict_json() -> None:
    row = {"a": np.float32(0.5), "b": np.uint32(7), "c": math.inf, "d": (math.nan, 1)}
    assert json.loads(jsonl.encode(row)) == {"a": 0.5, "b": 7, "c": None, "d": [None, 1]}


def test_a_torn_last_line_is_left_out_and_cut_off(tmp_path: Path) -> None:
    path = tmp_path / "s.jsonl"
    path.write_bytes(b'{"frame": 1}\n{"fra')
    assert jsonl.read(path) == [{"frame": 1}]
    jsonl.append(path, {"frame": 2})
    assert path.read_bytes() == b'{"frame": 1}\n{"frame": 2}\n'


def test_lines_that_are_no_objects_are_left_out(tmp_path: Path) -> None:
    path = tmp_path / "s.jsonl"
    path.write_bytes(b'[1]\n\xff\n{"frame": 1}\n\n')
    assert jsonl.read(path) == [{"frame": 1}]


def test_no_file_has_no_rows(tmp_path: Path) -> None:
    assert jsonl.read(tmp_path / "none.jsonl") == []


APPEND = """
import sys
from pathlib import Path
from regraft.formats import jsonl
try:
    jsonl.append(Path(sys.argv[1]), {"frame": 2, "words": "x" * 5000})
except OSError:
    print("refused")
"""


def test_a_row_that_does_not_fit_leaves_the_file_as_it_was(tmp_path: Path) -> None:
    path = tmp_path / "s.jsonl"
    jsonl.append(path, {"frame": 1})
    before = path.read_bytes()

    def allow_a_kilobyte_a_file() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))

    done = subprocess.run(
        [sys.executable, "-c", APPEND, str(path)],
        preexec_fn=allow_a_kilobyte_a_file,
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout == "refused\n"
    assert path.read_bytes() == before
