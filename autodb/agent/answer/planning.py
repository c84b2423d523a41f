"""Which cut to make next for a job: within the machine's limits, the one that leaves least open."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray
from sqlalchemy import select
from sqlalchemy.orm import Session

from autodb.agent.answer.prediction_basis import PredictionBasis, prediction_basis_of
from autodb.agent.learn.known import KnownPair, known_of
from autodb.agent.learn.starting import start_of
from autodb.agent.rows.calibrations import current_calibrations
from autodb.agent.rows.machines import find_machine, owner_of
from autodb.agent.rows.sensed_forces import QUANTITY
from autodb.agent.sense.sensed import Readings
from autodb.cutting.turning import PASSIVE_AXIS
from autodb.errors import UnusableInput
from autodb.files.job import Job
from autodb.files.job_cut import JobCut
from autodb.fitting.gaussian import NORMAL_95
from autodb.pairs.determined import (
    PossibleMeasurement,
    UndeterminedNumbers,
    chip_thickness,
    undetermined,
)
from autodb.pairs.engaged import BY_NAME
from autodb.pairs.forecast import forecast
from autodb.pairs.next_cut import MAY_EXCEED, SensedComponent, SharedError, target_sds
from autodb.pairs.observed import Observed, PairCuts
from autodb.pairs.posterior import DAY, PairPosterior
from autodb.store import Store, models
from autodb.wording import msgid, phrase

Array = NDArray[np.float64]

SHOWN = 3
"""Cuts that are proposed."""
LEVELS = {"feed": 5, "depth": 4, "speed": 3}
"""Values of each that are tried."""
REACH = {"feed": (0.5, 1.5), "depth": (0.5, 1.5), "speed": (0.7, 1.3)}
"""Parts of the job's least and largest that are tried where no range is given. Chosen."""
HARDLY = 0.95
NEWEST = 200
"""Newest forces of a calibration that its sensing error is read off."""

Ranges = dict[str, tuple[float, float]]


@dataclass(frozen=True)
class Proposed:
    """A cut that may be made, and the mean half 95 % interval, of the force, that is left then."""

    cut: JobCut
    left: float


@dataclass(frozen=True)
class Target:
    """A force of one of the job's cuts: half its 95 % interval, of the force, now and after."""

    cut: str
    component: str
    now: float
    after: float


@dataclass(frozen=True)
class ProposedCuts:
    """``proposed``: best first; ``targets`` after the first of them; ``too_much``: cuts left out
    because they may exceed a limit; ``open``: what the pair's cuts leave undetermined, and
    what would determine it, by what past predictions widen it, what waits for a person;
    ``not_determined``: numbers of the law that no measurement tried would determine.
    """

    proposed: tuple[Proposed, ...]
    now: float
    targets: tuple[Target, ...]
    too_much: int
    open: tuple[str, ...]
    not_determined: tuple[str, ...]

    @property
    def hardly(self) -> bool:
        """Whether the best cut leaves nearly all that is open now."""
        return self.proposed[0].left > HARDLY * self.now


def plan_cuts(
    store: Store, machine: str, job: Job, *, ranges: Ranges | None = None
) -> ProposedCuts:
    """Return the cuts that would narrow a job's predicted forces most.

    ``ranges``: of ``feed``, ``depth`` (mm) and ``speed`` (m/min) that may be tried. Raises
    UnusableInput for a job that is a program, an unknown machine, one that senses nothing, and
    where every cut may exceed a limit.
    """
    if job.program is not None:
        raise UnusableInput(
            phrase(
                "job '{job}': a plan is made for cuts; use a job with [[cut]] in place of "
                "[program]",
                job=job.name,
            )
        )
    with store.reading() as session:
        row = find_machine(session, machine)
        owner = owner_of(row)
        known = known_of(session, owner, job.material, job.tool)
        sensed = _sensed(session, row)
        start = start_of(session, owner.id, job.material, job.tool).posterior
        basis = prediction_basis_of(session, owner, job.material, known)
    search = _Search(known, job, sensed)
    candidates = list(_candidates(job, ranges or {}))
    order, variance = search.ranked(candidates)
    best, too_much = [], 0
    for k in order:
        if _may_exceed(basis, candidates[k]):
            too_much += 1
        else:
            left = basis.width.factor * NORMAL_95 * float(np.sqrt(variance[k]))
            best.append(Proposed(candidates[k], left))
        if len(best) == SHOWN:
            break
    if not best:
        raise UnusableInput(
            phrase(
                "each of {n} cuts may exceed a limit of machine '{machine}'; use lighter ones "
                "with --depth and --feed",
                n=len(candidates),
                machine=machine,
            )
        )
    now, targets = search.targets(best[0].cut, basis.width.factor)
    open_ = search.open(start)
    return ProposedCuts(
        proposed=tuple(best),
        now=now,
        targets=targets,
        too_much=too_much,
        open=(*(one.statement for one in open_ if one.helps), *_widened(basis), *basis.waiting),
        not_determined=tuple(name for one in open_ if not one.helps for name in one.names),
    )


