"""Material cards: tables are read and written, and a posterior gives its card back."""

import csv
import io
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from autodb.cutting import kienzle, shear
from autodb.cutting.kienzle import ViewRange
from autodb.errors import UnusableInput
from autodb.fitting.gaussian import NORMAL_95
from autodb.pairs.card import SHAPE, Bounded, KienzleCard, kienzle_card, linear_coefficients
from autodb.pairs.cards import COLUMNS, cards_as_csv, read_cards
from autodb.pairs.handbook.conventional import (
    along_lines,
    material_named,
    posterior_of_material,
)
from autodb.pairs.prior import any_metal, of_card
from autodb.standard.writing import write_once

K_SHARE = 0.02
"""k_c1.1 of a card, of the posterior it leaves, and of that posterior's card: within this share."""
M_OFF = 0.02
"""m_c the same: the law's force bends a little over the chips of a card."""

HEADER = "material,k_c1.1,k_c1.1_unit,m_c,rake_deg,lower,upper,source"
GOOD = f"{HEADER}\nC45,2.1,kN/mm²,0.18,6,1.8,2.4,table\nbrass,780,MPa,0.2,0,700,870,book\n"


def _card(k_c11: float, m_c: float, at: ViewRange | None = None) -> KienzleCard:
    bounds = Bounded(k_c11, 0.85 * k_c11, 1.15 * k_c11)
    return KienzleCard("a", bounds, m_c, (m_c - 0.03, m_c + 0.03), at or ViewRange(), "test")


def _written(tmp_path: Path, text: str) -> Path:
    path = tmp_path / "cards.csv"
    path.write_text(text, "utf-8")
    return path


def test_a_table_is_read_in_its_units(tmp_path: Path) -> None:
    steel, brass = read_cards(_written(tmp_path, GOOD))
    assert steel.k_c11 == Bounded(2100.0, 1800.0, 2400.0)
    assert (steel.m_c, steel.m_c_bounds, steel.source) == (0.18, None, "table")
    assert steel.at == ViewRange(rake_rad=float(np.radians(6.0)))
    assert brass.k_c11.value == 780.0
    assert_allclose(steel.card.tangential, 2100 * steel.card.thickness_mm**0.82)
    assert steel.card.shape == SHAPE


@pytest.mark.parametrize("unit", ["kN/mm2", "GPa", "kN/mm²", "kN/mm^2"])
def test_the_shop_s_names_of_units_are_known(tmp_path: Path, unit: str) -> None:
    steel = read_cards(_written(tmp_path, GOOD.replace("kN/mm²", unit)))[0]
    assert_allclose(steel.k_c11.value, 2100.0)


def test_what_is_written_reads_back(tmp_path: Path) -> None:
    at = ViewRange(0.02, 0.2, 180.0, float(np.radians(-6.0)))
    cards = (_card(1234.56, 0.21, at), *read_cards(_written(tmp_path, GOOD)))
    path = tmp_path / "again.csv"
    assert write_once(cards_as_csv(cards), path)
    assert not write_once(cards_as_csv(cards), path)
    again = read_cards(path)
    assert [card.material for card in again] == ["a", "C45", "brass"]
    for one, other in zip(cards, again, strict=True):
        assert_allclose(other.card.tangential, one.card.tangential, rtol=1e-5)
        assert_allclose(
            (other.card.level, other.card.shape, other.at.rake_rad, other.at.speed_m_min),
            (one.card.level, one.card.shape, one.at.rake_rad, one.at.speed_m_min), rtol=1e-4,
        )  # fmt: skip
    with pytest.raises(UnusableInput, match="is there already and differs"):
        write_once(cards_as_csv(cards[:1]), path)


@pytest.mark.parametrize("name", ["=cmd|' /C calc'!A0", "+1+1", "-x", "@SUM(1)", "\t=1", "'=1"])
def test_a_material_that_is_a_formula_is_written_as_text_and_reads_back(
    tmp_path: Path, name: str
) -> None:
    card = replace(_card(1234.56, 0.21, ViewRange()), material=name, source=name)
    text = cards_as_csv([card])
    (row,) = csv.DictReader(io.StringIO(text))
    assert (row["material"], row["source"]) == (f"'{name}", f"'{name}")
    (again,) = read_cards(_written(tmp_path, text))
    assert (again.material, again.source) == (name, name)


