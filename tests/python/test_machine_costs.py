"""Costs of operations: where they come from, and what becomes of wrong ones."""

from __future__ import annotations

import json
import logging
from collections.abc import Iterator
from pathlib import Path

import pytest

from regraft import _regraft, machine_costs


@pytest.fixture(autouse=True)
def put_back() -> Iterator[None]:
    before = _regraft.machine_costs()
    yield
    _regraft.set_machine_costs(**before)


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.delenv(machine_costs.VARIABLE, raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    return tmp_path / "regraft" / "machine_costs.json"


def test_what_was_saved_is_loaded(cache: Path) -> None:
    before = _regraft.machine_costs()
    assert machine_costs.load().startswith("defaults")
    assert machine_costs.save({**before, "rebuild": 7.5}) == cache
    _regraft.set_machine_costs(**before)
    assert machine_costs.load() == str(cache)
    assert _regraft.machine_costs() == {**before, "rebuild": 7.5}


def test_the_environment_overrides_the_cache(
    cache: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    machine_costs.save(_regraft.machine_costs())
    monkeypatch.setenv(machine_costs.VARIABLE, "refine=12, morton=3")
    machine_costs.load()
    assert (_regraft.machine_costs()["refine"], _regraft.machine_costs()["morton"]) == (12, 3)
    other = tmp_path / "other.json"
    other.write_text(json.dumps({"leaf": 2.5}))
    monkeypatch.setenv(machine_costs.VARIABLE, str(other))
    machine_costs.load()
    assert _regraft.machine_costs()["leaf"] == 2.5


@pytest.mark.parametrize("text", ["{", "[]", '{"speed": 3}', '{"leaf": "x"}', '{"leaf": -1}'])
def test_damaged_files_are_warned_about(
    cache: Path, text: str, caplog: pytest.LogCaptureFixture
) -> None:
    before = _regraft.machine_costs()
    cache.parent.mkdir()
    cache.write_text(text)
    with caplog.at_level(logging.WARNING, logger="regraft"):
        assert machine_costs.load() == "defaults"
    assert str(cache) in caplog.text
    assert _regraft.machine_costs() == before


def test_calibration_measures_every_cost() -> None:
    costs = _regraft.calibrate(threads=1)
    assert set(costs) == set(machine_costs.NAMES)
    assert all(0.0 < cost < 1e4 for cost in costs.values())