class _Search:
    """The posterior of a job's pair, what is asked, and what the machine senses."""

    def __init__(self, known: KnownPair, job: Job, sensed: dict[str, SensedComponent]) -> None:
        self._posterior, self._tool = known.posterior, known.tool
        self._job, self._sensed = job, sensed
        self._asked = [self._cuts(cut.operation, [cut]) for cut in job.cut]

    def ranked(self, candidates: Sequence[JobCut]) -> tuple[NDArray[np.intp], Array]:
        """Return the candidates' order, best first, and their variance."""
        variance = np.zeros(len(candidates))
        for operation in dict.fromkeys(cut.operation for cut in candidates):
            rows = [k for k, cut in enumerate(candidates) if cut.operation == operation]
            tried = self._cuts(operation, [candidates[k] for k in rows])
            for asked in self._asked:
                variance[rows] += self._weighed(tried, asked)[1] / len(self._asked)
        return np.argsort(variance, kind="stable"), variance

    def targets(self, cut: JobCut, factor: float) -> tuple[float, tuple[Target, ...]]:
        """Return how wide the job's forces are now, in the mean, and each of them after a cut.

        ``factor``: by which past predictions widen them.
        """
        tried, found, squares = self._cuts(cut.operation, [cut]), [], []
        half = NORMAL_95 * factor
        for target, asked in zip(self._job.cut, self._asked, strict=True):
            left, _ = self._weighed(tried, asked)
            expected = forecast(self._posterior, asked)
            for component in self._components(asked.operation):
                k = QUANTITY[component]
                size = abs(float(expected.mean[0, k]))
                now, after = float(expected.sd[0, k]) / size, float(left[0, 0, k]) / size
                squares.append(now**2)
                found.append(Target(target.name, component, half * now, half * after))
        return float(half * np.sqrt(np.mean(squares))), tuple(found)

    def open(self, start: PairPosterior) -> tuple[UndeterminedNumbers, ...]:
        """Return what the pair's cuts leave undetermined, and what would help."""
        if self._posterior.cuts == 0:
            return ()
        first = self._job.cut[0]
        changes = {
            msgid("a cut at half the feed"): {
                name: 0.5 * value
                for name in ("feed_mm_rev", "feed_mm_tooth")
                if (value := getattr(first, name)) is not None
            },
            msgid("a cut at twice the speed"): {
                name: 2.0 * value
                for name in ("speed_rpm", "speed_m_min")
                if (value := getattr(first, name)) is not None
            },
        }
        trials = [
            self._trial(called, first.model_copy(update=changed))
            for called, changed in changes.items()
        ]
        chip = chip_thickness(self._posterior, self._cuts(first.operation, [first]))
        return undetermined(start, self._posterior, [chip, *trials])

    def _trial(self, called: str, cut: JobCut) -> PossibleMeasurement:
        sensed = [self._sensed[c] for c in self._components(cut.operation)]
        count = len(sensed)
        return PossibleMeasurement(
            called,
            Observed(
                cuts=(self._cuts(cut.operation, [cut]),),
                cut=np.zeros(count, dtype=np.intp),
                quantity=np.array([one.quantity for one in sensed], dtype=np.intp),
                value=np.zeros(count),
                sd=np.array([one.sd for one in sensed]),
                common=np.zeros((count, 0)),
            ),
        )

    def _weighed(self, tried: PairCuts, asked: PairCuts) -> tuple[Array, Array]:
        sensed = tuple(self._sensed[c] for c in self._components(tried.operation))
        asked_for = tuple(QUANTITY[c] for c in self._components(asked.operation))
        return target_sds(self._posterior, tried, asked, sensed=sensed, quantities=asked_for)

    def _components(self, operation: str) -> list[str]:
        """Return the components that the machine senses in an operation."""
        found = [c for c in self._sensed if c != PASSIVE_AXIS.get(operation)]
        if not found:
            raise UnusableInput(
                phrase(
                    "the machine senses no force in operation '{operation}'", operation=operation
                )
            )
        return found

    def _cuts(self, operation: str, cuts: Sequence[JobCut]) -> PairCuts:
        stated = [cut.conditions(self._tool.diameter_mm) for cut in cuts]
        return BY_NAME[operation].cuts(self._tool.numbers, stated, called=self._tool.name)