@pytest.mark.parametrize("k_c11", [600.0, 3500.0])
@pytest.mark.parametrize("m_c", [0.05, 0.17, 0.3])
@pytest.mark.parametrize("rake_deg", [-6.0, 10.0])
def test_a_card_comes_back_from_the_posterior_that_it_leaves(
    k_c11: float, m_c: float, rake_deg: float
) -> None:
    card = _card(k_c11, m_c, ViewRange(rake_rad=float(np.radians(rake_deg))))
    back = kienzle_card("a", of_card(card.card).law, card.at, source="belief")
    assert_allclose(back.k_c11.value, k_c11, rtol=K_SHARE)
    assert_allclose(back.m_c, m_c, atol=M_OFF)
    assert back.m_c_bounds is not None
    assert back.m_c_bounds[0] < m_c < back.m_c_bounds[1]

    # Bounds: the card's and, at chips of 1 mm, what is open of the exponent; half as wide again
    width = np.log(back.k_c11.upper / back.k_c11.lower) / np.log(1.15 / 0.85)
    assert 1.0 < width < 1.5


def test_a_posterior_comes_back_from_the_card_that_it_makes() -> None:
    posterior, at = posterior_of_material("C45"), ViewRange()
    card = kienzle_card("C45", posterior.law, at, source="belief")
    again = kienzle_card("C45", of_card(card.card).law, at, source="card")
    assert_allclose(again.k_c11.value, card.k_c11.value, rtol=K_SHARE)
    assert_allclose(again.m_c, card.m_c, atol=M_OFF)
    view = kienzle.kienzle(posterior.law, at)
    assert_allclose((card.k_c11.value, card.m_c), view.posterior.mean)
    sd = np.sqrt(view.posterior.covariance[0, 0]) / view.posterior.mean[0]
    assert_allclose(np.log(card.k_c11.upper / card.k_c11.value), NORMAL_95 * sd)


def test_little_knowledge_leaves_a_card_that_can_be_read(tmp_path: Path) -> None:
    card = kienzle_card("any metal", any_metal().law, ViewRange(), source="nothing known")
    assert 0.0 < card.k_c11.lower < card.k_c11.value / 3.0
    (back,) = read_cards(_written(tmp_path, cards_as_csv([card])))
    assert_allclose(back.k_c11.upper, card.k_c11.upper, rtol=1e-5)


def test_no_card_says_that_the_specific_force_grows_with_the_chip() -> None:
    """Titanium's lines alone have a ratio past 1 in thick chips; in thin ones they have a card."""
    stated = material_named("Ti6Al4V").shear
    assert stated is not None
    law = along_lines(stated).law
    with pytest.raises(UnusableInput, match=r"'Ti6Al4V': m_c is -0\.\d+ over chips of 0.05 to 0.4"):
        kienzle_card("Ti6Al4V", law, ViewRange(), source="belief")
    thin = kienzle_card("Ti6Al4V", law, ViewRange(0.02, 0.15), source="belief")
    assert 0.1 < thin.m_c < 0.3


def test_linear_edges_have_bounds_and_follow_the_law() -> None:
    law, at = posterior_of_material("Al 7075").law, ViewRange(thinnest_mm=0.1)
    found = linear_coefficients(law, at)
    assert all(one.lower < one.value < one.upper for one in found.values())
    edge = at.edge
    along, across, _ = shear.per_width(law.mean, edge)
    line = {name: one.value for name, one in found.items()}
    # 2 %: how far the law is off the two lines that are fitted to it over these chips
    assert_allclose(line["K_tc"] * edge.thickness_mm + line["K_te"], along, rtol=0.02)
    assert_allclose(line["K_rc"] * edge.thickness_mm + line["K_re"], across, rtol=0.02)


