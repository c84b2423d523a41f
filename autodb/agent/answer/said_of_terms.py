"""Confirmed terms of a pair in words: how large each is, and what it is of cuts asked for."""

from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from autodb.agent.learn.learnt_from import said_of_wear, wear_words
from autodb.cutting.shear import NAMES, PARAMETERS
from autodb.files.job_cut import JobCut
from autodb.fitting.gaussian import NORMAL_95
from autodb.forward.prediction import PredictedCut, ToolOf
from autodb.pairs.posterior import BAND, WEAR, PairPosterior, lot_key
from autodb.terms.chip import HARD_SPOT, built_up_edge
from autodb.wording import significant

NOTICED = 0.05
"""Share of a band's change from which on a cut is said to be in it. Chosen."""


def terms_words(posterior: PairPosterior, terms: Iterable[str]) -> Iterator[str]:
    """Say how large each of some confirmed terms is that a posterior holds, each once."""
    for name in dict.fromkeys(terms):
        if name == WEAR and posterior.wear is not None:
            yield wear_words(posterior)
        elif name == BAND and posterior.terms.band is not None:
            yield f"{BAND}: {_band_words(posterior)}"
        elif name == HARD_SPOT.name:
            yield from (f"{name}: {_lot_words(posterior, lot)}" for lot in posterior.terms.lots)
        else:
            yield from _law_words(posterior, name)


def _law_words(posterior: PairPosterior, name: str) -> Iterator[str]:
    """Say what the numbers of the law are that hold a term."""
    from autodb.terms.vocabulary import all_terms

    numbers = {n for term in all_terms() if term.name == name for n in term.in_law}
    said = []
    for k in sorted(NAMES.index(number) for number in numbers):
        half = NORMAL_95 * float(np.sqrt(posterior.law.covariance[k, k]))
        middle = float(posterior.law.mean[k])
        value, low, high = (
            float(PARAMETERS[k].outside(at)) for at in (middle, middle - half, middle + half)
        )
        said.append(
            f"{NAMES[k]} {significant(value)} ({significant(low)} to {significant(high)}) "
            f"{PARAMETERS[k].unit}"
        )
    if said:
        yield f"{name}: {', '.join(said)}"


def _share_words(mean: float, sd: float) -> str:
    half = NORMAL_95 * sd
    return f"{100 * mean:+.0f} % ({100 * (mean - half):+.0f} to {100 * (mean + half):+.0f} %)"


def _band_words(posterior: PairPosterior) -> str:
    band, place = posterior.terms.band, posterior.columns(BAND)
    assert band is not None
    half = NORMAL_95 * float(np.sqrt(band.covariance[0][0]))
    ends = (band.centre_m_min * np.exp(step * half) for step in (-1.0, 1.0))
    low, high = (f"{end:.3g}" for end in ends)
    sd = np.sqrt(np.diag(posterior.state.covariance)[place])
    along, across = map(_share_words, posterior.state.mean[place].tolist(), sd.tolist())
    return (
        f"around {band.centre_m_min:.3g} m/min ({low} to {high}) force along the cutting speed "
        f"changes by {along} and across it by {across}"
    )


def _lot_words(posterior: PairPosterior, lot: str) -> str:
    place = posterior.columns(lot_key(lot)).start
    sd = float(np.sqrt(posterior.state.covariance[place, place]))
    return f"forces of lot '{lot}' differ by {_share_words(float(posterior.state.mean[place]), sd)}"


def said_of_terms(
    posterior: PairPosterior,
    tool: ToolOf,
    asked: Sequence[JobCut],
    found: Sequence[PredictedCut],
) -> Iterator[str]:
    """Say what confirmed terms are of the forces predicted, and what to state to have them.

    ``asked``: none for the lines of a program, which state nothing of their edge.
    """
    yield from said_of_wear(posterior, tool, asked, found)
    yield from _said_of_lots(posterior)
    band = posterior.terms.band
    for number, cut in enumerate(found, start=1) if band is not None else ():
        assert band is not None
        inside = float(
            built_up_edge(
                np.array(cut.speed_m_min),
                change=1.0,
                centre_m_min=band.centre_m_min,
                width=band.width,
            )
            - 1.0
        )
        if inside > NOTICED and cut.state is None:
            name = f" '{cut.name}'" if cut.name else ""
            yield (
                f"cut {number}{name}: {100 * inside:.0f} % into the band of {BAND}: "
                f"{_band_words(posterior)}"
            )


def _said_of_lots(posterior: PairPosterior) -> Iterator[str]:
    lots = posterior.terms.lots
    if posterior.lot in lots:
        yield f"{_lot_words(posterior, str(posterior.lot))}; this is in the forces"
    elif lots:
        which = (
            "no lot is stated" if posterior.lot is None else f"lot '{posterior.lot}' is not known"
        )
        known = "; ".join(_lot_words(posterior, lot) for lot in lots)
        yield f"{which}: predicted as of the other lots; {known}"
