"""The files of a finished study: tables, pictures and the page, put in place at the end only."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from regraft.formats import atomic
from regraft.study import tidy
from regraft.study.page import Page, Section

PAGE, VERDICTS = "index.html", "verdicts.jsonl"
Row = Mapping[str, Any]


@dataclass
class Report:
    """A study's results: `tables` become NAME.csv, `lines` NAME.jsonl, what is said of each scene
    verdicts.jsonl."""

    title: str
    facts: Mapping[str, Any]
    sections: list[Section] = field(default_factory=list)
    tables: dict[str, list[Row]] = field(default_factory=dict)
    lines: dict[str, list[Row]] = field(default_factory=dict)

    def add(self, kind: str, rows: Sequence[Row], of: str) -> None:
        """Rows about the scene `of` for the table NAME.csv."""
        self.tables.setdefault(kind, []).extend({"scene": of, **row} for row in rows)

    def write(self, folder: Path) -> Path:
        """Each file is whole or not there; the page comes last. Raises OSError."""
        for name, rows in self.tables.items():
            tidy.write_csv(folder / f"{name}.csv", rows)
        for name, rows in self.lines.items():
            tidy.write_jsonl(folder / f"{name}.jsonl", rows)
        told = [{"scene": s.title, "verdict": s.verdict, "wrong": s.wrong} for s in self.sections]
        tidy.write_jsonl(folder / VERDICTS, told)
        for plot in (plot for section in self.sections for plot in section.plots):
            stem = file_name(plot.name)
            atomic.write_bytes(folder / f"{stem}.png", plot.png)
            atomic.write_bytes(folder / f"{stem}.svg", plot.svg)
        page = folder / PAGE
        html = Page(self.title, self.sections, self.facts).html()
        atomic.write_bytes(page, html.encode())
        return page


def file_name(name: str) -> str:
    """`name` without what file systems and addresses stumble over."""
    return re.sub(r"[^\w.+-]+", "_", name).strip("._") or "scene"
