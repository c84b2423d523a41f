"""Jobs that were predicted, as what was asked for, and a prediction at what was then made of it."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import PurePath
from typing import Any

from sqlalchemy import select
from sqlalchemy.orm import Session

from autodb.agent.learn.starting import start_of
from autodb.agent.rows.catalogue import geometry_known, numbers_of
from autodb.agent.rows.posteriors import as_posterior, chain_ids
from autodb.agent.rows.recorded_edges import recorded_conditions
from autodb.agent.rows.sensed_forces import operation_of
from autodb.files.job_cut import JobCut
from autodb.forward.limits import QUANTITIES
from autodb.forward.matching import OVERRIDE, CutOfJob, MadeCut, overridden_alike
from autodb.forward.prediction import ToolOf
from autodb.pairs.engaged import (
    BANDS,
    BY_NAME,
    CUTTING_TIME,
    DEPTH,
    FEED,
    RPM,
    SPEED,
    WIDTH,
    Conditions,
)
from autodb.pairs.forecast import expected_means
from autodb.pairs.posterior import PairPosterior
from autodb.store import models

UNCHANGED = 1e-3
"""Share by which a condition may differ and be the one asked for. Chosen: logs round."""
FED = 0.05
"""Share by which the feed of a program's line may be off for its forces to be those predicted.
Chosen: forces follow four fifths of it."""
FAR = 5.0
"""Factor from which on what was made differently says nothing of the prediction. Chosen."""
SMALL = 1e-6
"""Force, N, torque, N·m, or power, W, below which there is none."""


@dataclass(frozen=True)
class AskedJob:
    """A predicted job: the prediction's number, when it was made, and what was asked for.

    ``program``: the file of its program, without folder and ending; None: it lists cuts.
    """

    prediction: int
    created_at: str
    name: str
    pair: tuple[str, str]
    program: str | None

    def is_called(self, job: str | None, program: str | None) -> bool:
        """Say whether a recording of this job or this program is of it."""
        if job is not None and job != self.name:
            return False
        if program is None:
            return True
        return _stem(program) in (self.program, _stem(self.name))

    @property
    def words(self) -> str:
        """What it is called, with the prediction's number."""
        return f"job '{self.name}' (prediction {self.prediction})"


def _stem(file: str) -> str:
    """Return what a program is called: without folder and ending; O0012 is 12."""
    stem = PurePath(file.replace("\\", "/")).stem.casefold()
    number = re.fullmatch(r"o?0*(\d+)", stem)
    return stem if number is None else number[1]


def asked_jobs(session: Session, machine_id: int) -> list[AskedJob]:
    """Return the jobs that were predicted for a machine, the newest prediction first."""
    row = models.Prediction
    rows = session.execute(
        select(
            row.id,
            row.created_at,
            *(row.job[key].as_string() for key in ("name", "material", "tool")),
            row.job[("program", "file")].as_string(),
        )
        .where(row.machine_id == machine_id)
        .order_by(row.id.desc())
    )
    return [
        AskedJob(number, at, name, (material, tool), None if file is None else _stem(file))
        for number, at, name, material, tool, file in rows
    ]


def newest_before(jobs: Sequence[AskedJob], moment: str) -> list[AskedJob]:
    """Return of each job the newest prediction made before a moment, ISO 8601 in UTC."""
    found: dict[tuple[str, tuple[str, str]], AskedJob] = {}
    for job in jobs:
        if job.created_at <= moment:
            found.setdefault((job.name, job.pair), job)
    return list(found.values())


