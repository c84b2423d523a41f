"""Choices of a person become the side file, and what they do not touch stays in it."""

import tomllib

import pytest

from autodb.errors import UnusableInput
from autodb.files.side import SideFile, stated_side
from autodb.records.proposed.choices import (
    ROWS,
    ColumnChoice,
    SideChoices,
    chosen_now,
    with_choices,
)
from autodb.records.proposed.written import side_text

SAID = {
    "csv": {"decimal": ",", "comment": "#"},
    "channels": {
        "t": {"row_in": "*", "step_s": 0.004},
        "x.current": {"column": "I1", "scale": 10.0, "unit": "A", "clips": True},
        "y.current": {"column": "I2", "kind": "rms"},
        "z.position": "Z",
    },
    "values": {"operation": {"Plandrehen": "face"}},
    "recording": {"work": "C45"},
    "tool": {"name": "carbide insert", "nose_radius_mm": 0.8},
}
COLUMNS = ("I1", "I2", "Z", "F", ROWS)


@pytest.fixture
def side() -> SideFile:
    """Return a side file that says more than can be chosen."""
    return stated_side(SAID, where="side")


def _chosen(side: SideFile, *others: ColumnChoice, **more: dict[str, str]) -> SideChoices:
    """Return the choices that a page sends where these were changed."""
    now = chosen_now(COLUMNS[:-1], side) | {one.column: one for one in others}
    return SideChoices(
        tuple(now.get(name, ColumnChoice(name)) for name in COLUMNS), text={}, **more
    )


def test_what_is_not_changed_stays(side: SideFile) -> None:
    made, anew = with_choices(side, _chosen(side))
    assert (made, anew) == (side, False)


def test_a_unit_and_a_sign_are_chosen_and_the_rest_of_the_channel_stays(side: SideFile) -> None:
    made, _ = with_choices(side, _chosen(side, ColumnChoice("I1", "x.current", "mA", turned=True)))
    spec = made.channels["x.current"]
    assert (spec.unit, spec.sign, spec.scale, spec.clips) == ("mA", -1, 10.0, True)
    assert made.model_copy(update={"channels": side.channels}) == side


def test_channels_are_exchanged_added_and_taken_away(side: SideFile) -> None:
    made, _ = with_choices(
        side,
        _chosen(side, ColumnChoice("I1", "y.current"), ColumnChoice("I2", "x.current"),
                ColumnChoice("Z"), ColumnChoice("F", "force.z", "kN"),
                ColumnChoice(ROWS, "t", "0,002")),
    )  # fmt: skip
    assert {name: spec.column for name, spec in made.channels.items()} == {
        "t": None, "y.current": "I1", "x.current": "I2", "force.z": "F",
    }  # fmt: skip
    assert made.channels["t"].step_s == 0.002
    assert made.channels["x.current"].kind is None  # was said of another channel


def test_another_way_to_read_it_has_its_columns_proposed_anew(side: SideFile) -> None:
    made, anew = with_choices(side, SideChoices(text={"decimal": "", "header_line": "3"}))
    assert anew
    assert (made.csv.decimal, made.csv.header_line, made.csv.comment) == (None, 3, "#")
    with pytest.raises(UnusableInput, match="header_line"):
        with_choices(side, SideChoices(text={"header_line": "three"}))


def test_operations_are_chosen_by_their_words(side: SideFile) -> None:
    words = {"Plandrehen": "", "Längsdrehen": "turn"}
    made, _ = with_choices(side, _chosen(side, operations=words))
    assert made.values.operation == {"Längsdrehen": "turn"}


def test_all_that_cannot_be_is_said_at_once(side: SideFile) -> None:
    wrong = ColumnChoice("F", "force.q"), ColumnChoice("Z", "z.positon")
    with pytest.raises(
        UnusableInput, match=r"'z\.positon' is not .*z\.position.*'force\.q' is not"
    ):
        with_choices(side, _chosen(side, *wrong))
    with pytest.raises(UnusableInput, match=r"'I1' and 'F' are both x\.current; take one"):
        with_choices(side, _chosen(side, ColumnChoice("F", "x.current")))
    with pytest.raises(UnusableInput, match="'soon' is no number"):
        with_choices(side, _chosen(side, ColumnChoice(ROWS, "t", "soon")))


def test_a_side_file_is_written_so_that_it_says_the_same(side: SideFile) -> None:
    text = side_text(side)
    assert stated_side(tomllib.loads(text), where="written") == side
    assert '"z.position" = "Z"' in text
