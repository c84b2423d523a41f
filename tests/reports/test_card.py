"""The calibration card: its figures are those of the record, and it says what is not sensed."""

import csv
import html
import re
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray
from sqlalchemy import func, select

from autodb.agent.rows.calibrations import current_calibrations
from autodb.agent.sense.calibrating import known_forces
from autodb.assets import kit
from autodb.cli import run
from autodb.fitting.gaussian import NORMAL_95
from autodb.records import source as records
from autodb.records.tables import CutTable
from autodb.reports import amounts
from autodb.reports.card import axis_card
from autodb.reports.card.axis_figures import at_middle, rules, trueness
from autodb.reports.card.conditions import condition_scatter, condition_words, movement
from autodb.reports.card.files import BROWSERS
from autodb.sensing.ranges import calibration
from autodb.sensing.ranges.forms import OF_CURRENT_SPEED, FittedForm, MeasuredCuts
from autodb.sensing.ranges.outliers import Outlier, numbers, outlier_sentences
from autodb.sensing.ranges.points import COMPONENT_OF_AXIS, calibration_points
from autodb.store import models, open_store
from tests.conftest import Cli
from tests.helpers.explanations import loaded, readable
from tests.helpers.lathe_tables import protocol_of

Array = NDArray[np.float64]
Change = Callable[[list[dict[str, str]]], None]


@pytest.fixture
def cuts(sample_jobs: Path) -> Path:
    return sample_jobs / "stepped_shaft" / "recordings" / "standard-cuts.csv"


def text_of(file: Path) -> str:
    """Return what the page says, without its plots."""
    return html.unescape(readable(file.read_text(encoding="utf-8")))


def changed(cuts: Path, change: Change) -> Path:
    """Return a copy of the cut table with ``change`` made to its rows."""
    with cuts.open() as file:
        rows = list(csv.DictReader(file))
    change(rows)
    path = Path("changed.csv")
    with path.open("w", newline="") as file:
        writer = csv.DictWriter(file, rows[0].keys())
        writer.writeheader()
        writer.writerows({**row, "cut": n} for n, row in enumerate(rows, start=1))
    return path


def table_of(path: Path) -> CutTable:
    read = records.read(path)
    assert isinstance(read, CutTable)
    return read


def test_the_figures_of_a_machines_card_are_those_of_the_record(cli: Cli, cuts: Path) -> None:
    assert cli("init").code == 0
    assert cli("machine", "add", "lathe-1").code == 0
    assert cli("import", cuts, "--machine", "lathe-1").code == 0
    done = cli("calibrate", "--machine", "lathe-1", "--card", "card.html")
    assert done.code == 0
    assert "card: card.html" in done.out
    page = Path("card.html").read_text(encoding="utf-8")
    assert not loaded(page)
    said = text_of(Path("card.html"))
    store = open_store("sqlite:///autodb.sqlite3")
    with store.reading() as session:
        for axis in ("x", "z", "spindle"):
            (row,) = current_calibrations(session, 1, axis)
            _is_stated(row, said)
    store.close()
    assert "force.x, where the operation is 'turn' axis x stands still" in said
    assert "force.z, where the operation is 'face' axis z stands still" in said
    assert not list(Path().glob(".card*"))


def _is_stated(row: models.CalibrationVersion, said: str) -> None:
    scores = row.scores
    assert row.verdict in said
    assert f"{scores['r_squared_low']:.3f} to {scores['r_squared_high']:.3f}" in said
    assert amounts.quantity(scores["rmse"], row.unit).replace("\xa0", " ") in said
    low, high = row.current_low, row.current_high
    assert amounts.span(low, high, row.current_unit).replace("\xa0", " ") in said
    assert f"axis {row.axis}, version {row.version}" in said
    assert row.domain is not None
    for ends in (*row.domain["ranges"].values(), row.domain["target"]):
        scale = 60.0 if ends == row.domain["ranges"].get("feed_mm_s") else 1.0
        assert f" {scale * ends[0]:.4g} to {scale * ends[1]:.4g} " in said
    for near in row.domain["rivals"]:
        assert f"(weight {100.0 * near['weight']:.0f} %)" in said
    for name, error in (row.trials or {}).items():
        held = error is not None
        stated = amounts.quantity(error, row.unit) if held else "not determined by these cuts"
        assert f"{name} {stated}".replace("\xa0", " ") in said
    for number in row.transients:
        assert re.search(rf"set aside \(cut [^)]*\b{number:g}\b", said)
    for sentence in outlier_sentences([Outlier(**one) for one in row.outliers or ()]):
        assert sentence in said


def test_estimates_are_of_cuts_left_out(cuts: Path) -> None:
    table = table_of(cuts)
    for axis in COMPONENT_OF_AXIS:
        found = calibration.calibrate(table, axis)
        card = axis_card(found, table)
        assert_allclose(card.left_out_rmse, found.trials[found.form.label], rtol=1e-9)
        assert tuple(card.cut[card.sudden]) == found.transients
        fitted = found.form.value(found.coefficients, card.sensed)
        inside = np.sqrt(np.mean((card.target - fitted)[~card.sudden] ** 2))
        assert card.left_out_rmse > inside


