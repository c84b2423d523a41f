"""What a machine has learnt of its pairs, as a file of coefficients for other programs."""

import numpy as np
from sqlalchemy import select
from sqlalchemy.orm import Session

from autodb import __version__
from autodb.agent.answer.looking_up import Listed, PairReader
from autodb.agent.answer.made_cards import rake_deg
from autodb.agent.learn.learnt_from import learnt_from
from autodb.agent.rows.posteriors import LAW
from autodb.cutting.kienzle import ViewRange
from autodb.cutting.shear import PARAMETERS
from autodb.errors import UnusableInput
from autodb.files import coefficients
from autodb.files.tool import ISO_13399, Geometry
from autodb.fitting.gaussian import Gaussian
from autodb.pairs.card import Bounded, kienzle_card, linear_coefficients
from autodb.pairs.posterior import OWN
from autodb.store import models
from autodb.wording import phrase

UNITS = {"K_tc": "N/mm^2", "K_rc": "N/mm^2", "K_te": "N/mm", "K_re": "N/mm"}


def machine_coefficients(
    session: Session, machine: str, material: str | None = None, tool: str | None = None
) -> coefficients.Coefficients:
    """Return the newest coefficients of the pairs that a machine has learnt.

    Raises UnusableInput where the machine, or the material or tool, is not known, or it has learnt
    no pair.
    """
    pair_reader = PairReader(session, machine)
    listed = pair_reader.pairs(material, tool)
    if not listed:
        raise UnusableInput(
            phrase(
                "machine '{machine}' has no fitted work-tool pair; run 'autodb refresh "
                "--machine {machine}'",
                machine=machine,
            )
        )
    return coefficients.Coefficients(
        autodb=__version__,
        written_at=models.now(),
        machine=machine,
        pairs=[_pair(session, pair_reader, one) for one in listed],
    )


def _pair(
    session: Session, pair_reader: PairReader, listed: Listed
) -> coefficients.PairCoefficients:
    known = pair_reader.known(listed.material, listed.tool)
    behind = learnt_from(session, known.behind.parameters or 0)
    row = session.scalars(select(models.Tool).where(models.Tool.name == listed.tool)).one()
    law = known.posterior.law
    at = ViewRange(rake_rad=float(np.radians(rake_deg(session, known))))
    return coefficients.PairCoefficients(
        material=listed.material,
        tool=tool_of(row),
        version=listed.version,
        learnt_at=listed.learnt_at,
        learnt_from=coefficients.CutsBehind(
            cuts=listed.cuts,
            operations=sorted(behind.operations),
            ranges=dict(sorted(behind.ranges.items())),
        ),
        orthogonal_edge=coefficients.OrthogonalEdge(
            rake_deg=float(np.degrees(at.rake_rad)),
            speed_m_min=at.speed_m_min,
            thinnest_mm=at.thinnest_mm,
            thickest_mm=at.thickest_mm,
            linear={
                name: _bounds(one, UNITS[name])
                for name, one in linear_coefficients(law, at).items()
            },
            kienzle=_kienzle(law, at),
        ),
        law=coefficients.LawCoefficients(
            name=LAW,
            numbers=[one.name for one in PARAMETERS],
            units=[one.unit for one in PARAMETERS],
            coordinates=[one.coordinate for one in PARAMETERS],
            mean=law.mean[:OWN].tolist(),
            covariance=law.covariance[:OWN, :OWN].tolist(),
        ),
    )


def _kienzle(law: Gaussian, at: ViewRange) -> dict[str, coefficients.BoundedValue]:
    try:
        card = kienzle_card("", law, at, source="")
    except UnusableInput:  # k_c grows with the chip: there is no such card
        return {}
    low, high = card.m_c_bounds or (card.m_c, card.m_c)
    return {
        "k_c1.1": _bounds(card.k_c11, "N/mm^2"),
        "m_c": _bounds(Bounded(card.m_c, low, high), "1"),
    }


def _bounds(one: Bounded, unit: str) -> coefficients.BoundedValue:
    return coefficients.BoundedValue(value=one.value, lower=one.lower, upper=one.upper, unit=unit)


def tool_of(row: models.Tool) -> coefficients.ToolCoefficients:
    """Return a tool of the database with what is known of it, by code where it has one."""
    coded = {code.ours[row.kind]: code.symbol for code in ISO_13399 if row.kind in code.ours}
    known = {
        name: value
        for name in Geometry.model_fields
        if (value := getattr(row, name, None)) is not None
    }
    said = {
        "name": row.name,
        "kind": row.kind,
        "iso13399": {coded[name]: value for name, value in known.items() if name in coded},
        "geometry": {name: value for name, value in known.items() if name not in coded},
    }
    return coefficients.ToolCoefficients.model_validate(said)
