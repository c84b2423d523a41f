"""What comes back: frozen results with their numbers as tables, as plain data, and as a page."""

import html
from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from autodb.files.targets import check_target

if TYPE_CHECKING:
    import pandas as pd

HEIGHT_PX = 640
"""Of a page inside a notebook. Chosen."""


@dataclass(frozen=True)
class ResultPage:
    """A page that loads nothing from outside: a notebook shows it, ``save`` writes it."""

    page: str = field(repr=False)

    @property
    def html(self) -> str:
        """The page with the script of its plots in it."""
        from autodb.reports.written import contained

        return contained(self.page)

    def save(self, path: str | Path, *, self_contained: bool = False) -> Path:
        """Write the page to a file FILE.html, which is replaced, and return its path.

        The script of its plots is written beside it, ``self_contained``: into it. Raises
        UnusableInput for a path that is none of a page.
        """
        from autodb.reports.written import write_page

        target = Path(path)
        check_target(target, suffix=".html", option="path")
        write_page(target, self.page, self_contained=self_contained)
        return target

    def _repr_html_(self) -> str:
        page = html.escape(self.html)
        return f'<iframe srcdoc="{page}" style="width:100%;height:{HEIGHT_PX}px;border:0"></iframe>'


class Result(ABC):
    """An answer: ``to_pandas`` its rows, ``to_dict`` all of it as plain data."""

    @abstractmethod
    def to_pandas(self) -> "pd.DataFrame":
        """Return the rows of the answer."""

    @abstractmethod
    def to_dict(self) -> dict[str, Any]:
        """Return the answer as plain data, as ``--json`` of the command prints it."""

    def _printed(self) -> "pd.DataFrame":
        """Return what a terminal and a notebook show of the answer."""
        return self.to_pandas()

    def __repr__(self) -> str:
        """Return its table as pandas prints it: what holds traces would fill screens."""
        return f"{type(self).__name__}\n{self._printed()!r}"

    def _repr_html_(self) -> str:
        return str(self._printed().to_html())


def plain(answer: Any) -> Any:
    """Return a dataclass of an answer as plain data."""
    from pydantic import TypeAdapter

    return TypeAdapter(type(answer)).dump_python(answer, mode="json")
