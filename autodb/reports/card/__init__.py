"""The calibration card: how well each axis of a machine senses force, on one page."""

from autodb.reports.card.axis_figures import AxisCard, axis_card
from autodb.reports.card.files import check_card_target, write_card
from autodb.reports.card.machine_card import CalibrationCard, not_sensed, when_again
from autodb.reports.card.render import render_card

__all__ = [
    "AxisCard", "CalibrationCard", "axis_card", "check_card_target", "not_sensed", "render_card",
    "when_again",
    "write_card",
]  # fmt: skip
