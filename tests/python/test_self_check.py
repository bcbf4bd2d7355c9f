"""The self-check: it passes on this build, and it can fail."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import regraft
from regraft.cli.errors import SelfCheckError
from regraft.cli.self_check import run_self_check

TRUE_SCENE = regraft.Scene


def test_this_build_agrees_with_numpy() -> None:
    assert "agree with NumPy" in run_self_check()


class Liar:
    """A Scene with one wrong answer."""

    def __init__(self, threads: int = 0) -> None:
        self._scene = TRUE_SCENE(threads=threads)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._scene, name)

    def closest_hit(self, origins: Any, directions: Any) -> Any:
        hits = self._scene.closest_hit(origins, directions)
        wrong = np.array(hits.t)
        wrong[17] = 3.25
        return type("Hits", (), {"t": wrong})


def test_one_wrong_ray_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(regraft, "Scene", Liar)
    with pytest.raises(SelfCheckError, match=r"1 of 4000 rays .* as built; ray 17: t = 3.25"):
        run_self_check()


class Deaf(Liar):
    """A Scene that does not notice new positions."""

    def closest_hit(self, origins: Any, directions: Any) -> Any:
        return self._scene.closest_hit(origins, directions)

    def set_vertices(self, mesh: int, vertices: Any) -> None:
        pass


def test_a_refit_that_does_nothing_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(regraft, "Scene", Deaf)
    with pytest.raises(SelfCheckError, match="after a refit"):
        run_self_check()
