"""What to check on the machine for each effect that explain can name: data, read here."""

from functools import cache
from importlib.resources import as_file, files

from pydantic import Field, RootModel

from autodb.files.toml import Section, read_toml


class Advice(Section):
    """One sentence of what to check, and where that is from."""

    check: str = Field(pattern=r"^Check .+; .+[^.]\.$")
    source: str = Field(min_length=1)


class _Book(RootModel[dict[str, Advice]]):
    """Advice by term."""


@cache
def book() -> dict[str, Advice]:
    """Return the advice of every term."""
    with as_file(files("autodb.explain.answer") / "advice.toml") as path:
        return read_toml(path, _Book).root


def advice(term: str) -> Advice:
    """Return what to check where a term was found; raises KeyError for what is no term."""
    return book()[term]
