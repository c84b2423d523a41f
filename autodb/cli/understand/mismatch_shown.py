"""What is printed of a mismatch: its lines, its places, its numbers, and what came of it."""

from typing import TYPE_CHECKING

from autodb.cli._common import table
from autodb.cli._reader import headed, shown_again
from autodb.files.channels import unit_of
from autodb.wording import (
    day,
    listed,
    listed_stretches,
    localized,
    msgid,
    phrase,
    shop_amount,
)

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rich.table import Table

    from autodb.store.models import Mismatch

ALL_ALONG = (msgid("all along the recording"), msgid("all along the recordings"))


def kept_of_mismatch(row: "Mismatch") -> "Iterator[tuple[str, str]]":
    """Return what is kept of a mismatch, a line each: what it is and its text."""
    from autodb.agent.rows.mismatches import decision_words, found_words
    from autodb.terms.homes import kept_words
    from autodb.terms.vocabulary import effect_called

    if found := found_words(row):
        yield msgid("found in: {what}"), found
    yield (
        msgid("term: {what}"),
        phrase(
            "{term} ({kind}, {percent} % sure)",
            term=row.term,
            kind=phrase(row.kind),
            percent=f"{100 * row.confidence:.0f}",
        ),
    )
    yield msgid("statement: {what}"), mismatch_statement(row)
    all_along = phrase(ALL_ALONG[bool(row.further)])
    yield msgid("where: {what}"), listed(_places(row), "; ") or all_along
    if row.variables:
        yield msgid("depends on: {what}"), ", ".join(row.variables)
    if row.alternatives:
        yield msgid("or: {what}"), ", ".join(row.alternatives)
        none = phrase("no simple move or cut separates them")
        apart = shown_again(row.to_tell_apart) if row.to_tell_apart else none
        yield msgid("to tell them apart: {what}"), apart
    status = status_words(row)
    if row.decided_at:
        status = phrase("{decided} on {day}", decided=status, day=day(row.decided_at))
    yield msgid("status: {what}"), status
    for decision in row.decisions:
        yield msgid("decision: {what}"), decision_words(decision)
    if row.lot is not None:
        yield msgid("lot: {what}"), row.lot
    yield from ((msgid("made: {what}"), text) for text in _made(row))
    kept = kept_words(row.confirmed_term or row.term, row.channel)
    yield msgid("once confirmed: {what}"), kept
    one = effect_called(row.confirmed_term or row.term)
    said = phrase("{said} ({source})", said=shown_again(one.check), source=one.check_source)
    yield msgid("advice: {what}"), said


def mismatch_statement(row: "Mismatch") -> str:
    """Return its statement in the reader's language."""
    from autodb.reports.explanation import statement_words

    return listed(map(shown_again, statement_words(row.statement)), " ")


def _made(row: "Mismatch") -> "Iterator[str]":
    """Return the versions that hold a mismatch; those that were taken back say so."""
    for model in row.models:
        said = phrase(
            "{channel} version {version} (model {number})",
            channel=model.channel, version=model.version, number=model.id,
        )  # fmt: skip
        yield _or_back(said, model.undone_at)
    for one in row.calibrations:
        said = phrase(
            "calibration of {axis} version {version} (calibration {number})",
            axis=one.axis, version=one.version, number=one.id,
        )  # fmt: skip
        yield _or_back(said, one.undone_at)
    for held in row.parameters_of_pairs:
        said = phrase(
            "{pair} version {version} (parameters {number})",
            pair=f"{held.pair.material.name} / {held.pair.tool.name}",
            version=held.version, number=held.id,
        )  # fmt: skip
        yield _or_back(said, held.undone_at)


def _or_back(said: str, undone_at: str | None) -> str:
    """Return what was made, and when it was taken back, if it was."""
    if undone_at is None:
        return said
    return phrase("{said}, taken back on {day}", said=said, day=day(undone_at))


def _places(row: "Mismatch") -> "Iterator[str]":
    """Return the stretches and regimes in which a mismatch sits."""
    place = msgid("from {low} to {high} s")
    if row.further:
        place = msgid("of all cuts in the order of time {low} to {high}")
    elif row.recording.kind == "cuts":
        place = msgid("cuts {low} to {high}")
    for low, high, count in listed_stretches(row.intervals or ()):
        said = phrase(place, low=localized(f"{low:g}"), high=localized(f"{high:g}"))
        yield (said if count == 1 else phrase("{count} stretches {where}", count=count, where=said))
    for one in row.regime or ():
        scale, unit = shop_amount(1.0, unit_of(one["signal"]) or "")
        ends = [localized(f"{scale * one[end]:.4g}") for end in ("low", "high")]
        share = f"{100 * one['share']:.0f}"
        holds = phrase("{share} % of it", share=share)
        if one.get("rows") is not None:
            holds = phrase(
                "{share} % of the squared error in {rows} % of the rows",
                share=share, rows=f"{100 * one['rows']:.0f}",
            )  # fmt: skip
        span = phrase("{low} to {high}", low=ends[0], high=ends[1])
        where = f"{one['signal']} {span} {unit}".strip()
        yield listed([where, holds])


def numbers_table(row: "Mismatch") -> "Table":
    """Return its parameters with their intervals, in the reader's units."""
    from autodb.reports.explanation import parameter_words

    rows = table(
        phrase("Its numbers"),
        *(phrase("parameter"), headed(phrase("value")), headed(phrase("95 % from"))),
        *(headed(phrase("to")), phrase("unit")),
    )
    for name, value in row.parameters.items():
        scale, unit = shop_amount(1.0, value["unit"])
        numbers = (localized(f"{scale * value[key]:.4g}") for key in ("value", "low", "high"))
        rows.add_row(parameter_words(name), *numbers, unit)
    return rows


def status_words(row: "Mismatch") -> str:
    """Return what was decided on a mismatch, as what, and by whom."""
    from autodb.agent.rows.mismatches import decided_words

    other = row.confirmed_term if row.confirmed_term != row.term else None
    return decided_words(row.status, other, row.decided_by)