def test_the_parts_of_one_cuts_error_add_up_to_what_is_sensed_with(cuts: Path) -> None:
    table = table_of(cuts)
    for axis in COMPONENT_OF_AXIS:
        found = calibration.calibrate(table, axis, reference_share=0.03)
        sensed = calibration_points(table, axis).sensed
        cut = at_middle(found, sensed)
        one = np.array([cut.current])
        rpm, feed, depth = (
            np.array([np.median(v)]) for v in (sensed.speed_rpm, sensed.feed_mm, sensed.depth_mm)
        )
        slopes = found.form.slopes(
            found.coefficients,
            MeasuredCuts(one, feed * rpm / 60.0, rpm, feed, depth, np.full(1, np.nan)),
        )[0]
        slopes = np.append(slopes, [1.0, 0.0])  # and no choice of the form within the range
        shared = slopes @ found.shared_covariance @ slopes
        assert_allclose(cut.shared**2, shared, rtol=1e-9)
        assert_allclose(cut.half, NORMAL_95 * np.sqrt(found.errors.cut_sd**2 + shared), rtol=1e-9)
        assert cut.references > 0.0


def test_a_slope_is_stated_with_an_error_that_holds() -> None:
    """Groups share an error: an interval that took rows for independent would be too narrow."""
    rng = np.random.default_rng(61)
    held = 0
    for _ in range(400):
        groups = np.repeat(np.arange(20), 4)
        estimate = 100.0 + 20.0 * groups + rng.standard_normal(80)
        target = 5.0 + 1.1 * estimate + (10.0 * rng.standard_normal(20))[groups]
        found = trueness(target, estimate, groups)
        assert found is not None
        held += abs(found.slope - 1.1) < 2.1 * found.slope_se  # t(19), 95 %
    assert 0.91 < held / 400 < 0.98


def test_a_refused_axis_is_said_and_one_without_current_too(cli: Cli, cuts: Path) -> None:
    rng = np.random.default_rng(62)

    def spoil(rows: list[dict[str, str]]) -> None:
        for row in rows:
            row["x.current.range"] = f"{1.0 + 0.05 * rng.standard_normal():.5f}"
            del row["x.current.air"], row["spindle.current.range"], row["spindle.current.air"]

    done = cli("calibrate", changed(cuts, spoil), "--card", "card.html")
    assert done.code == 0
    said = text_of(Path("card.html"))
    assert "force.x, in any cut axis x is not usable: R²" in said
    assert "X axis: not usable" in said
    assert "an axis without a calibration, in any cut no channel 'spindle.current'" in said
    assert "force.x, where" not in said
    assert "not stored" in said


def test_a_set_of_repeats_gives_its_split_and_what_moved(cli: Cli, cuts: Path) -> None:
    rng = np.random.default_rng(63)

    def repeat(rows: list[dict[str, str]]) -> None:
        alike = [dict(rows[8]) for _ in range(8)]
        other = [dict(rows[2]) for _ in range(3)]
        for row in (*alike, *other):
            scale = 1.0 + 0.02 * rng.standard_normal()
            for force in ("force.x", "force.y", "force.z"):
                row[force] = f"{float(row[force]) * scale:.5f}"
            rise = float(row["z.current.range"]) - float(row["z.current.air"])
            rise *= scale * (1.0 + 0.02 * rng.standard_normal())
            row["z.current.range"] = f"{float(row['z.current.air']) + rise:.6f}"
        rows[:] = [alike[0], *rows[2:8], *rows[9:], *alike[1:-1], *other, alike[-1]]

    path = changed(cuts, repeat)
    assert cli("calibrate", path, "--card", "card.html").code == 0
    said = text_of(Path("card.html"))
    table = table_of(path)
    card = axis_card(calibration.calibrate(table, "z"), table)
    name, sentences = card.repeats[0]
    assert name in said
    assert "8 repeats: reference and estimate" in sentences[0]
    for sentence in sentences:
        assert sentence in said
    assert re.search(r"variances (agree|differ) \(F [\d.]+, p ", said)
    assert re.search(r"means (agree|differ) \(t -?[\d.]+, p ", said)
    assert len(card.moved) == 3
    for sentence in card.moved:
        assert sentence in said
    assert "z.current.range − z.current.air" in card.moved[0]
    assert card.moved[1].startswith("z.current.air")


def test_many_cuts_are_named_by_number() -> None:
    assert numbers([1.0, 2.0, 7.0, 8.0, 9.0]) == "1, 2, 7 to 9"
    assert numbers(np.arange(2.0, 60.0, 2.0).tolist()).endswith("16 and 21 more")


