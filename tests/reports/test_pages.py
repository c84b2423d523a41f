"""The two reports: one file that loads nothing, says what was found, and keeps every peak."""

import base64
import json
import re
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from autodb.agent.learn.precision_history import LearningCurve
from autodb.explain.answer import Considered, Regime, Where
from autodb.files.units import shop_units
from autodb.forward.cut_figures import CutFigures
from autodb.forward.prediction import Interval
from autodb.reports import amounts, figures
from autodb.reports.explanation import (
    explanation_fragment,
    open_words,
    render_explanation,
    smaller_words,
)
from autodb.reports.explanation_plots import regime_words, where_words
from autodb.reports.page import (
    CalibrationPlot,
    JobRow,
    Page,
    PredictedSensed,
    render_page,
    tightening_range,
)
from autodb.reports.planned.predicted import figure_rows
from autodb.reports.written import library_tag
from autodb.wording import Presentation, presented
from tests.helpers.explanations import (
    STATEMENT,
    N,
    channel,
    explained,
    friction,
    loaded,
    readable,
    trace,
)


def machine_page() -> Page:
    rng = np.random.default_rng(2)
    current_A, force_N = rng.uniform(1.0, 4.0, 6000), rng.uniform(100.0, 900.0, 12)
    calibration = CalibrationPlot(
        axis="X axis",
        component="x",
        estimate=200.0 * current_A - 12.0,
        target=200.0 * current_A,
        equation="-12 N + 200 N/A · I",
        unit="N",
        rmse=18.0,
        offered=False,
        verdict="R² 0.11 is below 0.8",
    )
    n = np.arange(1.0, 9.0)
    sd = 600.0 / n
    mean = 2000.0 + 0.5 * sd
    sensed_N = np.where(np.arange(12) == 3, np.nan, force_N + 5.0)
    check = PredictedSensed(
        component="y",
        label=[f"<cut> {i}" for i in range(12)],
        predicted_N=force_N,
        low_N=force_N - 20.0,
        high_N=force_N + 20.0,
        sensed_N=sensed_N,
        sensed_sd_N=np.full(12, 9.0),
    )
    return Page(
        machine="lathe <1>",
        pair="steel / carbide",
        headline=(("Off by", "2.71 %"),),
        calibrations=(calibration,),
        drive_terms=(("Dry friction", "2.10 ± 0.02 A", "the same at every speed"),),
        learning=(LearningCurve("y", "<cut>", n, mean, sd),),
        checks=(check,),
        job_name="shaft-17",
        job_columns=("Force X", "Force Y"),
        job_rows=(JobRow("cut 1", ("", "480 N")),),
        trace_text="prediction 3\n└── parameters <14>",
    )


@cache
def found() -> str:
    return render_explanation(explained(channel(friction(), unexplained="2.10 A over speed")))


@cache
def whole() -> str:
    return render_page(machine_page(), explanation_fragment(explained(channel(friction()))))


def traces(html: str) -> list[dict[str, Any]]:
    """The traces that a page draws."""
    kept = re.findall(r'<script type="application/json">(.*?)</script>', html, re.DOTALL)
    return [one for plot in kept for one in json.loads(plot)["figure"]["data"]]


def length(values: Any) -> int:
    """How many numbers a trace holds, as a list or packed."""
    if isinstance(values, dict):
        return len(base64.b64decode(values["bdata"])) // np.dtype(values["dtype"]).itemsize
    return len(values)


def decoded(values: Any) -> Any:
    """The numbers of a trace's axis."""
    if isinstance(values, dict):
        return np.frombuffer(base64.b64decode(values["bdata"]), dtype=values["dtype"])
    return np.array(values, dtype=np.float64)


@pytest.mark.parametrize("page", [found, whole])
def test_a_page_is_one_file_that_loads_nothing(page: Any) -> None:
    html = page()
    assert html.count(library_tag()) == 1
    assert not loaded(html)
    assert len(re.findall(r"<h1[ >]", html)) == 1


