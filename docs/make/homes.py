"""The table of where each effect is kept once it is confirmed, read off the terms themselves."""

from autodb.terms.homes import KEPT
from autodb.terms.vocabulary import all_terms, effect_called, vocabulary

BEGIN, END = "<!-- homes: made by python -m docs.make -->\n", "<!-- end of homes -->\n"
FOUND = {"machine": "the effort of an axis", "recording": "any"}
"""What an effect is found in, by where it belongs; all others in forces."""
HEAD = "| cause | found in | kept in | what changes |\n|---|---|---|---|"


def table() -> str:
    """Return a row for each effect, in the order of the places."""
    names: dict[str, list[str]] = {home: [] for home in KEPT}
    for name in sorted(vocabulary()):
        names[effect_called(name).belongs_to].append(name)
    return "\n".join([HEAD, *(_row(name) for some in names.values() for name in some)])


def _row(name: str) -> str:
    home = effect_called(name).belongs_to
    place, changes = KEPT[home]
    law = [number for term in all_terms() if term.name == name for number in term.in_law]
    numbers = f": {', '.join(f'`{number}`' for number in law)}" if law else ""
    cells = (f"`{name}`", FOUND.get(home, "forces"), f"{place}{numbers}", changes)
    return f"| {' | '.join(cells)} |"


def filled(page: str) -> str:
    """Return ``page`` with the table between its two comments."""
    before, rest = page.split(BEGIN)
    _, after = rest.split(END)
    return f"{before}{BEGIN}\n{table()}\n\n{END}{after}"
