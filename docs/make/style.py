"""How every figure looks, and how it is written: same bytes each time, right in light and dark.

Figures are drawn in the light tones of the reports' palette; in the file each tone becomes a
variable that the reader's colour scheme sets. Text stays text.
"""

import io
import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib import pyplot as plt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from autodb.reports.figures import FONT, PALETTE

FIGURES = Path(__file__).parent.parent / "figures"
WIDTH_IN = 5.8
INK, MUTED, RULE = PALETTE["ink"][0], PALETTE["muted"][0], PALETTE["rule"][0]
RECORDING, SIMULATION = PALETTE["recording"][0], PALETTE["simulation"][0]
CORRECTED, WARN, SHADE = PALETTE["corrected"][0], PALETTE["warn"][0], PALETTE["shade"][0]
CARD = PALETTE["card"][0]

RC: Any = {
    "svg.fonttype": "none",
    "svg.hashsalt": "autodb",
    "font.size": 10,
    "text.color": INK,
    "axes.edgecolor": MUTED,
    "axes.labelcolor": INK,
    "axes.titlecolor": INK,
    "axes.titlesize": 10,
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.linewidth": 0.8,
    "axes.grid": True,
    "axes.grid.axis": "y",
    "grid.color": RULE,
    "grid.linewidth": 0.7,
    "axes.axisbelow": True,
    "axes.formatter.useoffset": False,
    "axes.unicode_minus": True,
    "xtick.color": MUTED,
    "ytick.color": MUTED,
    "xtick.labelcolor": MUTED,
    "ytick.labelcolor": MUTED,
    "lines.linewidth": 1.1,
    "legend.frameon": False,
    "legend.fontsize": 9,
    "figure.facecolor": "none",
    "axes.facecolor": "none",
    "savefig.facecolor": "none",
}


@contextmanager
def drawn(
    name: str,
    *,
    height_in: float,
    rows: int = 1,
    columns: int = 1,
    width_in: float = WIDTH_IN,
    share_x: bool = False,
) -> Iterator[list[Axes]]:
    """Give the axes of a new figure, and write it as docs/figures/NAME.svg."""  # fmt: skip
    with mpl.rc_context(RC):
        figure, axes = plt.subplots(
            rows, columns, figsize=(width_in, height_in), sharex=share_x, squeeze=False,
            layout="constrained",
        )  # fmt: skip
        yield list(axes.ravel())
        text = svg(figure)
        plt.close(figure)
    (FIGURES / f"{name}.svg").write_text(text, encoding="utf-8")


def legend(axes: Axes, *, columns: int = 3) -> None:
    """Put the legend above the plot, at its right end; the title stands at the left."""
    axes.legend(
        loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=columns, borderaxespad=0.1,
        handlelength=1.4, columnspacing=1.2,
    )  # fmt: skip


def svg(figure: Figure) -> str:
    """Return a figure as SVG: no date, two decimals, the palette's tones as variables."""
    buffer = io.StringIO()
    figure.savefig(buffer, format="svg", metadata={"Date": None, "Creator": None})
    text = re.sub(r"<[^>]+>", _rounded, buffer.getvalue())
    text = re.sub(
        r"font: ([\d.]+)px [^;\"]+", rf"font: \1px {FONT.replace(chr(34), chr(39))}", text
    )
    text = re.sub(r"(<g clip-path=\"[^\"]+\")>\n((?:\s*<use [^>]+>\n)+)", _styled_once, text)
    for name, (light, _) in PALETTE.items():
        text = text.replace(light, f"var(--{name}, {light})")
    return text.replace("<defs>", f"{_tones()}\n <defs>", 1)


def _rounded(tag: re.Match[str]) -> str:
    """Return a tag with two decimals; what is written between tags stays."""
    return re.sub(r"\d+\.\d{3,}", lambda m: f"{float(m[0]):.2f}", tag[0])


def _styled_once(match: re.Match[str]) -> str:
    """Give the style that all marks of a cloud repeat to their group."""
    marks = match[2]
    styles = set(re.findall(r" style=\"[^\"]*\"", marks))
    if len(styles) != 1:
        return match[0]
    (style,) = styles
    bare = re.sub(r"\s*<use", "<use", marks.replace(style, ""))
    return f"{match[1]}{style}>\n{bare}\n"


def _tones() -> str:
    light, dark = ("".join(f"--{n}:{p[i]};" for n, p in PALETTE.items()) for i in (0, 1))
    scheme = f"@media (prefers-color-scheme:dark){{:root{{{dark}}}}}"
    return f" <style>:root{{{light}}}{scheme}</style>"
