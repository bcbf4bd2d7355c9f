"""One HTML page that needs nothing else: no network, no scripts, pictures inside."""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from html import escape
from typing import Any

from regraft.study.plots import Plot

_STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; margin: 2rem auto; max-width: 74rem; padding: 0 1rem;
  color: #1a1a1a; background: #fff }
h1 { font-size: 1.4rem } h2 { font-size: 1.15rem; margin-top: 2.5rem; border-top: 1px solid #ddd;
  padding-top: 1.2rem }
.verdict { font-size: 1.1rem; border-left: 4px solid #0072b2; padding: .4rem 0 .4rem .9rem;
  max-width: 60rem }
.wrong { border-color: #d00000; color: #a00000 }
.plots { display: grid; grid-template-columns: repeat(auto-fit, minmax(28rem, 1fr)); gap: 1rem }
figure { margin: 0 } figure img { width: 100% } figcaption { font-size: .85rem; color: #555 }
.table { overflow-x: auto } table { border-collapse: collapse; font-size: .85rem; margin: 1rem 0 }
th, td { padding: .25rem .6rem; text-align: right; border-bottom: 1px solid #e5e5e5;
  font-variant-numeric: tabular-nums; white-space: nowrap }
th:first-child, td:first-child { text-align: left } th { border-bottom: 2px solid #bbb }
tr.chosen td { background: #eef6fb; font-weight: 600 }
dl { display: grid; grid-template-columns: max-content 1fr; gap: .1rem 1rem; font-size: .85rem }
dt { color: #555 } dd { margin: 0 }
"""


@dataclass(frozen=True)
class Table:
    """Rows as dicts; `columns` gives each key its heading; the row `chosen` stands out."""

    columns: Mapping[str, str]
    rows: Sequence[Mapping[str, Any]]
    chosen: int | None = None


@dataclass
class Section:
    """What was found about one scene; `wrong`: the verdict is that something is not as it must
    be."""

    title: str
    verdict: str
    wrong: bool = False
    plots: list[Plot] = field(default_factory=list)
    tables: list[Table] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)


@dataclass(frozen=True)
class Page:
    """`facts`: what the figures must be read with."""

    title: str
    sections: Sequence[Section]
    facts: Mapping[str, Any]

    def html(self) -> str:
        """The whole page. Verdicts come first, then the evidence for each."""
        verdicts = "".join(_verdict(s, with_title=len(self.sections) > 1) for s in self.sections)
        evidence = "".join(map(_section, self.sections))
        facts = "".join(f"<dt>{escape(k)}</dt><dd>{_cell(v)}</dd>" for k, v in self.facts.items())
        return (
            f'<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">'
            f"<title>{escape(self.title)}</title>"
            f'<meta name="viewport" content="width=device-width">'
            f"<style>{_STYLE}</style></head>\n<body><h1>{escape(self.title)}</h1>\n"
            f"{verdicts}\n{evidence}\n<h2>Measured with</h2><dl>{facts}</dl></body></html>\n"
        )


def _verdict(section: Section, *, with_title: bool) -> str:
    title = f"<b>{escape(section.title)}:</b> " if with_title else ""
    kind = "verdict wrong" if section.wrong else "verdict"
    return f'<p class="{kind}">{title}{escape(section.verdict)}</p>\n'


def _section(section: Section) -> str:
    plots = "".join(map(_figure, section.plots))
    notes = "".join(f"<li>{escape(note)}</li>" for note in section.notes)
    return (
        f'<h2>{escape(section.title)}</h2>\n<div class="plots">{plots}</div>\n'
        f"{''.join(map(_table, section.tables))}<ul>{notes}</ul>\n"
    )


def _figure(plot: Plot) -> str:
    data = base64.b64encode(plot.svg).decode()
    caption = escape(plot.caption)
    return (
        f'<figure><img alt="{caption}" src="data:image/svg+xml;base64,{data}">'
        f"<figcaption>{caption}</figcaption></figure>"
    )


def _table(table: Table) -> str:
    head = "".join(f"<th>{escape(text)}</th>" for text in table.columns.values())
    body = "".join(
        ('<tr class="chosen">' if i == table.chosen else "<tr>")
        + "".join(f"<td>{_cell(row.get(key))}</td>" for key in table.columns)
        + "</tr>"
        for i, row in enumerate(table.rows)
    )
    return f'<div class="table"><table><tr>{head}</tr>{body}</table></div>'


def _cell(value: Any) -> str:
    return escape(text(value))


def text(value: Any) -> str:
    """A value as people read it: whole numbers in groups of three, others to four digits."""
    if value is None:
        return "–"
    if isinstance(value, bool) or not isinstance(value, int | float):
        return str(value)
    if isinstance(value, int):
        return f"{value:,}"
    return f"{value:,.0f}" if abs(value) >= 1e4 else f"{value:.4g}"