def _widened(basis: PredictionBasis) -> Iterator[str]:
    """Say by what past predictions widen the intervals, as the prediction of the job does."""
    if basis.width.factor > 1.0:
        yield basis.width.words(basis.machine)


def _sensed(session: Session, owner: models.Machine) -> dict[str, SensedComponent]:
    """Return what the machine's usable calibrations sense, by component.

    Sensing errors and how a calibration's errors move a reading are those of its newest forces, in
    the middle. Raises UnusableInput where none has sensed anything yet.
    """
    found = {}
    for axis in owner.axes:
        current = current_calibrations(session, owner.id, axis.name)
        query = (
            select(models.SensedForce)
            .where(
                models.SensedForce.calibration_id.in_([row.id for row in current if row.offered]),
                models.SensedForce.value_N.is_not(None),
            )
            .order_by(models.SensedForce.id.desc())
            .limit(NEWEST)
        )
        forces = list(session.scalars(query))
        if forces:
            found[forces[0].component] = _usual(forces)
    if not found:
        raise UnusableInput(
            phrase(
                "machine '{owner}' has no sensed forces yet; run 'autodb refresh' to sense "
                "those of the imported cuts",
                owner=owner.name,
            )
        )
    return found


def _usual(forces: Sequence[models.SensedForce]) -> SensedComponent:
    """Return how the newest of an axis' calibrations senses a cut: of a day of its own."""
    newest = [f for f in forces if f.calibration_id == forces[0].calibration_id]
    newest = [f for f in newest if f.cut.recording_id == newest[0].cut.recording_id]
    sensed = Readings(newest)
    errors, begin = [], 0
    for one in sensed.shared:
        columns = slice(begin, begin + len(one.covariance))
        begin = columns.stop
        key = f"{DAY} to come" if one.key.startswith(DAY) else one.key
        errors.append(
            SharedError(
                type(one)(key, one.covariance),
                np.median(sensed.share[:, columns], axis=0),
                np.median(sensed.shift[:, columns], axis=0),
            )
        )
    return SensedComponent(
        QUANTITY[newest[0].component], float(np.median(sensed.sd_N)), tuple(errors)
    )


def _candidates(job: Job, ranges: Ranges) -> Iterator[JobCut]:
    """Give cuts of the job's operations over the ranges of feed, depth and speed."""
    for operation in dict.fromkeys(cut.operation for cut in job.cut):
        own = [cut for cut in job.cut if cut.operation == operation]
        feed_key = "feed_mm_rev" if own[0].feed_mm_rev is not None else "feed_mm_tooth"
        feeds = _levels("feed", [getattr(cut, feed_key) for cut in own], ranges)
        depths = _levels("depth", [cut.depth_mm for cut in own], ranges)
        speeds = _levels("speed", [cut.speed_m_min for cut in own], ranges)
        turns = _levels("speed", [cut.speed_rpm for cut in own], {}) if not speeds else []
        speed_key = "speed_m_min" if speeds else "speed_rpm"
        bare = own[0].model_copy(update={"name": "", "speed_m_min": None, "speed_rpm": None})
        for feed, speed in product(feeds, speeds or turns):
            for deep in [{"depth_mm": depth} for depth in depths] or [{}]:
                yield bare.model_copy(update={feed_key: feed, speed_key: speed, **deep})


def _levels(what: str, stated: Sequence[float | None], ranges: Ranges) -> list[float]:
    """Return the values to try of a quantity; none where the job's cuts do not state it."""
    known = [value for value in stated if value is not None]
    if what in ranges:
        low, high = ranges[what]
    elif known:
        low, high = REACH[what][0] * min(known), REACH[what][1] * max(known)
    else:
        return []
    return [float(f"{value:.3g}") for value in np.linspace(low, high, LEVELS[what])]


def _may_exceed(basis: PredictionBasis, cut: JobCut) -> bool:
    done, _ = basis.predict([cut])
    return any(one.probability > MAY_EXCEED for one in basis.exceeding(done))
