"""The tables of terms, read off the terms themselves."""

import inspect
import math
import re

import numpy as np

from autodb.explain.waves.answers import APART, STATEMENTS
from autodb.terms.term import Contribution, Term, TermParameter
from autodb.terms.vocabulary import TERMS
from docs.make import explained

BEGIN, END = "<!-- terms: made by python -m docs.make -->\n", "<!-- end of terms -->\n"
CHANNELS = {
    "axis": "Axis effort, over time",
    "rotary": "Effort of a rotary axis, over time (degrees for mm)",
    "spindle": "Spindle effort, over time",
    "cuts": "Cutting forces, one value a cut",
    "table": "Force on a rotating table, over time",
}
SHAPE = re.compile(r"[,;] \(n,( ?\d+)?\)")
HEAD = (
    "| term | equation | parameters | at standstill | excited by | distinguished from | source "
    "| named by explain |\n|---|---|---|---|---|---|---|---|"
)
MILL_HEAD = "| term | what it is | distinguished from | named by explain |\n|---|---|---|---|"
MANY = 4
"""Coefficients of a term that are listed one by one."""
STANDING = {"position": 7.0, "angle_x": 0.5, "angle_z": 0.5}
"""Inputs of something that stands; t runs, everything that is not here is 0."""


def tables() -> str:
    """Return one table for each kind of channel; a term that an earlier one holds is named only."""
    parts, shown = [], set[str]()
    for channel, title in CHANNELS.items():
        here = [term for term in TERMS if channel in term.channels]
        new = [term for term in here if _name(term) not in shown]
        again = [_name(term) for term in here if _name(term) in shown]
        parts += [f"## {title}", ""]
        if again:
            parts += [f"As above: {', '.join(again)}.", ""]
        parts += [HEAD, *(_row(term) for term in new), ""]
        shown |= {_name(term) for term in new}
    return "\n".join([*parts, "## Forces of a mill, over time", "", *_of_mills(), ""])


def _of_mills() -> list[str]:
    """Return the table of what is searched for in a waveform: on other chips, or in the sensor."""
    rows = [MILL_HEAD]
    for name, statement in STATEMENTS.items():
        pairs = {other: words for pair, words in APART.items() for other in pair - {name}
                 if name in pair}  # fmt: skip
        apart = "<br>".join(f"`{other}`: {words}" for other, words in pairs.items())
        rows.append(f"| `{name}` | {statement} | {apart} | yes |")
    return rows


def filled(page: str) -> str:
    """Return ``page`` with the tables between its two comments."""
    before, rest = page.split(BEGIN)
    _, after = rest.split(END)
    return f"{before}{BEGIN}\n{tables()}\n{END}{after}"


def _row(term: Term) -> str:
    cells = (
        _name(term),
        _equation(term),
        "<br>".join(_listed(term)),
        standstill(term),
        term.excited_by,
        _apart(term),
        term.source,
        _explained(term),
    )
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"


def _listed(term: Term) -> list[str]:
    """Return a line a parameter; of many coefficients the first and the last."""
    first = [_parameter(p) for p in term.coefficients]
    if len(first) > MANY:
        first = [first[0], f"… {len(first) - 2} more", first[-1]]
    return [*first, *(_parameter(p) for p in term.shape)]


def _name(term: Term) -> str:
    return f"`{term.name}` {term.form}".strip()


def _equation(term: Term) -> str:
    """Return the first sentence of the function's docstring, without the shape of its result."""
    first = " ".join(str(inspect.getdoc(term.function)).split("\n\n")[0].split())
    return SHAPE.sub("", first).replace("``", "`").replace("; 0 at standstill", "")


def _parameter(parameter: TermParameter) -> str:
    text = f"`{parameter.name}` {parameter.unit}: {parameter.meaning}"
    if math.isfinite(parameter.lower) or math.isfinite(parameter.upper):
        text += f"; {_bound(parameter.lower)} to {_bound(parameter.upper)}"
    if parameter.prior is not None:
        prior = parameter.prior
        text += f"; prior {prior.mean:g} ± {prior.sd:g} ({prior.source})"
    return text


def _bound(value: float) -> str:
    return f"{value:g}".replace("inf", "∞").replace("-", "−")


def standstill(term: Term) -> str:
    """Return what a contribution over time gives where nothing moves: 0, or that it acts."""
    if term.channels[0] == "cuts":
        return ""
    if not isinstance(term, Contribution):
        return "as its terms do"
    t_s = np.linspace(0.0, 10.0, 101)
    arrays = [t_s if n == "t" else np.full(101, STANDING.get(n, 0.0)) for n in term.inputs]
    usual = {"rest": 0.0, "start": 2.0, "end": 5.0}
    shape = {p.keyword: p.starts[0] if p.starts else usual.get(p.name, 20.0) for p in term.shape}
    return "acts" if np.any(term.function(*arrays, **shape)) else "0"


def _apart(term: Term) -> str:
    if not term.alike:
        return ""
    return f"{', '.join(f'`{name}`' for name in term.alike)}: {term.distinguished_by}"


def _explained(term: Term) -> str:
    """`shear` is in every simulation of a cut: it can only be off."""
    if term.name == "shear":
        return "only as mistuned"
    return "yes" if term.name in explained.names() else ""
