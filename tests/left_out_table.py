"""Writes docs/left-out.md: what a frame of each scene does not need, in the engine's own words.

    .venv/bin/python tests/left_out_table.py blend_files/*.blend … > docs/left-out.md

Each file is rendered by `regraft render FILE --statistics` on its first frames, at a small size; a
sentence is listed with the number of frames that said it.
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path
from typing import Any

FRAMES, SIZE = 4, "320x180"
Row = dict[str, Any]
HEAD = f"""# What is left out

What the first {FRAMES} frames of each scene did not need and so did not do, as `left_out` of the
[statistics](statistics.md) says it; *later* are the frames after the first, which reads and builds
everything that is seen. Made by `tests/left_out_table.py`; `regraft render … --explain` tells the
same of every frame.

Matrices are read in bulk as soon as anything but a camera moves: where few meshes stand in
thousands of places, as in `forest` and `n_body`, they are most of the bytes. Blender hands them out
all or none. Of a mesh that modifiers only move, positions are read and nothing else.

| scene | triangles | frame | bytes of geometry not read | left out |
|---|---|---|---|---|"""
_BYTES = re.compile(r"^([\d,]+) of ([\d,]+) bytes of geometry not read$")


def statistics(path: Path) -> list[Row]:
    """Rows of the first frames; empty if the file cannot be rendered."""
    with tempfile.TemporaryDirectory() as folder:
        target = Path(folder, "s.jsonl")
        first = first_frame(path)
        frames = f"{first}-{first + FRAMES - 1}"
        words = ["render", str(path), "--frames", frames, "--resolution", SIZE]
        words += ["--output", folder, "--statistics", str(target)]
        done = subprocess.run(
            [sys.executable, "-m", "regraft", *words], capture_output=True, text=True, check=False
        )
        if done.returncode:
            print(path.name, done.stderr.strip().splitlines()[-1:], file=sys.stderr)
            return []
        return [json.loads(line) for line in target.read_text("utf-8").splitlines()]


def first_frame(path: Path) -> int:
    """Imported files begin at 1; .blend files tell."""
    if path.suffix != ".blend":
        return 1
    ask = (
        f"import bpy; bpy.ops.wm.open_mainfile(filepath={str(path)!r}); "
        "print('first', bpy.context.scene.frame_start)"
    )
    said = subprocess.run([sys.executable, "-c", ask], capture_output=True, text=True, check=True)
    found = re.search(r"^first (-?\d+)$", said.stdout, re.MULTILINE)
    return int(found[1]) if found else 1


def lines(path: Path) -> list[str]:
    """The scene's rows of the table."""
    rows = statistics(path)
    if not rows:
        return []
    parts = (("first", rows[:1]), ("later", rows[1:]))
    name = f"{path.stem} | {rows[0]['triangles']:,}"
    return [
        f"| {name} | {when} | {unread(part):.1%} | {sentences(part)} |"
        for when, part in parts
        if part
    ]


def unread(rows: list[Row]) -> float:
    """Share of the bytes of meshes and matrices that these frames did not read."""
    found = [m.groups() for row in rows for m in map(_BYTES.match, row["left_out"]) if m]
    shares = [int(a.replace(",", "")) / int(b.replace(",", "")) for a, b in found]
    return sum(shares) / len(rows)


def sentences(rows: list[Row]) -> str:
    """Each sentence, with the number of frames that said it if not all did."""
    counts = Counter(words for row in rows for words in row["left_out"] if not _BYTES.match(words))
    return (
        "; ".join(
            words if n == len(rows) else f"{words} ({n} of {len(rows)} frames)"
            for words, n in counts.items()
        ).replace("|", "\\|")
        or "nothing"
    )


def main() -> None:
    print(HEAD)
    for name in sys.argv[1:]:
        for line in lines(Path(name)):
            print(line, flush=True)


if __name__ == "__main__":
    main()
