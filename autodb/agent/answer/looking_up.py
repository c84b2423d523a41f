"""Look up: forces, torque and power of one cut of a pair, and which pairs a machine has.

Nothing is stored. A pair that the machine has learnt takes one query, by indices; of its posterior
the JSON text is read as it lies in the row. Every other pair is found as `autodb predict` finds it.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from pydantic_core import from_json
from sqlalchemy import ColumnElement, Executable, Row, Select, Text, bindparam, cast, select
from sqlalchemy.orm import Session

from autodb.agent.answer.in_state import others_of
from autodb.agent.answer.prediction_basis import (
    LookedUp,
    PredictionBasis,
    Stamp,
    prediction_basis_of,
)
from autodb.agent.answer.undecided_causes import open_causes
from autodb.agent.learn.known import Behind, KnownPair, known_of
from autodb.agent.matching.past_predictions import width_of_next
from autodb.agent.rows.catalogue import GEOMETRY, geometry_known
from autodb.agent.rows.machines import owner_named
from autodb.agent.rows.posteriors import LAW, posterior_of
from autodb.errors import UnusableInput, near_words
from autodb.files.job_cut import JobCut
from autodb.forward.prediction import ToolOf
from autodb.store import models
from autodb.wording import phrase

_PARAMETERS, _PAIR, _MATERIAL, _TOOL = map(
    models.table_of, (models.CuttingParameters, models.Pair, models.Material, models.Tool)
)
_JSON = ("mean", "covariance", "shared", "scatter", "terms")
_NUMBERS = ("id", "version", "n_cuts", "started_from")


@dataclass(frozen=True)
class Listed:
    """A pair that a machine has: the newest version of its posterior, its cuts, and when."""

    material: str
    tool: str
    cuts: int
    version: int
    learnt_at: str


class PairReader:
    """What the database holds of one machine, read in one session. Raises UnusableInput for an
    unknown machine."""

    def __init__(self, session: Session, machine: str) -> None:
        self._session = session
        self._owner = owner_named(session, machine)

    def look_up(self, material: str, tool: str, cut: JobCut, *, lot: str | None = None) -> LookedUp:
        """Return what a cut of a pair, or of one lot of its material, will take.

        Raises UnusableInput where the tool cannot make it, or the pair was learnt under an earlier
        law only.
        """
        return self.basis(material, tool).of_lot(lot).look_up(cut)

    def basis(self, material: str, tool: str) -> PredictionBasis:
        """Return what answers about a pair rest on; raises UnusableInput as ``known`` does."""
        known = self.known(material, tool)
        return prediction_basis_of(self._session, self._owner, material, known)

    def stamp(self, material: str, tool: str) -> Stamp | None:
        """Return what answers about a pair depend on; None where the pair is not learnt."""
        asked = {"machine": self._owner.id, "material": material, "tool": tool, "law": LAW}
        row = self._session.connection().execute(_NEWEST, asked).first()
        if row is None:
            return None
        number, *geometry = tuple[Any, ...](row)
        others = others_of(self._session, number)
        width = width_of_next(self._session, self._owner.id, (material, tool), learnt=True)
        waiting = open_causes(self._session, number)
        return Stamp(
            number, others, geometry_known(tool, geometry), self._owner.limits, width, waiting
        )

    def known(self, material: str, tool: str) -> KnownPair:
        """Return what the database holds of the machine's pair, learnt or not.

        Raises UnusableInput where the pair was learnt under an earlier law only.
        """
        asked = {"machine": self._owner.id, "material": material, "tool": tool, "law": LAW}
        row = self._session.connection().execute(_LEARNT, asked).first()
        if row is None:
            return known_of(self._session, self._owner, material, tool)
        return _as_known(row, tool)

    def pairs(self, material: str | None = None, tool: str | None = None) -> list[Listed]:
        """Return the pairs that the machine has learnt, all or those of a material or a tool.

        Raises UnusableInput naming near ones where it has none of that name.
        """
        rows = (
            self._session.connection()
            .execute(_LISTED, {"machine": self._owner.id, "law": LAW})
            .all()
        )
        listed = [Listed(*row) for row in rows]
        self._refuse_unknown("material", material, {one.material for one in listed})
        self._refuse_unknown("tool", tool, {one.tool for one in listed})
        return [
            one for one in listed if material in (None, one.material) and tool in (None, one.tool)
        ]

    def _refuse_unknown(self, what: str, name: str | None, known: set[str]) -> None:
        if name is None or name in known:
            return
        hint = near_words(name, sorted(known)) if known else phrase("; run 'autodb refresh'")
        raise UnusableInput(
            phrase(
                "machine '{owner}' has no parameters of a pair with {what} '{name}'{hint}",
                owner=self._owner.name,
                what=what,
                name=name,
                hint=hint,
            )
        )


def _as_known(row: Row[Any], tool: str) -> KnownPair:
    number, version, cuts, started_from, *rest = tuple[Any, ...](row)
    kept: list[Any] = [None if text is None else from_json(text) for text in rest[: len(_JSON)]]
    posterior = posterior_of(*kept, cuts=cuts)
    called = ToolOf(tool, geometry_known(tool, rest[len(_JSON) :]))
    return KnownPair(posterior, called, Behind(number, version, cuts, started_from), None)


def _usual(table: Any) -> Sequence[ColumnElement[bool]]:
    """Return which versions are a machine's posteriors in the usual state of its pairs."""
    return (
        table.machine_id == bindparam("machine"),
        table.law == bindparam("law"),
        table.state.is_(None),
        table.undone_at.is_(None),
    )


