"""Figure of the rooms: each floor imports only floors below it, by the contracts on imports."""

import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from matplotlib.axes import Axes
from matplotlib.patches import FancyArrowPatch, FancyBboxPatch

from docs.make.style import CARD, CORRECTED, INK, MUTED, RULE, SIMULATION, WARN, drawn

ROOT = Path(__file__).parent.parent.parent
WIDE, HIGH, GAP = 10.0, 0.8, 0.14
WORDS = {
    "cli": "commands",
    "web": "pages and HTTP",
    "proofs": "virtual machines, what is counted on them",
    "library": "what import autodb gives",
    "reports": "pages to keep: cards, figures",
    "agent": "one machine's life, on the database",
    "explain": "recording − simulation",
    "forward": "job → forces",
    "pairs": "posterior of a work-tool pair",
    "sensing": "current → force",
    "cutting": "law and geometry of the edge",
    "terms": "effects of drive, cut, sensor",
    "nc": "programs, written and read",
    "standard": "standard cuts",
    "records": "named channels in our units",
    "live": "a machine while it runs",
    "readers": "a format each",
    "signals": "filters, ranges",
    "timing": "stamps, even rows",
    "wording": "languages, marks, units",
    "fitting": "least squares",
    "store": "the database",
    "files": "job, tool, machine files",
    "assets": "what is shipped",
    "errors": "unusable input",
}
FLOORS = "Arrows point down"
PHYSICS = "No plotting, database or command line in the physics"
"""Names of the contracts that the figure shows."""


def floors() -> list[list[str]]:
    """Return the rooms of each floor, the highest first."""
    return [_rooms(layer.split("|")) for layer in _contract(FLOORS)["layers"]]


def _contract(name: str) -> dict[str, Any]:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
    every: list[dict[str, Any]] = project["tool"]["importlinter"]["contracts"]
    return next(one for one in every if one["name"] == name)


def _rooms(modules: Sequence[str]) -> list[str]:
    return [module.strip().removeprefix("autodb.") for module in modules]


def draw() -> None:
    """Draw the rooms, floor by floor."""
    every, physics = floors(), frozenset(_rooms(_contract(PHYSICS)["source_modules"]))
    top = len(every) * (HIGH + GAP)
    with drawn("rooms", height_in=6.0) as (axes,):
        axes.set(xlim=(-0.75, WIDE + 0.05), ylim=(-0.75, top + 0.05))
        axes.axis("off")
        for number, rooms in enumerate(every):
            _floor(axes, rooms, physics, top - (number + 1) * (HIGH + GAP) + GAP)
        arrow = FancyArrowPatch((-0.35, top - GAP), (-0.35, 0.0), arrowstyle="-|>",
                                mutation_scale=14, color=MUTED, lw=1.4)  # fmt: skip
        axes.add_patch(arrow)
        axes.text(-0.62, top / 2, "imports", rotation=90, ha="center", va="center", color=MUTED)
        _legend(axes)


def _floor(axes: Axes, rooms: list[str], physics: frozenset[str], low: float) -> None:
    wide = (WIDE - GAP * (len(rooms) - 1)) / len(rooms)
    for number, room in enumerate(rooms):
        left, colour = number * (wide + GAP), _colour(room, physics)
        box = FancyBboxPatch((left, low), wide, HIGH, boxstyle="round,pad=0,rounding_size=0.1",
                             facecolor=CARD, edgecolor=colour, lw=1.3)  # fmt: skip
        axes.add_patch(box)
        if len(rooms) > 2:
            axes.text(left + wide / 2, low + 0.52, room, ha="center", va="center", color=colour,
                      weight="bold", fontsize=9)  # fmt: skip
            axes.text(left + wide / 2, low + 0.22, WORDS[room], ha="center", va="center",
                      color=INK, fontsize=7.5)  # fmt: skip
            continue
        axes.text(left + 0.2, low + HIGH / 2, room, ha="left", va="center", color=colour,
                  weight="bold", fontsize=9)  # fmt: skip
        axes.text(left + 1.6, low + HIGH / 2, WORDS[room], ha="left", va="center", color=INK,
                  fontsize=8)  # fmt: skip


def _colour(room: str, physics: frozenset[str]) -> str:
    if room in physics:
        return CORRECTED
    return {"proofs": WARN, "store": SIMULATION}.get(room, MUTED)


def _legend(axes: Axes) -> None:
    axes.plot([0, WIDE], [-0.18, -0.18], color=RULE, lw=0.8)
    for left, colour, words in (
        (0.0, CORRECTED, "physics: no database, no plots"),
        (4.2, SIMULATION, "database"),
        (6.0, WARN, "generator: its own physics"),
    ):
        axes.plot([left + 0.05, left + 0.35], [-0.5, -0.5], color=colour, lw=2.4)
        axes.text(left + 0.5, -0.5, words, ha="left", va="center", color=INK, fontsize=8)