@pytest.mark.parametrize("page", [found, whole])
def test_plots_are_svg_with_few_points_and_ids_of_their_own(page: Any) -> None:
    drawn = traces(page())
    assert drawn
    assert {one["type"] for one in drawn} == {"scatter"}
    assert max(length(one["x"]) for one in drawn) <= figures.MAX_POINTS
    assert all(length(one["x"]) == length(one["y"]) for one in drawn)
    ids = re.findall(r'\bid="([^"]+)"', page())
    assert len(ids) == len(set(ids))


def test_no_plot_can_be_sent_anywhere_and_buttons_have_room_above_its_title() -> None:
    html = found()
    assert html.count('"displayModeBar"') == html.count('"showSendToCloud": false') > 1
    tops = {int(top) for top in re.findall(r'"margin":\{[^}]*"t":(\d+)', html)}
    assert len(tops) == 2
    assert max(tops) - min(tops) == figures.BUTTONS_PX


def test_the_report_says_what_how_much_and_how_sure() -> None:
    text = readable(found())
    for words in (
        "The cause: friction that differs along the travel is missing (0.420 A); it takes away "
        "87 % of the squared error.",
        "0.420 A",
        "0.400 to 0.440 A",
        "very likely, 93 %",
        "From 3.00 to 5.00 s",
        "X axis position 310 to 480 mm: 71 % of the squared error in 12 % of the rows",
        "0.00310 A/mm",
        "drift of the sensor",
        "pass the travel in both directions",
        "costs more than it explains",
        "2.10 A over speed",
        "y.current of the simulation was ignored",
    ):
        assert words in text, words
    assert STATEMENT.replace("<", "&lt;").replace(">", "&gt;") in text


def test_what_a_recording_cannot_tell_is_one_paragraph() -> None:
    gravity = friction(
        term="gravity", confidence=0.5, alternatives=("sensor_drift", "lag"), to_tell_apart=None
    )
    off = friction(to_tell_apart="Run X: there position_friction and sensor_drift would differ")
    answer = channel(off, gravity, friction(term="coulomb", alternatives=()), unexplained="2 A")
    html = explanation_fragment(explained(answer))
    (said,) = re.findall(r'<p class="also">.*?</p>', html)
    assert readable(said) == (
        "What this recording cannot tell: It is not sure of a constant load (about even, 50 %). "
        "Friction that differs along the travel may also be drift of the sensor. A constant load "
        "may also be drift of the sensor or a shift in time. To find out: Run X: there friction "
        "that differs along the travel and drift of the sensor would differ. No simple move or cut "
        "is known that separates the others. Still unexplained: 2 A."
    )
    assert "could also be" not in html
    sole = friction(alternatives=(), to_tell_apart=None)
    assert "cannot tell" not in readable(explanation_fragment(explained(channel(sole))))
    nobody = explanation_fragment(explained(channel(friction(to_tell_apart=None))))
    assert "No simple move or cut is known that separates them." in readable(nobody)


def test_terms_are_written_as_they_are_where_they_are_typed() -> None:
    said = open_words(channel(friction(term="gravity")), str)
    assert said.startswith("gravity may also be sensor_drift. To find out: pass the travel")


def test_the_card_of_a_cause_says_how_large_it_is_and_what_it_takes_away() -> None:
    card = readable(explanation_fragment(explained(channel(friction())))).split("where it shows")[0]
    assert (
        "0.420 A at its largest 0.400 to 0.440 A (95 %) takes away 87 % of the squared error"
    ) in card
    off = friction(kind="mistuned")
    card = readable(explanation_fragment(explained(channel(off))))
    assert "Friction that differs along the travel position_friction" in card
    assert "0.420 A off at most 0.400 to 0.440 A (95 %)" in card
    bare = replace(explained(channel(friction())), traces={})
    assert "takes away" not in readable(explanation_fragment(bare))


def test_candidates_that_were_not_taken_show_their_evidence() -> None:
    weighed = replace(
        trace(),
        considered=(
            Considered("external_load 0", 812.0, "accepted"),
            Considered("cross_coupling y.acceleration", 31.0, "not needed"),
            Considered("direction × time", -4.0, "not needed"),
        ),
    )
    shown = replace(explained(channel(friction())), traces={"x.current": weighed})
    text = readable(explanation_fragment(shown))
    for words in (
        "a load from outside 812 accepted",
        "the pull of another axis (y.acceleration) 31.0 not needed",
        "an effect without a known name (direction × time) −4.00 not needed",
    ):
        assert words in text, words


