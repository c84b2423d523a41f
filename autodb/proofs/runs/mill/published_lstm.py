"""The published network for forces from a mill's drive signals: the gate of its plan.

P0's own, section 2.3: 14 channels unfiltered, scaled to [−1, 1], strictly positive ones to [0, 1];
three LSTM layers of 20 cells, dropout, one output; a network a component; F* = F/(2 max|F|) + 0.5
over the recordings for training. Dropout, rate, batches, epochs are not printed; they were set
once, on seeds 101 to 103.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray

from autodb.proofs.machines.mill.reference_plan import RecordedCut
from autodb.sensing.network.network import Shape, Stacked, ran
from autodb.sensing.network.training import TrainingPlan, TrainingRows, trained

Array = NDArray[np.float64]

DROPOUT = 0.5
"""What MATLAB's layer has unless another is stated."""
PLAN = TrainingPlan(epochs=14, rate=5e-3, window=500, lead=0, batch=32, seed=1)


@dataclass(frozen=True)
class ScaledChannels:
    """Channels (k,) scaled by ``low`` and ``high`` of the recordings for training."""

    low: Array
    high: Array

    @classmethod
    def of(cls, recordings: Sequence[Array]) -> "ScaledChannels":
        """Return the ranges of recordings (n, k)."""
        return cls(
            np.min([one.min(axis=0) for one in recordings], axis=0),
            np.max([one.max(axis=0) for one in recordings], axis=0),
        )

    def __call__(self, rows: Array) -> Array:
        """Return rows (n, k) in [−1, 1], of channels that are strictly positive in [0, 1]."""
        share = (rows - self.low) / np.maximum(self.high - self.low, 1e-12)
        return np.where(self.low > 0.0, share, 2.0 * share - 1.0)


@dataclass(frozen=True)
class Network:
    """P0's network of one component."""

    network: Stacked
    scaled: ScaledChannels
    most_N: float

    def force_N(self, rows: Array) -> Array:
        """Return the force (n,) of rows (n, 14)."""
        made, _ = ran(self.network, self.scaled(rows))
        return (made[:, 0] - 0.5) * 2.0 * self.most_N


def channels_of_cut(cut: RecordedCut) -> Array:
    """Return the channels (n, 14) of a recorded cut."""
    return np.column_stack(list(cut.channels.values()))


def published_network(
    recordings: Sequence[RecordedCut],
    component: int,
    *,
    plan: TrainingPlan = PLAN,
    dropout: float = DROPOUT,
    folder: Path | None = None,
    device: str = "cpu",
    progress: Callable[[int, float], None] = lambda _epoch, _loss: None,
) -> Network:
    """Return P0's network of a component, 0 to 2, trained on recorded cuts."""
    rows = [channels_of_cut(one) for one in recordings]
    forces = [one.force_N[component] for one in recordings]
    scaled, most_N = ScaledChannels.of(rows), max(float(np.abs(one).max()) for one in forces)
    sequences = [
        TrainingRows(scaled(one), (force_N / (2.0 * most_N) + 0.5)[:, None])
        for one, force_N in zip(rows, forces, strict=True)
    ]
    network = trained(
        sequences,
        Shape(inputs=rows[0].shape[1], outputs=1, cells=20, layers=3, dropout=dropout),
        plan,
        lambda made, wanted: (made - wanted) ** 2,
        folder=folder,
        device=device,
        progress=progress,
    )
    return Network(network.to(torch.device("cpu")), scaled, most_N)
