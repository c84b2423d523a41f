"""Training a grey box on recordings whose forces were known, and how sure it may be."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from autodb.fitting.gaussian import NORMAL_95
from autodb.sensing.network.coherent import coherent_hz
from autodb.sensing.network.drive_loads import AxisTables, LoadedDrive, SeenAxis
from autodb.sensing.network.greybox import (
    LATER,
    LEAST_SD,
    LOG_SD,
    Channels,
    GreyBox,
    KnownForceRecording,
    NetworkScaling,
    loads_of,
    seen_of,
)
from autodb.sensing.network.network import Shape, Stacked
from autodb.sensing.network.stream import network_forces
from autodb.sensing.network.training import TrainingPlan, TrainingRows, trained

Array = NDArray[np.float64]

CELLS, LAYERS, MEMBERS = 32, 2, 3
"""Size and number of the networks. Chosen."""
PLAN = TrainingPlan(epochs=12, rate=5e-3, window=500, lead=50, batch=32, seed=1)
"""Of many recordings; of few ones ``plan_of`` has smaller batches and more epochs."""
STEPS = 500
"""Steps of Adam that training takes at least. Chosen: about those of P0's 160 recordings."""
BETA = 0.5
LEFT_OUT = 8
"""Every so many recordings one is not trained on, but tells how far off the others are."""


def loss(made: Tensor, wanted: Tensor) -> Tensor:
    """Return the Gaussian loss (…, m) of means and log sds (…, 2 m), weighted by variance^β."""
    mean, log_sd = made.chunk(2, dim=-1)
    sd = LEAST_SD + torch.exp(log_sd.clamp(*LOG_SD))
    told = torch.log(sd) + 0.5 * ((wanted - mean) / sd) ** 2
    return told * sd.detach() ** (2.0 * BETA)


def plan_of(recordings: Sequence[KnownForceRecording], plan: TrainingPlan = PLAN) -> TrainingPlan:
    """Return a plan by which so many rows are trained on in STEPS steps at least."""
    rows = sum(len(next(iter(one.channels.values()))) for one in recordings)
    count = max(rows // plan.window, 1)
    batch = min(plan.batch, max(4, count // 8))
    return replace(plan, batch=batch, epochs=max(plan.epochs, -(-STEPS * batch // count)))


def train_grey_box(
    recordings: Sequence[KnownForceRecording],
    drives: Mapping[str, LoadedDrive],
    *,
    rate_hz: float,
    plan: TrainingPlan | None = None,
    folder: Path | None = None,
    device: str = "cpu",
    progress: Callable[[int, int, float], None] = lambda _member, _epoch, _loss: None,
) -> GreyBox:
    """Return a grey box trained on recordings with known forces, as ``plan_of`` says if not told.

    Where none of the forces is anything but 0 it is trained on air. ``folder``: where training is
    kept to go on from; ``progress`` is told member, epochs done and their loss.
    """
    plan = plan or plan_of(recordings)
    box = _untrained(recordings, drives, rate_hz)
    tables = box.tables(drives)
    loads = [loads_of(tables, one.channels) for one in recordings]
    shown = [box.shown(load, one.channels) for load, one in zip(loads, recordings, strict=True)]
    left = [
        np.column_stack([one.force_N[c] + load[c] for c in box.components])
        for load, one in zip(loads, recordings, strict=True)
    ]
    scaled = _scaled(shown, left)
    others = held_out_recordings(len(recordings))
    sequences = [
        TrainingRows(*_later((x - scaled.middle) / scaled.size, r / scaled.told_N))
        for k, (x, r) in enumerate(zip(shown, left, strict=True))
        if k not in others
    ]
    every = np.concatenate(shown)
    box = replace(
        box,
        low=every.min(axis=0),
        high=every.max(axis=0),
        scaled=scaled,
        members=_members(sequences, plan, folder, device, progress),
        cutoff_hz=_coherent(box, loads, recordings),
    )
    return replace(box, wider=_wider(box, [recordings[k] for k in others], tables))


def _members(
    sequences: Sequence[TrainingRows],
    plan: TrainingPlan,
    folder: Path | None,
    device: str,
    progress: Callable[[int, int, float], None],
) -> tuple[Stacked, ...]:
    """Return networks trained alike, from seeds of their own."""
    inputs, outputs = sequences[0].inputs.shape[1], 2 * sequences[0].targets.shape[1]
    return tuple(
        trained(
            sequences,
            Shape(inputs, outputs, CELLS, LAYERS),
            replace(plan, seed=plan.seed + number),
            loss,
            folder=folder,
            device=device,
            progress=partial(progress, number),
        ).to(torch.device("cpu"))
        for number in range(MEMBERS)
    )


def held_out_recordings(count: int) -> list[int]:
    """Return which of so many recordings, two at least, ``train_grey_box`` does not train on."""
    return list(range(min(LEFT_OUT, count) - 1, count, LEFT_OUT))


def _untrained(
    recordings: Sequence[KnownForceRecording], drives: Mapping[str, LoadedDrive], rate_hz: float
) -> GreyBox:
    """Return a grey box that has no networks yet."""
    channels = [one.channels for one in recordings]
    components = tuple(c for c in recordings[0].force_N if c in drives)
    hears = any(np.any(one.force_N[c] != 0.0) for one in recordings for c in components)
    none = np.zeros(0)
    return GreyBox(
        rate_hz=rate_hz,
        axes=tuple(SeenAxis.of(axis, channels) for axis in drives),
        hears=hears,
        seen=seen_of(tuple(drives), channels[0], hears=hears),
        low=none,
        high=none,
        components=components,
        scaled=NetworkScaling(none, none, none),
        members=(),
        cutoff_hz=none,
        wider=np.ones(len(components)),
    )


def _later(inputs: Array, targets: Array) -> tuple[Array, Array]:
    """Return inputs and targets so that each row tells of the one LATER rows before it."""
    heard = np.concatenate([inputs, np.repeat(inputs[-1:], LATER, axis=0)])
    return heard, np.concatenate([np.repeat(targets[:1], LATER, axis=0), targets])


def _scaled(shown: Sequence[Array], left: Sequence[Array]) -> NetworkScaling:
    every, rest = np.concatenate(shown), np.concatenate(left)
    size = np.maximum(every.std(axis=0), 1e-9)
    return NetworkScaling(every.mean(axis=0), size, np.maximum(rest.std(axis=0), 1e-9))


def _coherent(
    box: GreyBox, loads: Sequence[Channels], recordings: Sequence[KnownForceRecording]
) -> Array:
    """Return up to which frequency each component is coherent; of air, that nothing tells it."""
    if not box.hears:
        return np.full(len(box.components), 0.5 * box.rate_hz)
    both = list(zip(loads, recordings, strict=True))
    return np.array(
        [
            coherent_hz([(-load[c], one.force_N[c]) for load, one in both], rate_hz=box.rate_hz)
            for c in box.components
        ]
    )


def _wider(
    box: GreyBox, recordings: Sequence[KnownForceRecording], tables: Mapping[str, AxisTables]
) -> Array:
    """Return the factor (m,) on standard deviations that makes 95 % of them hold."""
    off = []
    for one in recordings:
        told = network_forces(box, tables, one.channels)
        wanted = np.column_stack([one.force_N[c] for c in box.components])
        off.append(np.abs(told.force_N - wanted) / told.sd_N)
    # Every recording counts alike, however long
    each = [np.quantile(one, np.linspace(0.005, 0.995, 100), axis=0) for one in off]
    return np.asarray(np.quantile(np.concatenate(each), 0.95, axis=0) / NORMAL_95)