def test_a_located_stretch_is_drawn_again_at_every_sample() -> None:
    answer = channel(friction())
    short = answer.model_copy(update={"where": Where(intervals=((3.0, 3.8),))})
    html = explanation_fragment(explained(short))
    seen = [one for one in traces(html) if 2.0 < decoded(one["x"]).min() < 3.0]
    assert [one["name"] for one in seen] == ["recording", "simulation", "corrected"]
    t = trace().x
    near = t[(t >= 3.0 - 0.16) & (t <= 3.8 + 0.16)]
    for one in seen:
        assert_allclose(decoded(one["x"]), near, rtol=1e-6)
    assert html.count("close up") == 1
    assert "close up" not in explanation_fragment(explained(channel()))


def test_many_stretches_are_one_line_and_the_longest_is_drawn() -> None:
    stretches = tuple((2.0 * one, 2.0 * one + 0.4 + 0.01 * one) for one in range(8))
    many = channel(friction()).model_copy(update={"where": Where(intervals=stretches)})
    assert where_words(many, None) == ["From 0 to 14.5 s, in 8 stretches"]
    html = explanation_fragment(explained(many))
    assert html.count("close up") == 1
    assert [one for one in traces(html) if 13.0 < decoded(one["x"]).min() < 14.0]


def test_a_long_stretch_keeps_its_peaks_and_says_that_it_is_thinned() -> None:
    answer = channel(friction())
    wide = answer.model_copy(update={"where": Where(intervals=((2.0, 14.0),))})
    spiked = trace()
    spiked.recording[9000] = 50.0
    shown = replace(explained(wide), traces={"x.current": spiked})
    html = explanation_fragment(shown)
    rows = int(np.sum((spiked.x >= 2.0 - 2.4) & (spiked.x <= 14.0 + 2.4)))
    assert f"Drawn from {rows} samples; every peak is kept." in readable(html)
    (stretch,) = [
        one
        for one in traces(html)
        if one["name"] == "recording" and decoded(one["x"]).max() < spiked.x[-1]
    ]
    assert decoded(stretch["y"]).max() == 50.0
    assert length(stretch["x"]) <= figures.MAX_POINTS


def test_the_largest_cause_comes_first_and_the_sure_ones_after_it() -> None:
    answer = channel(
        friction(confidence=0.79), friction(term="coulomb"), friction(term="lag", kind="mistuned")
    )
    text = readable(explanation_fragment(explained(answer)))
    assert (
        "The largest cause (likely, 79 %): friction that differs along the travel is missing "
        "(0.420 A); it takes away 87 % of the squared error. With less effect, at least 90 % sure: "
        "dry friction (0.420 A, 6 %) is missing; a shift in time (0.420 A, less than 1 %) is set "
        "wrong." in text
    )
    guess = channel(friction(), friction(term="coulomb", confidence=0.3))
    assert smaller_words(guess) == ""


def test_a_stretch_of_one_cause_is_not_said_to_be_that_of_all() -> None:
    one, both = channel(friction()), channel(friction(), friction(term="coulomb"))
    assert where_words(one, None)[0] == "From 3.00 to 5.00 s"
    assert where_words(both, None)[0] == (
        "From 3.00 to 5.00 s: one of the causes; the others act all along"
    )


@pytest.mark.parametrize(
    ("regime", "said"),
    [
        (Regime(signal="x.position", low=1.0, high=3.0, share=0.7), "1.00 to 3.00 mm: 70 % of the"
         " mismatch"),
        (Regime(signal="cutting.feed", low=0.08, high=0.08, share=0.7, rows=0.333),
         "Cutting feed 0.0800 mm: 70 % of the squared error in 33 % of the rows"),
        (Regime(signal="x.direction", low=-1.0, high=-0.9, share=0.9, rows=0.4),
         "backwards: 90 % of the squared error in 40 % of the rows"),
    ],
)  # fmt: skip
def test_a_regime_is_a_line_also_one_from_before_its_rows_were_counted(
    regime: Regime, said: str
) -> None:
    line = regime_words(regime).replace("\u00a0", " ")
    assert line.endswith(said), line