class AskedCuts:
    """The cuts of one stored prediction."""

    def __init__(self, session: Session, prediction: int) -> None:
        self._session = session
        self.row = session.get_one(models.Prediction, prediction)
        tool = self.row.job["tool"]
        its = session.scalar(select(models.Tool).where(models.Tool.name == tool))
        self._tool = ToolOf(tool, geometry_known(tool) if its is None else numbers_of(its))
        stated = [JobCut.model_validate(one) for one in self.row.job.get("cut", ())]
        self.cuts = [
            self._of_cut(cut, answer) for cut, answer in zip(stated, self.row.cuts, strict=False)
        ] or [_of_line(answer) for answer in self.row.cuts]

    def _of_cut(self, cut: JobCut, answer: Mapping[str, Any]) -> CutOfJob:
        conditions = cut.conditions(self._tool.diameter_mm)
        end_mm, time_s = cut.end_diameter_mm, answer.get("time_s")
        return CutOfJob(cut.name, cut.operation, conditions, end_mm=end_mm, time_s=time_s)

    def called(self, place: int) -> str:
        """Return what a cut is called, its number where it has no name."""
        return self.cuts[place].name or f"cut {place + 1}"

    def knew(self, cuts: Sequence[int]) -> set[int]:
        """Return which cuts, by id, the prediction had learnt already."""
        prior = self.row.prior
        rows = [*self.row.parameters, *([] if prior is None else prior.parameters)]
        query = (
            select(models.SensedForce.cut_id)
            .join(models.CuttingParameters.forces)
            .where(
                models.CuttingParameters.id.in_(chain_ids(rows)),
                models.SensedForce.cut_id.in_(cuts),
            )
        )
        return set(self._session.scalars(query))

    @property
    def errors(self) -> set[str]:
        """Keys of the errors of sensing that its posteriors hold, as far as the pair was learnt."""
        rows = [] if self.row.started_from is not None else self.row.parameters
        return {one["key"] for row in rows for one in row.shared or ()}

    def expected(self, place: int, made: MadeCut) -> dict[str, list[float]]:
        """Return by channel what was predicted of a cut, as [value, low, high], as it was made.

        Feed, speed and depth are what happened: the stored answer is moved by the share by which
        the law's forces differ from those at what was asked for. Empty where that is too far.
        """
        stored, asked = self.row.cuts[place], self.cuts[place]
        found = {one.channel: stored[one.field] for one in QUANTITIES if stored[one.field]}
        values = {name: [one["value"], one["low"], one["high"]] for name, one in found.items()}
        if asked.of_program:
            return values if _fed_alike(asked, made) else {}
        happened = _happened(asked.conditions, made.conditions)
        if happened is None or not overridden_alike(asked, made):
            return {}
        posterior = self._posterior(stored.get("state"))
        if posterior.wear is None:
            happened.pop(CUTTING_TIME, None)
        if not _differs(happened, asked.conditions):
            return values
        rows = [asked.conditions, happened]
        cuts = BY_NAME[asked.operation].cuts(self._tool.numbers, rows, called=self._tool.name)
        then, now = expected_means(posterior, cuts).tolist()
        moved = {}
        for one, before, after in zip(QUANTITIES, then, now, strict=True):
            if one.channel in values and abs(before) > SMALL and 1 / FAR < after / before < FAR:
                moved[one.channel] = [after / before * end for end in values[one.channel]]
        return moved

    def _posterior(self, state: str | None) -> PairPosterior:
        """Return the posterior that a cut was predicted from; of a card, what stands in for it."""
        for row in self.row.parameters:
            if row.state == state:
                return as_posterior(row)
        material, tool = self.row.job["material"], self.row.job["tool"]
        return start_of(self._session, self.row.machine_id, material, tool).posterior


def _of_line(answer: Mapping[str, Any]) -> CutOfJob:
    """Return a line of a program, or several, of which the answer alone says how they cut."""
    conditions = {RPM: answer["speed_rpm"]}
    ends_mm = [(answer.get(end) or {}).get("diameter_mm") for end in ("start", "end")]
    feed_mm_min = answer.get("feed_mm_min")
    if answer["operation"] not in BANDS and feed_mm_min and ends_mm[0] == ends_mm[1]:
        conditions[FEED] = feed_mm_min / answer["speed_rpm"]
    return CutOfJob(
        answer["name"],
        answer["operation"],
        conditions,
        block=_block(answer["name"]),
        time_s=answer.get("time_s"),
        of_program=True,
    )


def _fed_alike(asked: CutOfJob, made: MadeCut) -> bool:
    """Say whether a line was made at its feed, as far as both are known."""
    if FEED not in asked.conditions or FEED not in made.conditions:
        return True
    return abs(made.conditions[FEED] - asked.conditions[FEED]) <= FED * asked.conditions[FEED]


def _block(name: str) -> int | None:
    """Return the line of a program that a predicted cut is called after."""
    number = name.removeprefix("line ").split(":", maxsplit=1)[0]
    return int(number) if number.isdecimal() else None


def _happened(asked: Conditions, made: Conditions) -> dict[str, float] | None:
    """Return the conditions of a cut as it was made; None: too far from those asked for."""
    found = dict(asked)
    for name in (FEED, DEPTH, WIDTH):
        if name in asked and name in made:
            if not OVERRIDE[0] * asked[name] <= made[name] <= OVERRIDE[1] * asked[name]:
                return None
            found[name] = made[name]
    speed = RPM if RPM in made else SPEED
    faster = made[speed] / asked[speed] if speed in made else 1.0
    found |= {RPM: faster * asked[RPM], SPEED: faster * asked[SPEED]}
    return found | ({CUTTING_TIME: made[CUTTING_TIME]} if CUTTING_TIME in made else {})


def _differs(made: Conditions, asked: Conditions) -> bool:
    return any(
        abs(value - asked.get(name, 0.0)) > UNCHANGED * max(abs(value), SMALL)
        for name, value in made.items()
    )


def as_made(cut: models.Cut, *, called: str | None = None) -> MadeCut:
    """Return a stored cut as one that was made; ``called``: which of its job's cuts it is."""
    said = cut.named or {}
    known = recorded_conditions(cut)
    conditions = {k: v for k, v in known.items() if isinstance(v, int | float)}
    made = MadeCut(operation_of(cut), conditions, said.get("cut"), said.get("block"))
    return made if called is None else replace(made, name=called)
