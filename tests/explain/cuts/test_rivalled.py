"""A law of which white rows are not sure is not said surely, in a published table."""

from autodb.explain.engine.plain.odds import UNSURE
from autodb.proofs.cases.tables.table_cases import table_specs, tabled_case
from autodb.proofs.runs.tables.table_answers import explained_table

WORN = "injected/bartarya/tool_wear/strong/refitted 1"
"""Wear in turned steel; the simulation was refitted with it, so that all its terms are off."""
BENT = "injected/aouici/tool_wear/strong/refitted 4"
"""The same in hard turning; a band of speeds does nearly as well as the size effect there."""


def test_what_a_family_rivals_is_not_said_surely() -> None:
    spec = next(one for one in table_specs() if one.name == WORN)
    for answer in explained_table(tabled_case(spec)).values():
        sure = {one.term: one.confidence for one in answer.entries if one.kind == "missing"}
        assert 0.5 < sure["tool_wear"] <= UNSURE
        assert max(sure.values()) <= UNSURE


def test_what_plain_rows_alone_are_sure_of_is_not_said_surely() -> None:
    """A size effect that nobody put there was 98 % sure by plain rows, and 71 % by white ones."""
    spec = next(one for one in table_specs() if one.name == BENT)
    for answer in explained_table(tabled_case(spec)).values():
        sure = {one.term: one.confidence for one in answer.entries if one.kind == "missing"}
        assert sure["tool_wear"] > UNSURE
        assert sure.get("size_effect", 0.0) <= UNSURE