def test_no_mismatch_reads_so() -> None:
    html = render_explanation(explained(channel()))
    assert "No mismatch beyond noise" in readable(html)
    assert "cause found" not in readable(html)
    assert {one["name"] for one in traces(html)} == {"recording", "simulation"}


def test_what_was_read_is_escaped() -> None:
    html = render_explanation(explained(channel(), recording="<b>x<i>"))
    assert "<b>x<i>" not in html
    assert "&lt;b&gt;x&lt;i&gt;" in html
    assert "<cut>" not in whole()
    assert "lathe &lt;1&gt;" in whole()


def test_a_force_that_drives_cannot_sense_is_not_sensed() -> None:
    text = readable(whole())
    assert "cut 1 not sensed 480 N" in text
    assert "11 of 11 measured forces lie in the predicted interval; 1 not sensed." in text
    assert "X axis: not usable" in text


def test_a_page_without_content_has_no_empty_sections() -> None:
    empty = replace(
        machine_page(),
        calibrations=(),
        drive_terms=(),
        learning=(),
        checks=(),
        job_rows=(),
        trace_text="",
    )
    assert "<section" not in render_page(empty, None)


def test_thinning_keeps_every_peak_and_the_gaps() -> None:
    values = np.zeros(N)
    values[[7, 12_345]] = 5.0, -5.0
    values[15_000:16_000] = np.nan
    kept = figures.keep_peaks(values)
    assert len(kept) <= figures.MAX_POINTS
    assert {0, 7, 12_345, N - 1} <= set(kept.tolist())
    assert np.isnan(values[kept]).any()
    assert_array_equal(figures.keep_peaks(values[:100]), np.arange(100))
    for n in (figures.MAX_POINTS + 1, 4999, 123_457):
        rows = figures.keep_peaks(np.random.default_rng(n).standard_normal(n))
        assert len(rows) <= figures.MAX_POINTS
        assert rows.min() >= 0
        assert rows.max() == n - 1


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (1234.0, "1230"),
        (0.42, "0.420"),
        (-0.0031, "−0.00310"),
        (99.97, "100"),
        (0.0, "0"),
        (-2.5e-7, "−2.50 × 10⁻⁷"),
        (float("nan"), "not known"),
    ],
)
def test_numbers_have_three_significant_digits(value: float, text: str) -> None:
    assert amounts.number(value) == text


def test_pairs_of_numbers_share_their_decimals_and_show_their_width() -> None:
    assert amounts.span(0.4, 0.44, "A") == "0.400 to 0.440\u00a0A"
    assert amounts.span(14.19, 14.21, "s") == "14.19 to 14.21\u00a0s"
    assert amounts.span(1e-6, 2e-6, "1") == "1.00 × 10⁻⁶ to 2.00 × 10⁻⁶"
    assert amounts.span(0.0, 0.0, "N") == "0 to 0\u00a0N"
    assert amounts.plus_minus(61.62, 5.4, "N/mm") == "61.6 ± 5.4\u00a0N/mm"


def test_a_learning_plot_holds_the_last_band() -> None:
    curve = machine_page().learning[0]
    low, high = tightening_range(curve.mean, curve.sd)
    assert low < curve.mean[-1] - 2.0 * curve.sd[-1]
    assert high > curve.mean[-1] + 2.0 * curve.sd[-1]
    assert high < curve.mean[0] + 2.0 * curve.sd[0]


def test_a_value_and_its_interval_share_one_unit_behind_them() -> None:
    figures = CutFigures(None, 172.0, Interval(1710.0, 1600.0, 2024.0), None, {})
    said = dict(figure_rows(figures))
    assert said["Specific force"] == "1710 (1600 to 2024)\u00a0N/mm²"
    with presented(Presentation("en", shop_units("inch"))):
        assert "N" not in dict(figure_rows(figures))["Specific force"]