ROW = "C45,2.1,kN/mm²,0.18,6,1.8,2.4,table"
BAD = [
    (GOOD.replace(",m_c", ""), "column 'm_c' is missing"),
    (GOOD.replace("m_c", "mc"), "unknown column 'mc' (did you mean m_c"),
    (GOOD.replace("upper,source", "upper"), "column 'source' is missing"),
    (f"{HEADER.replace(',lower', '')}\nC45,2.1,kN/mm²,0.18,6,2.4,table\n",
     "column 'lower', row 1: is empty; use"),
    (GOOD.replace("2.1,kN/mm²,0.18,6,1.8,2.4", "1.5,N/mm²,0.25,6,1.4,1.6"),
     "column 'k_c1.1', row 1: is 1.5 N/mm², and metals have 100 to 10000; use another"),
    (GOOD.replace("780,MPa", "-780,MPa"), "column 'k_c1.1', row 2: is -780; use a number above 0"),
    (GOOD.replace("780,MPa", ",MPa"), "column 'k_c1.1', row 2: is empty"),
    (GOOD.replace("780,MPa", "x,MPa"), "column 'k_c1.1', row 2: 'x' is not a number"),
    (GOOD.replace("0.18", "0.95"), "column 'm_c', row 1: is 0.95; use 0 to 0.9"),
    (GOOD.replace("0.18", "-0.1"), "column 'm_c', row 1: is -0.1; use 0 to 0.9"),
    (GOOD.replace("1.8,2.4", "2.2,2.4"), "column 'lower', row 1: is on the wrong side of k_c1.1"),
    (GOOD.replace("1.8,2.4", "1.8,2.0"), "column 'upper', row 1: is on the wrong side of k_c1.1"),
    (GOOD.replace("kN/mm²", "N"), "column 'k_c1.1_unit', row 1: unit 'N' cannot become N/mm²"),
    (GOOD.replace("kN/mm²", "ksomething"), "column 'k_c1.1_unit', row 1: unknown unit"),
    (GOOD.replace("kN/mm²", "raw"), "column 'k_c1.1_unit', row 1: is 'raw'"),
    (GOOD.replace("brass", "C45"), "column 'material', row 2: stands in row 1 already"),
    (GOOD.replace("brass", ""), "column 'material', row 2: is empty"),
    (GOOD.replace(",0.18,6,", ",0.18,86,"), "column 'rake_deg', row 1: is 86; use -60 to 60"),
    (f"{HEADER},thinnest_mm\n{ROW},0.5\n", "column 'thinnest_mm', row 1: leaves chips of 0.5"),
    (f"{HEADER},m_c_lower\n{ROW},0.1\n", "column 'm_c_upper', row 1: is empty"),
    (f"{HEADER},m_c_lower,m_c_upper\n{ROW},0.2,0.3\n", "column 'm_c_lower', row 1: is on the"),
    (f"{HEADER}\n", "no rows"),
]  # fmt: skip


@pytest.mark.parametrize(("text", "line"), BAD)
def test_bad_tables_are_refused_by_file_column_and_row(
    tmp_path: Path, text: str, line: str
) -> None:
    path = _written(tmp_path, text)
    with pytest.raises(UnusableInput) as refused:
        read_cards(path)
    assert str(path) in str(refused.value)
    assert line in str(refused.value)
    assert "\n" not in str(refused.value)


def test_a_file_that_is_not_there_is_refused(tmp_path: Path) -> None:
    with pytest.raises(UnusableInput, match="no such file"):
        read_cards(tmp_path / "none.csv")


def test_the_docs_list_the_columns() -> None:
    text = (Path(__file__).parents[2] / "docs" / "formats.md").read_text("utf-8")
    section = text.split("## Material cards")[1].split("\n## ")[0]
    for name in COLUMNS:
        assert f"`{name}`" in section


def test_a_card_without_bounds_is_taken_as_a_quarter_off_and_says_so(tmp_path: Path) -> None:
    text = "material,k_c1.1,k_c1.1_unit,m_c,rake_deg,source\nC45,2000,N/mm²,0.2,6,table\n"
    (card,) = read_cards(_written(tmp_path, text))
    assert (card.k_c11.lower, card.k_c11.upper) == (1500, 2500)
    assert card.source == "table; no bounds stated: taken as ± 25 %"
