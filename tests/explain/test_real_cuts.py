"""Concealed effects in public forces of turning, drilling and milling: named, with a size.

A least-squares law of each is its simulation, without one term; where rows left out are
predicted decidably worse without it, and which names are fair, is in each case's truth.json.
"""

import json
from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from autodb.explain import explain
from autodb.explain.answer import ChannelAnswer
from autodb.records import source as records
from tests.conftest import shared
from tests.helpers.campaigns import first

Array = NDArray[np.float64]
KINDS = {
    "phm2*": 1, "drill-*-kept": 0, "turn-*-kept": 0, "mill-*": 0, "turn-*": 0, "drill-*": 0,
}  # fmt: skip
"""How many decidable channels of each are not named with their size."""
SURE, PLAIN, HALF = 0.9, 0.85, 0.5


def _cases(kind: str) -> Iterator[tuple[dict[str, Any], dict[str, ChannelAnswer]]]:
    for folder in sorted(shared("data", "real").glob(kind)):
        truth = json.loads((folder / "truth.json").read_text("utf-8"))
        if truth.get("decidable", True):
            yield truth, _answers(folder, tuple(truth["includes"]))


@cache
def _answers(folder: Path, includes: tuple[str, ...]) -> dict[str, ChannelAnswer]:
    recording, simulation = (
        records.read(folder / f"{name}.csv") for name in ("recording", "simulation")
    )
    return explain(recording, simulation, includes=list(includes)).explanation.channels


def _sizes(truth: dict[str, Any], channel: str, answer: ChannelAnswer) -> dict[str, float]:
    """Return the size of each name of a channel over the true one of that name."""
    whole = truth.get("true_size_by_channel", {}).get(channel, truth["true_size"])
    of_name = truth.get("true_size_by_name", {}).get(channel, {})
    return {
        cause.term: cause.parameters["size"].value / of_name.get(cause.term, whole)
        for cause in answer.missing
        if cause.kind == "missing" and cause.confidence >= HALF and "size" in cause.parameters
    }


@pytest.mark.parametrize("kind", first(1, KINDS))
def test_what_was_left_out_of_public_forces_is_named_with_its_size(kind: str) -> None:
    """All but one of 58 decidable channels within a factor 2, none by another name at 90 %; no
    channel is predicted worse on cuts, or turns, left out.
    """
    right, wrong = [], []
    for truth, answers in _cases(kind):
        for answer in answers.values():
            assert answer.fit.heldout_after <= 1.02 * answer.fit.heldout_before
        for channel in truth.get("decidable_in", answers) if truth["concealed"] else ():
            sizes = _sizes(truth, channel, answers[channel])
            fair = [ratio for term, ratio in sizes.items() if term in truth["fair"]]
            right.append(any(0.5 <= ratio <= 2.0 for ratio in fair))
            sure = {c.term for c in answers[channel].missing if c.confidence >= SURE}
            others = sure - {*truth["fair"], "unknown"}
            plain = {c.term for c in answers[channel].missing if c.confidence >= PLAIN}
            assert kind != "phm2*" or "tool_wear" in plain, "plain in more than a hundred cuts"
            wrong.append(not fair and any(sizes.get(term, 0.0) >= HALF for term in others))
    assert len(right) >= 4
    assert right.count(False) == KINDS[kind]
    assert not any(wrong)


def test_a_rounding_takes_no_other_effect_of_the_same_columns() -> None:
    """A drift and a gain are one column where the simulated force is constant, a wave over the time
    and one over the cut's number where cuts are even in time: the first of them counts. By a
    rounding of the last digit, as another processor's, other sets were found, and wear was 0.99
    or 0.88 sure."""
    folder = shared("data", "real", "phm2-no_tool_wear-kept")
    recording, simulation = (
        records.read(folder / f"{name}.csv") for name in ("recording", "simulation")
    )
    rng = np.random.default_rng(20261201)
    moved = {
        name: values * (1.0 + 1e-12 * rng.standard_normal(len(values)))
        if name.startswith("force.")
        else values
        for name, values in recording.channels.items()
    }
    again = explain(replace(recording, channels=moved), simulation, includes=["shear"])
    assert _said(again.explanation.channels) == _said(_answers(folder, ("shear",)))


def _said(answers: dict[str, ChannelAnswer]) -> dict[str, list[tuple[object, ...]]]:
    """Return what is said of each channel, confidence to a thousandth."""
    return {
        channel: [
            (one.term, one.kind, round(one.confidence, 3), one.alternatives)
            for one in answer.missing
        ]
        for channel, answer in answers.items()
    }


def test_a_sensor_that_fails_and_comes_back_does_not_hide_wear() -> None:
    """Three worn cutters; force.x of the first drops between two cuts and returns."""
    ((_, answers),) = _cases("phm-no_tool_wear*")
    for channel, answer in answers.items():
        assert "tool_wear" in {c.term for c in answer.missing if c.confidence >= SURE}, channel
    assert [c.term for c in answers["force.x"].missing if c.term == "gain"]
    assert not [c for n in ("force.y", "force.z") for c in answers[n].missing if c.term == "gain"]
    ((_, nothing_hidden),) = _cases("phm-null")
    for answer in nothing_hidden.values():
        assert "hard_spot" not in {c.term for c in answer.missing if c.confidence >= HALF}
