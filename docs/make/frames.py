"""Figures of the frames: which way x, y and z point in turning and milling, and where φ starts."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Arc, Circle, Polygon, Rectangle, Wedge

from docs.make.style import CARD, CORRECTED, INK, MUTED, RECORDING, RULE, SHADE, SIMULATION, drawn

Point = tuple[float, float]
SIDE_IN = 4.2


def force_on_tool(tangential_N: float, radial_N: float, phi_deg: float) -> Point:
    """Return (F_x, F_y) that the work puts on a milling tooth at φ, from +y towards +x.

    F_x = −F_t cos φ − F_r sin φ, F_y = F_t sin φ − F_r cos φ, with the feed along +x.
    """
    sine, cosine = np.sin(np.radians(phi_deg)), np.cos(np.radians(phi_deg))
    return (
        float(-tangential_N * cosine - radial_N * sine),
        float(tangential_N * sine - radial_N * cosine),
    )


def tooth_at(phi_deg: float, radius: float) -> Point:
    """Return where a tooth at φ is: (R sin φ, R cos φ)."""
    phi = np.radians(phi_deg)
    return float(radius * np.sin(phi)), float(radius * np.cos(phi))


def draw() -> None:
    """Draw both frames."""
    with drawn("frame-turning", height_in=SIDE_IN * 0.84, width_in=SIDE_IN) as (axes,):
        _turning(axes)
    with drawn("frame-milling", height_in=SIDE_IN * 0.84, width_in=SIDE_IN) as (axes,):
        _milling(axes)


def _blank(axes: Axes, x: Point, y: Point) -> None:
    axes.set(xlim=x, ylim=y, aspect="equal")
    axes.axis("off")


def _arrow(axes: Axes, start: Point, end: Point, colour: str, **more: Any) -> None:
    style = {"arrowstyle": "-|>", "color": colour, "lw": 1.6, "shrinkA": 0, "shrinkB": 0, **more}
    axes.annotate("", xy=end, xytext=start, arrowprops=style)


def _out_of_page(axes: Axes, at: Point, colour: str) -> None:
    axes.add_patch(Circle(at, 0.16, facecolor=CARD, edgecolor=colour, lw=1.6, zorder=5))
    axes.add_patch(Circle(at, 0.05, color=colour, zorder=6))


def _turning(axes: Axes) -> None:
    """Seen from above: x up, z to the right, so y points at the reader (right-handed)."""
    _blank(axes, (-0.4, 9.4), (-2.2, 5.6))
    axes.add_patch(Rectangle((0, -1.9), 1.0, 3.8, facecolor=RECORDING, edgecolor="none"))
    axes.text(0.5, 0, "chuck", rotation=90, ha="center", va="center", color=CARD)
    bar = [(1.0, -1.4), (1.0, 1.4), (4.3, 1.4), (4.55, 0.9), (6.6, 0.9), (6.6, -0.9),
           (4.55, -0.9), (4.3, -1.4)]  # fmt: skip
    axes.add_patch(Polygon(bar, facecolor=RULE, edgecolor=MUTED, lw=0.8))
    axes.plot([-0.2, 7.2], [0, 0], color=MUTED, lw=0.7, dashes=(9, 3, 2, 3))
    axes.text(2.6, -0.8, "work", ha="center", color=INK)
    tip = (4.62, 0.95)
    insert = [tip, (5.5, 1.35), (5.3, 2.5), (4.42, 2.1)]
    axes.add_patch(Polygon(insert, facecolor=SHADE, edgecolor=MUTED, lw=0.8))
    axes.text(5.75, 1.95, "tool", color=INK, va="center")
    _arrow(axes, (4.2, 3.35), (2.9, 3.35), MUTED)
    axes.text(2.75, 3.35, "feed", color=MUTED, ha="right", va="center")
    _forces_on_turning_tool(axes, tip)
    _turning_axes(axes, (7.2, 2.6))


def _forces_on_turning_tool(axes: Axes, tip: Point) -> None:
    _arrow(axes, tip, (tip[0], tip[1] + 2.0), SIMULATION, zorder=4)
    axes.text(tip[0], tip[1] + 2.12, "F_x", color=SIMULATION, ha="center", va="bottom")
    _arrow(axes, tip, (tip[0] + 2.3, tip[1]), SIMULATION)
    axes.text(tip[0] + 2.4, tip[1], "F_z", color=SIMULATION, va="center")
    _out_of_page(axes, tip, SIMULATION)
    axes.text(tip[0] - 0.3, tip[1] - 0.25, "F_y", color=SIMULATION, ha="right", va="top")


def _turning_axes(axes: Axes, origin: Point) -> None:
    x, y = origin
    _arrow(axes, origin, (x, y + 1.9), CORRECTED)
    _arrow(axes, origin, (x + 1.7, y), CORRECTED)
    _out_of_page(axes, origin, CORRECTED)
    axes.text(x, y + 2.0, "+x  outward", color=CORRECTED, ha="center", va="bottom")
    axes.text(x + 1.8, y, "+z", color=CORRECTED, va="center")
    axes.text(x + 0.25, y - 0.3, "+y  to you", color=CORRECTED, va="top")


def _milling(axes: Axes) -> None:
    """Seen along −z: x right, y up; the cutter turns clockwise, a slot is open behind it."""
    _blank(axes, (-3.3, 6.1), (-3.6, 4.0))
    radius, phi = 2.0, 60.0
    axes.add_patch(Rectangle((-3.2, -3.0), 7.0, 6.0, facecolor=RULE, edgecolor="none"))
    axes.add_patch(Rectangle((-3.2, -radius), 3.2, 2 * radius, facecolor=CARD, edgecolor="none"))
    axes.add_patch(Wedge((0, 0), radius, -90, 90, facecolor=SHADE, alpha=0.35, edgecolor="none"))
    axes.add_patch(Wedge((0, 0), radius, 90, 270, facecolor=CARD, edgecolor="none"))
    axes.add_patch(Circle((0, 0), radius, facecolor="none", edgecolor=MUTED, lw=1.0))
    axes.text(3.0, -2.7, "work", color=INK, ha="center")
    axes.plot([0, 0], [0, 2.7], color=MUTED, lw=0.8, dashes=(4, 3))
    axes.plot([0, tooth_at(phi, radius)[0]], [0, tooth_at(phi, radius)[1]], color=MUTED, lw=0.8)
    axes.add_patch(Arc((0, 0), 2.2, 2.2, theta1=90 - phi, theta2=90, color=INK, lw=1.0))
    _arrow(axes, tooth_at(phi - 6, 1.1), tooth_at(phi, 1.1), INK, lw=1.0)
    axes.text(*tooth_at(phi / 2, 1.4), "φ", color=INK, ha="center", va="center")
    _teeth(axes, phi, radius)
    _forces_on_tooth(axes, phi, radius)
    _milling_axes(axes, (4.35, -2.9))
    _arrow(axes, (-2.6, 3.45), (-1.0, 3.45), MUTED)
    axes.text(-0.85, 3.45, "feed", color=MUTED, va="center")


def _teeth(axes: Axes, phi: float, radius: float) -> None:
    for tooth in range(4):
        at = tooth_at(phi - 90.0 * tooth, radius)
        axes.add_patch(Circle(at, 0.13, facecolor=INK, edgecolor=CARD, lw=0.8, zorder=5))
        beside = tooth_at(phi - 90.0 * tooth + 14.0, radius + 0.4)
        axes.text(*beside, str(tooth), color=INK, ha="center", va="center", fontsize=9)


def _forces_on_tooth(axes: Axes, phi: float, radius: float) -> None:
    at = tooth_at(phi, radius)
    for tangential, radial, name, off in (
        (1.7, 0.0, "F_t", (0.1, 0.1)),
        (0.0, 1.0, "F_r", (-0.2, -0.38)),
    ):
        f_x, f_y = force_on_tool(tangential, radial, phi)
        end = (at[0] + f_x, at[1] + f_y)
        _arrow(axes, at, end, SIMULATION, zorder=6)
        axes.text(end[0] + off[0], end[1] + off[1], name, color=SIMULATION, ha="left", va="center")


def _milling_axes(axes: Axes, origin: Point) -> None:
    x, y = origin
    _arrow(axes, origin, (x, y + 1.4), CORRECTED)
    _arrow(axes, origin, (x + 1.4, y), CORRECTED)
    _out_of_page(axes, origin, CORRECTED)
    axes.text(x, y + 1.5, "+y", color=CORRECTED, ha="center", va="bottom")
    axes.text(x + 1.45, y, "+x", color=CORRECTED, va="center")
    axes.text(x, y - 0.3, "+z", color=CORRECTED, ha="center", va="top")
