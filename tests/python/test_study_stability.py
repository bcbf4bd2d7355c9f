"""`study stability`: what it measures is true of scenes of which the truth is known."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import regraft
from regraft.study import stability, stability_report
from regraft.study.mirror import Mirror
from stand_in_recording import shot_in

Row = dict[str, Any]
SQUARE = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], np.float32)
FACES = np.array([[0, 1, 2], [0, 2, 3]], np.uint32)
DOWN = stability.Rays(np.array([[0.25, 0.5, 4.0]]), np.array([[0.0, 0.0, -2.0]]))


def mirror_of_square(stretch: float = 1.0) -> Mirror:
    mirror = Mirror(regraft.Scene(threads=1), stretch)
    mirror.add_instance(mirror.add_mesh(SQUARE, FACES), np.eye(4))
    mirror.update()
    return mirror


def test_a_mapped_ray_hits_the_same_at_the_same_t() -> None:
    mirror = mirror_of_square()
    for axis, exponents in stability.EXPONENTS.items():
        m = stability.place(axis, exponents[-1] // 4, 4.0)
        mirror.see_through(m)
        mirror.update()
        there = DOWN.mapped(m)
        hit = mirror.closest_hit(there.origins, there.directions)
        assert hit.t[0] == pytest.approx(2.0, rel=1e-6), axis
        assert stability.brightness(hit, DOWN, m) == pytest.approx(1.0), axis
        assert stability._errors(mirror, DOWN, hit, m) == pytest.approx(0.0, abs=1.0)
        assert stability._unequal(mirror, there, hit) == 0


def test_an_error_of_t_is_counted_in_ulps() -> None:
    mirror = mirror_of_square()
    for ulps in (0.0, 3.0, 100.0):
        # The largest coordinate at hand is 4, a unit of t is 2 long.
        t = np.array([2.0 + ulps * 4 * 2.0**-23 / 2])
        said = SimpleNamespace(t=t, instance_id=np.array([0]), prim_id=np.array([1]))
        assert stability._errors(mirror, DOWN, said, np.eye(4)) == pytest.approx(ulps)


def test_a_wrong_answer_is_found() -> None:
    mirror = mirror_of_square()
    hit = mirror.closest_hit(DOWN.origins, DOWN.directions)
    assert stability._unequal(mirror, DOWN, hit) == 0
    wrong = SimpleNamespace(
        t=hit.t, instance_id=hit.instance_id, prim_id=hit.prim_id ^ 1, u=hit.u, v=hit.v
    )
    assert stability._unequal(mirror, DOWN, wrong) == 1


def test_motion_is_exaggerated_from_where_things_were() -> None:
    mirror = mirror_of_square(10.0)
    moved = np.eye(4)
    moved[0, 3] = 0.5
    mirror.set_transform(0, moved)
    mirror.set_vertices(0, SQUARE + np.array([0, 0, 0.25], np.float32))
    corner = mirror.corners(np.array([0]), np.array([0]))[0, 0]
    assert corner == pytest.approx([-1 + 5.0, -1.0, 2.5])
    mirror.update()
    assert mirror.bounds()[0] == pytest.approx([4.0, -1.0, 2.5], abs=1e-4)


def row(axis: str, exponent: float, **more: Any) -> Row:
    about = {"structure": "bvh", "layout": "flat", "policy": "auto", "worst_ulps": 2.0}
    counts = {"pixels_changed": 0, "differ_from_brute_force": 0}
    return {"axis": axis, "exponent": exponent, **about, **counts, **more}


def test_the_first_setting_that_changes_a_picture_is_named() -> None:
    rows = [row("offset", e, pixels_changed=(e > 10) * e) for e in (0, 20, 12, 4)]
    rows += [row("scale", e, pixels_changed=5 if e == -60 else 0) for e in (-60, 60)]
    said, wrong = stability_report.sentence(rows)
    assert not wrong
    assert "at an offset of 4.1e+03 × its size (12 pixels" in said
    assert f"at a scale of {2.0**-60:.3g} (5 pixels" in said
    assert "aspect: the picture keeps every pixel, up to 2.68e+08" in said


def test_an_answer_that_differs_is_the_verdict() -> None:
    said, wrong = stability_report.sentence([row("offset", 4, differ_from_brute_force=2)])
    assert wrong
    assert "at offset 16 (bvh flat auto) 2 rays differ from brute force" in said


def test_a_shot_is_measured_under_every_setting(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(stability, "EXPONENTS", {"offset": (0, 20), "aspect": (4,)})
    monkeypatch.setattr(stability, "TIME_STEPS", (100.0,))
    ticks: list[object] = []
    shot = shot_in(tmp_path)
    rows = list(stability.measure(shot, 12, 1, ticks.append))
    rows += stability.measure_steps(shot, 12, 1, ticks.append)
    assert len(rows) == len(ticks)
    assert {r["axis"] for r in rows} == {"offset", "aspect", "time step"}
    assert all(r["differ_from_brute_force"] == 0 for r in rows)
    assert all(r["worst_ulps"] < 16 for r in rows if r["axis"] == "offset")
    assert all(r["pixels_changed"] == 0 for r in rows if r["axis"] == "offset")
    assert not stability_report.sentence(rows)[1]
