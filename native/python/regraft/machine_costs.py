"""What updates take operations for on this machine: measured once, kept in the user's cache folder.

`REGRAFT_COSTS` overrides it: a file, or costs such as `rebuild=4,refine=30`; `default` ignores the
cache folder.
"""

from __future__ import annotations

import json
import logging
import os
from pathlib import Path

from regraft import _regraft

LOG = logging.getLogger("regraft")
VARIABLE = "REGRAFT_COSTS"
NAMES = ("leaf", "rebuild", "refine", "morton")


def cache_file() -> Path:
    """Where measured costs are kept."""
    folder = os.environ.get("XDG_CACHE_HOME") or os.path.join("~", ".cache")
    return Path(folder).expanduser() / "regraft" / "machine_costs.json"


def load() -> str:
    """Sets the costs of this process; returns in words where they come from.

    Costs that cannot be read are warned about, and the defaults stay.
    """
    setting = os.environ.get(VARIABLE, "").strip()
    if setting == "default":
        return "defaults"
    path = None if "=" in setting else Path(setting) if setting else cache_file()
    if path is not None and not setting and not path.is_file():
        return "defaults; regraft doctor --calibrate measures this machine's"
    try:
        costs = _parse(setting) if path is None else json.loads(path.read_text(encoding="utf-8"))
        _set(costs)
    except (OSError, ValueError, TypeError) as error:
        LOG.warning("machine costs of %s left out: %s", path or VARIABLE, error)
        return "defaults"
    return f"{VARIABLE}={setting}" if setting else str(path)


def save(costs: dict[str, float]) -> Path:
    """Keeps measured costs for later processes, and sets them for this one. Raises OSError."""
    _set(costs)
    path = cache_file()
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_name(f".{path.name}.{os.getpid()}")
    part.write_text(json.dumps(costs) + "\n", encoding="utf-8")
    part.replace(path)
    return path


def _parse(text: str) -> dict[str, float]:
    pairs = (part.partition("=") for part in text.split(","))
    return {name.strip(): float(value) for name, _, value in pairs}


def _set(costs: dict[str, float]) -> None:
    if not isinstance(costs, dict) or not set(costs) <= set(NAMES):
        raise ValueError(f"costs of {', '.join(NAMES)} wanted")
    _regraft.set_machine_costs(**costs)
