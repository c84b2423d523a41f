"""An explanation with a cause that is missing, and what a reader sees of a page."""

import re
from dataclasses import replace
from typing import Any

import numpy as np

from autodb.explain.answer import (
    Cause,
    ChannelAnswer,
    ChannelTrace,
    Considered,
    Explained,
    Explanation,
    FitQuality,
    IntervalValue,
    Regime,
    Where,
)
from autodb.reports.written import library_tag

N = 20_000
STATEMENT = "The guideway drags 0.42 A more at the far end <than> the simulation assumes."
OUTSIDE = re.compile(r"""(?:src|href)\s*=\s*["']?(?!["']?#)|@import|url\(|https?://|//cdn""")


def friction(**more: Any) -> Cause:
    known: dict[str, Any] = {
        "term": "position_friction",
        "kind": "missing",
        "confidence": 0.93,
        "statement": STATEMENT,
        "parameters": {
            "size": IntervalValue(value=0.42, low=0.4, high=0.44, unit="A"),
            "slope": IntervalValue(value=0.0031, low=0.0029, high=0.0033, unit="A/mm"),
        },
        "alternatives": ("sensor_drift",),
        "to_tell_apart": "pass the travel in both directions",
    }
    return Cause(**{**known, **more})


def channel(*causes: Cause, unexplained: str | None = None) -> ChannelAnswer:
    where = Where(
        intervals=((3.0, 5.0),),
        regime=(Regime(signal="x.position", low=310.0, high=480.0, share=0.71, rows=0.12),),
    )
    return ChannelAnswer(
        unit="A",
        mismatch=bool(causes),
        where=where if causes else Where(),
        missing=causes,
        fit=FitQuality(
            rms_before=0.41,
            rms_after=0.124,
            heldout_before=0.4,
            heldout_after=0.126,
            noise_floor=0.121,
        ),
        unexplained=unexplained,
    )


def trace() -> ChannelTrace:
    t = np.linspace(0.0, 20.0, N)
    noise = 0.1 * np.random.default_rng(1).standard_normal(N)
    simulation = np.sin(t)
    return ChannelTrace(
        x_name="t",
        x=t,
        recording=1.4 * simulation + noise,
        simulation=simulation,
        corrected=1.4 * simulation,
        regime_signals={"x.position": 300.0 + 200.0 * simulation},
        considered=(
            Considered("lag", -3.2, "costs more than it explains"),
            Considered("position_friction", 6120.0, "named"),
        ),
    )


def explained(answer: ChannelAnswer, *, recording: str = "air.csv") -> Explained:
    """An explanation whose causes take 87, 6 and 0.4 % of the squared error away."""
    return Explained(
        explanation=Explanation(recording=recording, channels={"x.current": answer}),
        traces={"x.current": replace(trace(), takes=(0.87, 0.06, 0.004)[: len(answer.missing)])},
        notes=("y.current of the simulation was ignored",),
    )


def loaded(html: str) -> list[str]:
    """What a page loads, but the script of its plots beside it."""
    return OUTSIDE.findall(html.replace(library_tag(), ""))


def readable(html: str) -> str:
    """What a reader sees of a page, in one line."""
    text = re.sub(r"<(script|style).*?</\1>", " ", html, flags=re.DOTALL)
    return " ".join(re.sub(r"<[^>]+>", " ", text).replace("\u00a0", " ").split())
