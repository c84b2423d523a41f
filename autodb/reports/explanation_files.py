"""Write an answer: corrected.csv, report.html, explanation.json, all or nothing.

Several recordings together have such a folder each, beside together.json and together.html. The
script of their plots lies beside the page, or for all of them beside together.html.
"""

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pyarrow as pa
from pyarrow import csv

from autodb.errors import UnusableInput
from autodb.explain.answer import Explained
from autodb.explain.several_recordings import ExplainedTogether
from autodb.files.targets import hidden, replace_by
from autodb.reports.explanation import render_explanation
from autodb.reports.together_page import recording_folders, render_together
from autodb.reports.written import LIBRARIES, below, contained, put_library, write_page
from autodb.wording import phrase

REPORT = "report.html"
FILES = frozenset({"corrected.csv", REPORT, "explanation.json"})
OF_SEVERAL = frozenset({"together.json", "together.html"})


def write_answer(explained: Explained, folder: Path, *, self_contained: bool = False) -> None:
    """Write the three files into ``folder``, which is replaced as a whole.

    ``self_contained``: with the script of plots in the page. Raises UnusableInput when ``folder``
    is a file or holds anything but an earlier answer.
    """

    def write(new: Path) -> None:
        page = _write(explained, new)
        write_page(new / REPORT, page, self_contained=self_contained)

    _replace(folder, write, _is_answer)


def write_together(
    explained: Sequence[Explained],
    found: ExplainedTogether,
    folder: Path,
    *,
    self_contained: bool = False,
) -> None:
    """Write what several recordings say, each by itself and together, into ``folder``.

    A recording's own folder is called after it, with its number. ``self_contained`` as for one;
    raises what ``write_answer`` does.
    """

    def write(new: Path) -> None:
        for name, one in zip(recording_folders(found), explained, strict=True):
            (new / name).mkdir()
            page = _write(one, new / name)
            page = contained(page) if self_contained else below(page)
            (new / name / REPORT).write_text(page, encoding="utf-8")
        text = found.model_dump_json(indent=1)
        (new / "together.json").write_text(text + "\n", encoding="utf-8")
        (new / "together.html").write_text(render_together(found), encoding="utf-8")
        if not self_contained:
            put_library(new)

    _replace(folder, write, _is_of_several)


def _is_answer(folder: Path) -> bool:
    return all(p.name in FILES or p.match(LIBRARIES) for p in folder.iterdir())


def _is_of_several(folder: Path) -> bool:
    inside = list(folder.iterdir())
    others = [p for p in inside if p.name not in OF_SEVERAL and not p.match(LIBRARIES)]
    return all(p.is_dir() and _is_answer(p) for p in others)


def check_folder(folder: Path, *, several: bool = False) -> None:
    """Refuse a folder whose place no answer, of one recording or of several, may take.

    Raises UnusableInput when it is a file or holds anything but an earlier answer.
    """
    _check(folder.resolve(), _is_of_several if several else _is_answer)


def _check(folder: Path, ours: Callable[[Path], bool]) -> None:
    if folder.exists() and not folder.is_dir():
        raise UnusableInput(phrase("{folder}: is a file; --out needs a folder", folder=folder))
    if folder.is_dir() and not ours(folder):
        raise UnusableInput(
            phrase(
                "{folder}: holds other files, it would be replaced; give a new --out", folder=folder
            )
        )


def _replace(folder: Path, write: Callable[[Path], None], ours: Callable[[Path], bool]) -> None:
    """Put a folder that ``write`` fills in the place of an earlier answer, or of nothing."""
    folder = folder.resolve()
    folder.parent.mkdir(parents=True, exist_ok=True)
    with hidden(folder) as new:
        _check(folder, ours)
        new.mkdir()
        write(new)
        replace_by(new, folder)


def _write(explained: Explained, folder: Path) -> str:
    """Write table and answer, and return the page."""
    columns = {name: np.asarray(values) for name, values in explained.rows.items()}
    csv.write_csv(pa.table(columns), folder / "corrected.csv")
    text = explained.explanation.model_dump_json(indent=1)
    (folder / "explanation.json").write_text(text + "\n", encoding="utf-8")
    return render_explanation(explained)
