"""Files that Blender imports: each is framed and drawn, or refused by name."""

from __future__ import annotations

import base64
import json
import os
import struct
import subprocess
import sys
from pathlib import Path

import pytest

from blenders import Blender
from regraft.formats.images import verify

POINTS = ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
FACES = ((0, 1, 2), (0, 1, 3), (1, 2, 3), (0, 2, 3))


def obj() -> str:
    lines = [f"v {x} {y} {z}" for x, y, z in POINTS]
    return "\n".join(lines + [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in FACES]) + "\n"


def ply() -> str:
    head = f"ply\nformat ascii 1.0\nelement vertex {len(POINTS)}\n"
    head += "".join(f"property float {axis}\n" for axis in "xyz")
    head += f"element face {len(FACES)}\nproperty list uchar int vertex_indices\nend_header\n"
    lines = [f"{x} {y} {z}" for x, y, z in POINTS] + [f"3 {a} {b} {c}" for a, b, c in FACES]
    return head + "\n".join(lines) + "\n"


def stl() -> str:
    def facet(face: tuple[int, ...]) -> str:
        corners = "".join("vertex {} {} {}\n".format(*POINTS[i]) for i in face)
        return f"facet normal 0 0 1\nouter loop\n{corners}endloop\nendfacet\n"

    return "solid t\n" + "".join(map(facet, FACES)) + "endsolid t\n"


def gltf() -> str:
    """One mesh, moved along x by an animation of two seconds."""
    points = b"".join(struct.pack("<3f", *p) for p in POINTS)
    faces = b"".join(struct.pack("<3H", *f) for f in FACES)
    times = struct.pack("<2f", 0.0, 2.0)
    places = struct.pack("<6f", 0, 0, 0, 5, 0, 0)
    parts, views, data = (points, faces, times, places), [], b""
    for part in parts:
        views.append({"buffer": 0, "byteOffset": len(data), "byteLength": len(part)})
        data += part
    uri = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
    accessors = [
        {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3",
         "min": [0, 0, 0], "max": [1, 1, 1]},
        {"bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR"},
        {"bufferView": 2, "componentType": 5126, "count": 2, "type": "SCALAR",
         "min": [0], "max": [2]},
        {"bufferView": 3, "componentType": 5126, "count": 2, "type": "VEC3"},
    ]  # fmt: skip
    sampler = {"input": 2, "output": 3}
    channel = {"sampler": 0, "target": {"node": 0, "path": "translation"}}
    return json.dumps(
        {
            "asset": {"version": "2.0"},
            "scene": 0,
            "scenes": [{"nodes": [0]}],
            "nodes": [{"mesh": 0}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
            "buffers": [{"uri": uri, "byteLength": len(data)}],
            "bufferViews": views,
            "accessors": accessors,
            "animations": [{"samplers": [sampler], "channels": [channel]}],
        }
    )


def usda() -> str:
    points = ", ".join(str(p) for p in POINTS)
    corners = ", ".join(str(i) for face in FACES for i in face)
    return f"""#usda 1.0
(
    startTimeCode = 1
    endTimeCode = 3
)
def Mesh "t"
{{
    int[] faceVertexCounts = [3, 3, 3, 3]
    int[] faceVertexIndices = [{corners}]
    point3f[] points = [{points}]
    double3 xformOp:translate.timeSamples = {{ 1: (0, 0, 0), 3: (5, 0, 0) }}
    uniform token[] xformOpOrder = ["xformOp:translate"]
}}
"""


CONTENTS = {".obj": obj, ".ply": ply, ".stl": stl, ".gltf": gltf, ".usda": usda}
# Debian's 3.4 is built without USD.
MISSING = {("3.4", ".usda")}


def render(blender: Blender, source: Path, *words: object) -> subprocess.CompletedProcess[str]:
    environment, python = dict(os.environ), str(blender.executable)
    if blender.version == "3.4":
        python, environment["REGRAFT_BLENDER"] = sys.executable, python
    command = [python, "-m", "regraft", "render", str(source), *map(str, words)]
    return subprocess.run(command, env=environment, capture_output=True, text=True, timeout=120)


@pytest.mark.parametrize("suffix", CONTENTS)
def test_a_file_is_drawn_or_refused_by_name(blender: Blender, suffix: str, tmp_path: Path) -> None:
    source = tmp_path / f"shape{suffix}"
    source.write_text(CONTENTS[suffix]())
    done = render(blender, source, "--resolution", "64x48", "--output", tmp_path, "--frames", "1")
    if (blender.version, suffix) in MISSING:
        assert done.returncode == 3
        assert f"no importer for {suffix} files: cannot read {source}" in done.stderr
        return
    assert done.returncode == 0, done.stderr
    verify(tmp_path / "shape_0001.png", 64, 48)
    assert "framing everything" in done.stderr


def test_an_imported_animation_has_its_own_range(blender: Blender, tmp_path: Path) -> None:
    source = tmp_path / "move.gltf"
    source.write_text(gltf())
    done = render(blender, source, "--resolution", "32x24", "--output", tmp_path)
    assert done.returncode == 0, done.stderr
    frames = sorted(tmp_path.glob("move_*.png"))
    assert frames[0].name in ("move_0000.png", "move_0001.png")
    assert len(frames) == 49, "two seconds at 24 frames a second, both ends"
