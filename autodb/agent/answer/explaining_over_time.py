"""Recordings over time against a machine's models: drives of its axes, forces of its pair."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from sqlalchemy.orm import Session

from autodb.agent.answer.mill_simulation import HAS, expected_waves, known_pair
from autodb.agent.learn.known import KnownPair
from autodb.agent.sense.identifying import newest_model, off_law_of, stored_terms
from autodb.errors import UnusableInput
from autodb.explain import Explained, explain
from autodb.files.channels import FORCES, effort_channels
from autodb.records.tables import Recording
from autodb.sensing.drives.feed_axis import predict_effort
from autodb.store import models
from autodb.terms.vocabulary import RUNOUT
from autodb.wording import phrase

Array = NDArray[np.float64]


def explain_over_time(session: Session, owner: models.Machine, recording: Recording) -> Explained:
    """Explain a recording's drives against their models, its forces against its pair's posterior.

    Raises UnusableInput where the machine has neither.
    """
    simulated, parts = _simulate_axes(session, owner.id, recording)
    forces = any(name in recording for name in FORCES)
    if not simulated and not forces:
        raise UnusableInput(
            phrase(
                "{file}: the machine has no model of its axes; identify them with 'autodb "
                "identify'",
                file=recording.path,
            )
        )
    found = []
    if simulated:
        found.append(explain(recording, _as_simulation(recording, simulated), includes=parts))
    if forces:
        try:
            known = known_pair(session, owner, recording)
        except UnusableInput as error:
            if not found:
                raise
            found[0] = replace(found[0], notes=(*found[0].notes, f"forces not explained: {error}"))
        else:
            found.append(_waves(known, recording))
    return _joined(found)


def _waves(known: KnownPair, recording: Recording) -> Explained:
    """Explain a recording's forces against its pair's posterior."""
    waves = expected_waves(known, recording)
    made = _as_simulation(waves.measured, waves.forces_N)
    has = [*HAS, *([RUNOUT.name] if known.tool.numbers.get("runout_mm") else [])]
    explained = explain(waves.measured, made, includes=has)
    return replace(explained, notes=(*waves.notes, *explained.notes))


def _joined(found: list[Explained]) -> Explained:
    """Return explanations of channels of one recording as one."""
    channels = {n: a for one in found for n, a in one.explanation.channels.items()}
    return Explained(
        found[0].explanation.model_copy(update={"channels": channels}),
        {name: trace for one in found for name, trace in one.traces.items()},
        tuple(note for one in found for note in one.notes),
        {name: values for one in found for name, values in one.rows.items()},
    )


def _as_simulation(recording: Recording, simulated: dict[str, Array]) -> Recording:
    channels = {"t": recording.t_s, **simulated}
    return replace(recording, channels=channels, unusable={}, units={}, as_written=None)


def _simulate_axes(
    session: Session, machine_id: int, recording: Recording
) -> tuple[dict[str, Array], dict[str, dict[str, Array]]]:
    """Return what the newest channel models give for the recording's motion, and each term's part.

    A term's part is what would go with it. A term that no move excited has no number and gives
    nothing: it has no part.
    """
    found: dict[str, Array] = {}
    parts: dict[str, dict[str, Array]] = {}
    for channel in effort_channels(list(recording.channels)):
        model = newest_model(session, machine_id, channel)
        if model is not None:
            terms = stored_terms(model)
            alone = predict_effort(recording, model.axis, terms)
            found[channel] = predict_effort(recording, model.axis, terms, off_law_of(model))
            parts[channel] = {
                name: alone
                - predict_effort(recording, model.axis, [t for t in terms if t.term != name])
                for name in sorted({t.term for t in terms if t.sd is not None})
            }
    return found, parts
