"""The one answer of all sensors that feel a recording's forces, and which of them gave it."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from autodb.agent.rows.estimators import FUSION, newest
from autodb.agent.rows.machines import find_machine
from autodb.agent.sense.dynamometers import forces_on_table, table_on_machine
from autodb.agent.sense.networks import KIND as LSTM
from autodb.agent.sense.networks import forces_on_machine
from autodb.agent.sense.reconstructing import ReconstructedLoad, reconstruct_on_machine
from autodb.errors import UnusableInput, behind_name
from autodb.explain import explain
from autodb.records.tables import Recording
from autodb.sensing.fusion import (
    DRIVE,
    NETWORK,
    TABLE,
    Apart,
    Fusion,
    SensedTogether,
    disagreeing,
    fuse,
    independent,
    trusting_less,
    with_sensor,
)
from autodb.store import Store
from autodb.wording import listed, localized, phrase

Array = NDArray[np.float64]

DRIVE_HZ = 10.0
"""Frequency up to which drive models are looked at where no network says another."""


@dataclass(frozen=True)
class FusedComponents:
    """Forces put together, a component each; ``not_heard``: which sensors told nothing, and why."""

    sensed: list[ReconstructedLoad]
    not_heard: tuple[str, ...]


def fused_on_machine(
    store: Store,
    machine: str,
    recording: Recording,
    *,
    bandwidth_hz: float | None = None,
    progress: Callable[[str], None],
) -> FusedComponents:
    """Return the forces of all sensors that a machine has, put together, component by component.

    Drive models and networks by what was learnt of both where the force was known; others as they
    say of themselves, up to the frequency up to which all tell it. A sensor that does not agree
    with the others counts less, and it is said what of it is off.

    Raises UnusableInput where none senses.
    """
    heard, not_heard = _heard(store, machine, recording, bandwidth_hz, progress)
    components = [c for c in "xyz" if any(c in one for one in heard.values())]
    if not components:
        raise UnusableInput(
            phrase(
                "{file}: no sensor measures its forces: {names}",
                file=recording.path,
                names=listed(not_heard, "; "),
            )
        )
    with store.reading() as session:
        rows = newest(session, find_machine(session, machine).id, FUSION)
        learnt = {row.component: Fusion.of_json(row.model or {}) for row in rows}
    sensed = []
    for c in components:
        by_name = {name: one[c] for name, one in heard.items() if c in one}
        progress(f"fusing the sensors of force.{c}")
        sensed.append(fuse_component(recording, c, by_name, learnt.get(c)))
    return FusedComponents(sensed, tuple(not_heard))


ByAxis = dict[str, ReconstructedLoad]


def _heard(
    store: Store,
    machine: str,
    recording: Recording,
    bandwidth_hz: float | None,
    progress: Callable[[str], None],
) -> tuple[dict[str, ByAxis], list[str]]:
    """Return what each sensor of the machine tells, by component, and why others tell nothing."""
    with store.reading() as session:
        owner = find_machine(session, machine)
        has_network = bool(newest(session, owner.id, LSTM))
        has_table = table_on_machine(session, owner) is not None
    found: dict[str, ByAxis] = {}
    not_heard: list[str] = []

    def hear(name: str, listen: Callable[[], list[ReconstructedLoad]]) -> None:
        try:
            told = listen()
        except UnusableInput as error:
            not_heard.append(behind_name(name, error.line))
            return
        found[name] = {one.load.axis: one for one in told if one.load.unit == "N"}
        if not found[name]:
            not_heard.append(phrase("{name}: its force constant (N/A) is not known", name=name))

    if has_network:
        hear(NETWORK, lambda: forces_on_machine(store, machine, recording, progress=progress))
    networks = found.get(NETWORK, {}).values()
    hz = bandwidth_hz or max((one.load.bandwidth_hz for one in networks), default=DRIVE_HZ)
    hear(
        DRIVE,
        lambda: reconstruct_on_machine(
            store, machine, recording, axis=None, bandwidth_hz=hz, observer=False, progress=progress
        ),
    )
    if has_table:
        # What teeth do beyond the band of the others is no disagreement
        band_hz = hz if found else bandwidth_hz
        hear(TABLE, lambda: forces_on_table(store, machine, recording, bandwidth_hz=band_hz))
    return found, not_heard


def fuse_component(
    recording: Recording,
    component: str,
    by_name: Mapping[str, ReconstructedLoad],
    learnt: Fusion | None,
) -> ReconstructedLoad:
    """Return one component's force of what each sensor sensed, by the sensors' names.

    ``learnt``: how some of them go together. A sensor that does not agree counts less.
    """
    names = [name for name in (DRIVE, NETWORK, TABLE) if name in by_name]
    fusion = _fusion(names, learnt)
    loads = [by_name[name].load for name in fusion.names]
    told = SensedTogether(
        np.column_stack([-load.value for load in loads]),
        np.column_stack([load.sd for load in loads]),
    )
    apart = disagreeing(fusion, told)
    disagrees = None
    if apart is not None:
        disagrees = _words(recording, fusion, told, component, apart)
        fusion = trusting_less(fusion, apart)
    made = fuse(fusion, told)
    weights = dict(zip(fusion.names, made.weight.T, strict=True))
    shares = sorted(((float(one.mean()), name) for name, one in weights.items()), reverse=True)
    weighed = ", ".join(f"{100.0 * s:.0f} % {name}" for s, name in shares)
    said = phrase("by weight {shares}", shares=weighed)
    said = said if disagrees is None else listed([said, disagrees], "; ")
    first = by_name[names[0]].load
    load = replace(
        first, unit="N", value=-made.value_N, sd=made.sd_N,
        bandwidth_hz=min(one.bandwidth_hz for one in loads),
    )  # fmt: skip
    sources = listed((by_name[name].model for name in names), "; ")
    shared = float(sum(weights[name].mean() * by_name[name].share for name in names))
    return ReconstructedLoad(
        load, sources, None, said=said, share=shared, weight=weights, disagrees=disagrees
    )  # fmt: skip


def _fusion(names: Sequence[str], learnt: Fusion | None) -> Fusion:
    """Return how these sensors go together: as learnt where all that was is here."""
    if learnt is None or not set(learnt.names) <= set(names):
        return independent(names)
    fusion = learnt
    for name in names:
        if name not in fusion.names:
            fusion = with_sensor(fusion, name)
    return fusion


def _words(
    recording: Recording, fusion: Fusion, told: SensedTogether, component: str, apart: Apart
) -> str:
    """Say which sensor does not agree and what of it is off, by ``explain``."""
    if len(apart.names) > 1:
        return phrase(
            "{names} do not agree, {factor} × further apart than usual; two sensors alone "
            "cannot decide which is wrong; use a dynamometer or a standard cut",
            names=listed(apart.names, phrase(" and ")),
            factor=localized(f"{apart.factor:.1f}"),
        )
    (name,) = apart.names
    causes = _causes(recording, fusion, told, component, name)
    return phrase(
        "{name} does not agree with the others, {factor} × further than usual, and "
        "gets less weight: {causes}",
        name=name,
        factor=localized(f"{apart.factor:.1f}"),
        causes=causes,
    )


def _causes(
    recording: Recording, fusion: Fusion, told: SensedTogether, component: str, name: str
) -> str:
    """Return what ``explain`` finds of a sensor's load where the others' is the simulation."""
    k = fusion.names.index(name)
    value = told.value_N.copy()
    value[:, k] = np.nan
    others = fuse(
        replace(fusion, counts=(True,) * len(fusion.names)), SensedTogether(value, told.sd_N)
    )
    channel = f"{component}.drive_force"
    moved = {n: v for n, v in recording.channels.items() if n == "t" or _is_motion(n, component)}
    plain = replace(recording, unusable={}, units={}, as_written=None)
    seen = replace(plain, channels=moved | {channel: -told.value_N[:, k]})
    expected = replace(plain, channels={"t": recording.t_s, channel: -others.value_N})
    try:
        answer = explain(seen, expected).explanation.channels[channel]
    except UnusableInput as error:
        return phrase("the cause cannot be determined ({error})", error=error.line)
    terms = dict.fromkeys(one.term for one in answer.missing)
    if not terms:
        return phrase("explain finds no cause that it names")
    return phrase("explain says {terms}", terms=", ".join(terms))


def _is_motion(name: str, component: str) -> bool:
    return name in {f"{component}.{what}" for what in ("position", "velocity", "acceleration")}