def test_one_reference_for_all_repeats_splits_nothing() -> None:
    estimate = np.array([98.0, 101.0, 103.0])
    ((_, (line,)),) = condition_scatter(["a"] * 3, np.full(3, 100.0), estimate, "N")
    assert f"standard deviation of {np.std(estimate, ddof=1):.3g} N" in line
    assert condition_scatter(["a", "a", ""], np.arange(3.0), estimate, "N") == ()


def test_a_move_without_other_repeats_has_no_interval() -> None:
    signals = {"current": (np.array([1.0, 2.0, 1.2]), "A")}
    (line,) = movement(["a", "b", "a"], signals)
    assert "moved by +0.2 A" in line
    assert "the scatter is not known" in line
    assert movement(["a", "b", "c"], signals) == ()


def test_a_torque_also_follows_the_diameter(cuts: Path) -> None:
    """All made alike but for the work's diameter: one condition of a force, many of a torque."""
    table = table_of(cuts)
    alike = {
        name: np.full(len(table), table[name][0])
        for name in ("spindle.speed", "cutting.feed", "cutting.depth")
    }
    table = replace(table, channels={**table.channels, **alike})
    assert len(set(condition_words(table, None, with_diameter=False))) == 2  # turned and faced
    assert len(set(condition_words(table, None, with_diameter=True))) > 4
    unknown = {"cutting.feed": np.full(len(table), np.nan)}
    table = replace(table, channels={**table.channels, **unknown})
    assert set(condition_words(table, None, with_diameter=False)) == {""}


def test_cuts_of_a_protocol_go_by_their_names(cuts: Path) -> None:
    table = table_of(cuts)
    protocol = protocol_of(table)
    names = {cut.name for cut in protocol.cut}
    assert set(condition_words(table, protocol, with_diameter=False)) <= names | {""}
    forces = known_forces(table, protocol)
    found = calibration.calibrate(table, "z", force_N=forces["z"], reference_share=0.02)
    card = axis_card(found, table, force_N=forces["z"], protocol=protocol)
    assert card.middle.references > 0.0
    assert_allclose(card.left_out_rmse, found.trials[found.form.label], rtol=1e-9)


def test_rules_are_said_in_sentences() -> None:
    """Fuzzy rules over current and speed, of a torque that changes its slope with the speed."""
    rng = np.random.default_rng(64)
    current, rpm = rng.uniform(2.0, 20.0, 120), rng.uniform(500.0, 2500.0, 120)
    nothing = np.full(120, np.nan)
    sensed = MeasuredCuts(current, nothing, rpm, nothing, nothing, nothing)
    torque = 2.0 * current * (1.0 - rpm / 5000.0) + 0.2 * rng.standard_normal(120)
    law = OF_CURRENT_SPEED.fit(sensed, torque)
    made = rules(_calibration_with(law))
    assert len(made) == 4
    assert re.match(r"If current is low \(about .* A\) and spindle speed is low .*rpm", made[0])
    assert made[0].endswith(" N·m")


def _calibration_with(law: FittedForm) -> calibration.Calibration:
    file = kit("sample_jobs") / "stepped_shaft" / "recordings" / "standard-cuts.csv"
    found = calibration.calibrate(table_of(file), "spindle")
    return replace(found, form=law.form, coefficients=law.coefficients, covariance=law.covariance)


@pytest.mark.parametrize(
    ("target", "says"),
    [
        ("card.txt", "a card is FILE.html or FILE.pdf"),
        ("nowhere/card.html", "no such folder"),
        ("card.pdf", "or use --card card.html"),
    ],
)
def test_a_card_that_cannot_be_written_is_refused_before_anything_is_stored(
    refused: Callable[..., str], cuts: Path, monkeypatch: pytest.MonkeyPatch, target: str, says: str
) -> None:
    monkeypatch.setattr(shutil, "which", lambda _: None)
    for command in (["init"], ["machine", "add", "lathe-1"]):
        assert run(command) == 0
    assert says in refused("calibrate", cuts, "--machine", "lathe-1", "--card", target)
    store = open_store("sqlite:///autodb.sqlite3")
    with store.reading() as session:
        assert session.scalar(select(func.count()).select_from(models.StoredRecording)) == 0
    store.close()
    assert not Path(target).exists()


def test_a_browser_that_fails_leaves_the_earlier_card(
    refused: Callable[..., str], cuts: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(shutil, "which", lambda _: "/bin/false")
    Path("card.pdf").write_text("earlier")
    assert "did not print it" in refused("calibrate", cuts, "--card", "card.pdf")
    assert Path("card.pdf").read_text() == "earlier"
    assert not list(Path().glob(".card*"))


@pytest.mark.pages
@pytest.mark.skipif(not any(map(shutil.which, BROWSERS)), reason="no browser that prints")
def test_a_pdf_is_printed(cli: Cli, cuts: Path) -> None:
    assert cli("calibrate", cuts, "--card", "card.pdf").code == 0
    printed = Path("card.pdf").read_bytes()
    assert printed.startswith(b"%PDF")
    assert printed.count(b"/Type /Page\n") + printed.count(b"/Type /Page ") >= 4
