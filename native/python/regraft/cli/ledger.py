"""Which frame files of a folder are finished, and with which settings they were made."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field
from pathlib import Path

from regraft.formats import jsonl

LEDGER = ".regraft_frames.jsonl"


@dataclass
class ResumePlan:
    """Frames by what `--resume` does with them; `done` is skipped, the others are rendered."""

    done: list[int] = field(default_factory=list)
    missing: list[int] = field(default_factory=list)
    damaged: list[int] = field(default_factory=list)
    other_settings: list[int] = field(default_factory=list)

    @property
    def todo(self) -> list[int]:
        """Ascending frames that must be rendered."""
        return sorted(self.missing + self.damaged + self.other_settings)

    def describe(self) -> str:
        """One sentence for the user."""
        parts = [f"{len(self.done)} finished frames stay"]
        for name in ("missing", "damaged", "other_settings"):
            if frames := getattr(self, name):
                parts.append(f"{len(frames)} {_WORDS[name]}")
        return "resume: " + ", ".join(parts)


_WORDS = {
    "missing": "to render",
    "damaged": "changed or damaged since, rendered again",
    "other_settings": "made with other settings or from another file, rendered again",
}


class Ledger:
    """A file in the output folder with a row for every finished frame; the last row counts.

    A row holds the hash of the frame file's bytes, taken after they were verified: a file that
    still has it needs no second decoding.
    """

    def __init__(self, folder: Path, fingerprint: str) -> None:
        self._path = folder / LEDGER
        self._fingerprint = fingerprint

    def plan(self, targets: dict[int, Path]) -> ResumePlan:
        """Sorts frames by the state of their files. Raises OSError."""
        rows = {row.get("file"): row for row in jsonl.read(self._path)}
        plan = ResumePlan()
        for frame, target in targets.items():
            getattr(plan, self._state(target, rows.get(target.name))).append(frame)
        return plan

    def record(self, target: Path) -> None:
        """Notes that `target` is finished and verified. Raises OSError."""
        row = {"file": target.name, "fingerprint": self._fingerprint, "sha256": _hash(target)}
        jsonl.append(self._path, row)

    def _state(self, target: Path, row: jsonl.Row | None) -> str:
        if not target.is_file():
            return "missing"
        if row is None or row.get("fingerprint") != self._fingerprint:
            return "other_settings"
        return "done" if _hash(target) == row.get("sha256") else "damaged"


def _hash(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