def _of_pairs(*columns: Any) -> Select[Any]:
    """Return a query of versions, each with its pair's material and tool."""
    return (
        select(*columns)
        .select_from(_PARAMETERS)
        .join(_PAIR, _PAIR.c.id == _PARAMETERS.c.pair_id)
        .join(_MATERIAL, _MATERIAL.c.id == _PAIR.c.material_id)
        .join(_TOOL, _TOOL.c.id == _PAIR.c.tool_id)
    )


def _newest(*columns: Any) -> Select[Any]:
    """Return the query of a pair's newest posterior, with its tool's geometry."""
    return (
        _of_pairs(*columns, *(_TOOL.c[name] for name in GEOMETRY))
        .where(
            _MATERIAL.c.name == bindparam("material"),
            _TOOL.c.name == bindparam("tool"),
            *_usual(_PARAMETERS.c),
        )
        .order_by(_PARAMETERS.c.version.desc())
        .limit(1)
    )


def _listed() -> Executable:
    """Return the query of the newest posterior of every pair, by material and tool.

    Of each pair the newest version is looked for, from the last one backwards: whether a version
    counts stands behind its covariance, so that to look at all of them reads nearly all of them.
    """
    own, other = _PARAMETERS.c, _PARAMETERS.alias().c
    learnt = select(own.pair_id).where(own.machine_id == bindparam("machine")).distinct().subquery()
    newest = (
        select(other.id)
        .where(other.pair_id == learnt.c.pair_id, *_usual(other))
        .order_by(other.version.desc())
        .limit(1)
        .correlate(learnt)
        .scalar_subquery()
    )
    return (
        select(_MATERIAL.c.name, _TOOL.c.name, own.n_cuts, own.version, own.created_at)
        .select_from(learnt)
        .join(_PARAMETERS, own.id == newest)
        .join(_PAIR, _PAIR.c.id == learnt.c.pair_id)
        .join(_MATERIAL, _MATERIAL.c.id == _PAIR.c.material_id)
        .join(_TOOL, _TOOL.c.id == _PAIR.c.tool_id)
        .order_by(_MATERIAL.c.name, _TOOL.c.name)
    )


_NEWEST = _newest(_PARAMETERS.c.id)
_LEARNT = _newest(
    *(_PARAMETERS.c[name] for name in _NUMBERS),
    *(cast(_PARAMETERS.c[name], Text) for name in _JSON),
)
_LISTED = _listed()
