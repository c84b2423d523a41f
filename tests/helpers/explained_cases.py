"""Cases of the proof of explanations that are made by hand."""

import numpy as np

from autodb.proofs.cases.base.case import Case, Hidden, Rival
from autodb.proofs.runs.explain.explain_score import NamedEntry, ScoredCase

T = np.linspace(0.0, 10.0, 500)


def hand_made(part: list[float] | np.ndarray, rivals: list[Rival], *, noise: float = 1.0) -> Case:
    """A constant is the simulation's own term; noise is white with sd 1 unless scaled."""
    hidden = np.asarray(part, dtype=np.float64)
    truth = 2.0 + hidden
    measured = truth + noise * np.random.default_rng(7).standard_normal(T.size)
    return Case(
        seed=1, kind="slope", wanted=20.0, reached=True, tuning="true",
        channels={"t": T, "x.current": measured}, simulation={"t": T, "x.current": 2.0 + 0.0 * T},
        includes=("gravity",), explained=("x.current",),
        hidden=(Hidden("slope", 1.0, 20.0, hidden),), interval=(2.0, 4.0),
        measured=measured, simulated=np.full_like(T, 2.0), truth=truth,
        own=np.ones((1, T.size)), whitened=lambda values: values, rivals=lambda: iter(rivals),
    )  # fmt: skip


def scored(hidden: tuple[str, ...], *named: NamedEntry, wanted: float = 20.0) -> ScoredCase:
    return ScoredCase(
        seed=1, kind="+".join(hidden), place="axis", wanted=wanted, reached=True, tuning="true",
        terms=hidden, clarities=(wanted,) * len(hidden), margin=100.0, decidable=True,
        best_recovery=0.2, named=named, recovery=0.25,
    )  # fmt: skip


def entry(term: str, confidence: float = 0.9, *alternatives: str) -> NamedEntry:
    return NamedEntry("x.current", term, confidence, alternatives)
