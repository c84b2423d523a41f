"""Pages on the disk: the script that draws their plots lies once beside them, or in the page."""

from html import escape
from pathlib import Path

from plotly.offline import get_plotlyjs, get_plotlyjs_version

from autodb.files.targets import write_text
from autodb.wording import msgid, phrase

LIBRARY = f"plotly-{get_plotlyjs_version()}.min.js"
"""The script beside the pages of a folder; pages of another version have another beside them."""
LIBRARIES = "plotly-*.min.js"
MISSING = msgid(
    "Put {file} beside this page to see its plots: it was written with the page. With "
    "--self-contained it is in the page."
)


def library_tag(place: str = "") -> str:
    """Return what loads the script of plots from beside a page, or from another place."""
    missing = escape(phrase(MISSING, file=LIBRARY))
    return f'<script src="{place}{LIBRARY}" data-missing="{missing}"></script>'


def contained(page: str) -> str:
    """Return a page with the script of its plots in it: it needs no file but itself."""
    return page.replace(library_tag(), f"<script>{get_plotlyjs()}</script>", 1)


def below(page: str) -> str:
    """Return a page that finds the script of its plots in the folder above its own."""
    return page.replace(library_tag(), library_tag("../"), 1)


def put_library(folder: Path) -> None:
    """Write the script of plots into a folder, unless it is there."""
    path, script = folder / LIBRARY, get_plotlyjs()
    if not (path.is_file() and path.read_bytes() == script.encode()):
        write_text(path, script)


def write_page(target: Path, page: str, *, self_contained: bool = False) -> None:
    """Write a page, and the script of its plots beside it or in it; each whole or not at all.

    Earlier files of these names are replaced.
    """
    if self_contained:
        page = contained(page)
    elif library_tag() in page:
        put_library(target.parent)
    write_text(target, page)
