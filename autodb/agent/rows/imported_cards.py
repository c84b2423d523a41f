"""Material cards in the database: handbook values of a material that a user brought.

A card is kept as six conventional parameters of its material and source: the two numbers with their
bounds, and where they hold. A card of the same source replaces it.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime

import numpy as np
from sqlalchemy import select
from sqlalchemy.orm import Session

from autodb.agent.rows.catalogue import find_or_add
from autodb.cutting.kienzle import ViewRange
from autodb.pairs.card import UNIT, Bounded, KienzleCard
from autodb.pairs.handbook.material_groups import plain_name
from autodb.store import Store, models
from autodb.store.models.learning import EVERY

TANGENTIAL = "y"
"""The component that Kienzle's numbers are of."""
STATUS = "imported card"
K_C11, M_C = "k_c1.1", "m_c"
HOLDS = (
    ("rake_deg", "deg"), ("speed_m_min", "m/min"), ("thinnest_mm", "mm"), ("thickest_mm", "mm"),
)  # fmt: skip
"""Where a card holds, and in what units."""


@dataclass(frozen=True)
class ImportedCard:
    """What became of a card: ``replaced`` says what differed from the one of its source before."""

    material: str
    source: str
    already_there: bool
    replaced: tuple[str, ...]


def keep_cards(store: Store, cards: Sequence[KienzleCard]) -> list[ImportedCard]:
    """Keep cards, all or none."""
    with store.writing() as session:
        return [_keep(session, card) for card in cards]


def made_by(machine: str) -> str:
    """Return what the source of a card begins with that a machine's own posterior made."""
    return f"autodb: machine {machine}, "


def imported_card(session: Session, machine_id: int, material: str) -> KienzleCard | None:
    """Return the card of a material that was imported last; None where there is none for a machine.

    The name may be written in any case, with or without blanks and dashes. A card that the machine
    made itself adds no information: its cuts would count twice.
    """
    owner = session.get_one(models.Machine, machine_id)
    rows = session.scalars(
        select(models.ConventionalParameter)
        .where(
            models.ConventionalParameter.name == K_C11,
            models.ConventionalParameter.status == STATUS,
        )
        .order_by(models.ConventionalParameter.date.desc(), models.ConventionalParameter.id.desc())
    )
    names = {row.id: row.name for row in session.scalars(select(models.Material))}
    for row in rows:
        own = str(row.source).startswith(made_by(owner.name))
        if plain_name(names[row.material_id]) == plain_name(material) and not own:
            kept = _of_source(session, row.material_id, row.source)
            return _as_card(names[row.material_id], str(row.source), kept)
    return None


def _keep(session: Session, card: KienzleCard) -> ImportedCard:
    material = find_or_add(session, models.Material, card.material)
    before = _of_source(session, material.id, card.source)
    after = {row.name: row for row in _as_rows(card, material.id)}
    changes = tuple(_changes(before.values(), after)) if before else ()
    if before and not changes:
        return ImportedCard(card.material, card.source, already_there=True, replaced=())
    for row in before.values():
        session.delete(row)
    session.flush()
    session.add_all(after.values())
    return ImportedCard(card.material, card.source, already_there=False, replaced=changes)


def _of_source(
    session: Session, material_id: int, source: str | None
) -> dict[str, models.ConventionalParameter]:
    table = models.ConventionalParameter
    rows = session.scalars(
        select(table).where(
            table.material_id == material_id, table.source == source, table.status == STATUS
        )
    )
    return {row.name: row for row in rows}


def _changes(
    before: Iterable[models.ConventionalParameter],
    after: dict[str, models.ConventionalParameter],
) -> Iterable[str]:
    for was in before:
        now = after[was.name]
        if (was.value, was.lower, was.upper) != (now.value, now.lower, now.upper):
            yield f"{was.name} {_said(was)} → {_said(now)}"


def _said(row: models.ConventionalParameter) -> str:
    if row.lower is None or row.upper is None:
        return f"{row.value:g}"
    return f"{row.value:g} ({row.lower:g} to {row.upper:g})"


def _as_rows(card: KienzleCard, material_id: int) -> list[models.ConventionalParameter]:
    lower, upper = (None, None) if card.m_c_bounds is None else card.m_c_bounds
    rake_deg = round(float(np.degrees(card.at.rake_rad)), 9)  # as it was written
    at = (rake_deg, card.at.speed_m_min, card.at.thinnest_mm, card.at.thickest_mm)
    values = [
        (K_C11, UNIT, card.k_c11.value, card.k_c11.lower, card.k_c11.upper),
        (M_C, "1", card.m_c, lower, upper),
        *((name, unit, value, None, None) for (name, unit), value in zip(HOLDS, at, strict=True)),
    ]
    today = datetime.now(UTC).date().isoformat()
    return [
        models.ConventionalParameter(
            material_id=material_id,
            operation=EVERY,
            component=TANGENTIAL,
            name=name,
            unit=unit,
            value=value,
            lower=low,
            upper=high,
            source=card.source,
            status=STATUS,
            date=today,
        )
        for name, unit, value, low, high in values
    ]


def _as_card(
    material: str, source: str, kept: dict[str, models.ConventionalParameter]
) -> KienzleCard:
    size, m_c = kept[K_C11], kept[M_C]
    rake_deg, speed_m_min, thinnest_mm, thickest_mm = (kept[name].value for name, _ in HOLDS)
    bounds = None if m_c.lower is None or m_c.upper is None else (m_c.lower, m_c.upper)
    lower = size.value if size.lower is None else size.lower
    upper = size.value if size.upper is None else size.upper
    return KienzleCard(
        material=material,
        k_c11=Bounded(size.value, lower, upper),
        m_c=m_c.value,
        m_c_bounds=bounds,
        at=ViewRange(thinnest_mm, thickest_mm, speed_m_min, float(np.radians(rake_deg))),
        source=source,
    )
