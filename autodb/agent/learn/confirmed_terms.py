"""Which confirmed causes a pair's normal cutting state holds, and how it is learnt with them.

A cause of the law itself (an edge's force, thin chips, speed) opens the law's numbers that its term
names, wider than metals differ. Wear, a band of speeds and a hard lot stand beside the law. All are
learnt with it, from the cuts that were learnt before and those of the recordings that the cause was
found in.
"""

from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import replace

import numpy as np
from sqlalchemy.orm import Session

from autodb.agent.learn.states import PERSISTS, Forces, causes_of
from autodb.agent.rows.mismatches import recordings_of
from autodb.agent.rows.recorded_edges import cut_before_s
from autodb.agent.sense.sensed import as_observed
from autodb.cutting.shear import NAMES
from autodb.fitting.gaussian import Gaussian
from autodb.pairs.confirmed import band_after, learn_banded, with_terms
from autodb.pairs.engaged import RPM, SPEED
from autodb.pairs.posterior import BAND, WEAR, PairPosterior, PairTerms
from autodb.pairs.prior import any_metal
from autodb.pairs.updating import posterior_of_readings
from autodb.pairs.worn import learn_worn, wear_after
from autodb.store import models
from autodb.terms.chip import HARD_SPOT
from autodb.terms.vocabulary import all_terms

OPENED = 2.0
"""Standard deviations, in those of any metal, that a number of the law is opened by once a person
says that what is known of it does not hold. Chosen."""
SHAPE = ("centre", "width")
"""Parameters that say where a band lies."""
Progress = Callable[[str], None]


def of_pairs() -> frozenset[str]:
    """Return the names of terms that belong to a pair, or to a lot of its material."""
    return frozenset(term.name for term in all_terms() if term.belongs_to in ("pair", "lot"))


def held_causes(session: Session, forces: Forces) -> list[models.Mismatch]:
    """Return the confirmed causes that the normal cutting state of a pair can hold, oldest first.

    Of their recordings PERSISTS cuts at least that state what the term acts on; a hard spot of no
    lot is none of them.
    """
    causes = causes_of(session, forces, of_pairs())
    return [cause for cause in causes if _tells(cause, forces)]


def _tells(cause: models.Mismatch, forces: Forces) -> bool:
    """Say whether forces of a cause's recordings tell its term."""
    recordings = recordings_of([cause])
    cuts = list({f.cut_id: f.cut for f in forces if f.cut.recording_id in recordings}.values())
    if cause.confirmed_term == HARD_SPOT.name:
        cuts = [cut for cut in cuts if cause.lot is not None and cut.lot == cause.lot]
    elif cause.confirmed_term == WEAR:
        times = [used for used in map(cut_before_s, cuts) if used is not None]
        return len(times) >= PERSISTS and len(set(times)) > 1
    elif cause.confirmed_term == BAND:
        cuts = [cut for cut in cuts if {SPEED, RPM} & set(cut.conditions)]
    return len(cuts) >= PERSISTS


def opened(start: PairPosterior, causes: Iterable[models.Mismatch]) -> PairPosterior:
    """Return a pair's start with the numbers of the law opened that causes are of."""
    names = {str(cause.confirmed_term) for cause in causes}
    numbers = {n for term in all_terms() if term.name in names for n in term.in_law}
    if not numbers:
        return start
    rows = sorted(NAMES.index(number) for number in numbers)
    covariance = start.state.covariance.copy()
    covariance[rows, rows] += OPENED**2 * np.diag(any_metal().law.covariance)[rows]
    return replace(start, state=Gaussian(start.state.mean, covariance))


def lots_of(causes: Iterable[models.Mismatch]) -> tuple[str, ...]:
    """Return the lots that hard spots were confirmed for, each once."""
    named = [one.lot for one in causes if one.confirmed_term == HARD_SPOT.name and one.lot]
    return tuple(dict.fromkeys(named))


def to_learn(
    causes: Sequence[models.Mismatch], forces: Forces, seen: Collection[int], terms: PairTerms
) -> Forces:
    """Return the forces that a version with causes learns: those seen, and of their recordings.

    Where edges wear, of cuts alone that state how long theirs has cut.
    """
    recordings = recordings_of(causes)
    worn = terms.wear is not None or WEAR in {one.confirmed_term for one in causes}
    return [
        force
        for force in forces
        if (force.id in seen or force.cut.recording_id in recordings)
        and (not worn or cut_before_s(force.cut) is not None)
    ]


def learn_with(
    causes: Sequence[models.Mismatch],
    start: PairPosterior,
    forces: Forces,
    *,
    last: PairPosterior,
    progress: Progress,
) -> PairPosterior:
    """Return the posterior of forces from ``start``, with all that causes are of.

    ``last``: the posterior without the newest of them, whose law is as far off and which the search
    starts from.
    """
    names = {one.confirmed_term for one in causes}
    terms = replace(last.terms, lots=lots_of(causes))
    before, near = replace(start, off_law=last.off_law, terms=terms), last
    if WEAR in names and terms.wear is None:
        observed = with_terms(as_observed(forces), replace(terms, wear=None))
        near = learn_worn(before, observed, near=near, progress=progress)
        before = replace(before, terms=near.terms)
    observed = as_observed(forces, terms=before.terms)
    if BAND in names and terms.band is None:
        hint = next(filter(None, map(_hint, causes)), None)
        return learn_banded(before, observed, near=near, hint=hint, progress=progress)
    return posterior_of_readings(before, observed, near=near)


def terms_after(start: PairPosterior, forces: Forces, *, near: PairPosterior) -> PairTerms:
    """Return the terms of a start with wear and band bent as forces say, near a posterior of them.

    What the first confirmation found of few edges and speeds is not the last word.
    """
    terms, before = start.terms, replace(start, off_law=near.off_law)
    if terms.wear is not None:
        bare = replace(terms, wear=None)
        observed = as_observed(forces, terms=bare)
        wear = wear_after(replace(before, terms=bare), observed, near=near, wear=terms.wear)
        terms = replace(terms, wear=wear)
    if terms.band is not None:
        observed = as_observed(forces, terms=terms)
        band = band_after(replace(before, terms=terms), observed, near=near, band=terms.band)
        terms = replace(terms, band=band)
    return terms


def _hint(cause: models.Mismatch) -> tuple[float, float] | None:
    """Return centre and width of the band that a cause was found with; None: it states none."""
    said = [cause.parameters[name]["value"] for name in SHAPE if name in cause.parameters]
    is_band = cause.confirmed_term == BAND and len(said) == len(SHAPE)
    return (float(said[0]), float(said[1])) if is_band else None
