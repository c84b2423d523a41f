"""Training a network on recordings, epoch by epoch: it goes on where it was killed.

What an epoch does follows from the seed and its number alone, so that a run that was killed and
begun again ends as one that was not.
"""

import hashlib
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from autodb.sensing.network.network import Shape, Stacked

Array = NDArray[np.float64]
Loss = Callable[[Tensor, Tensor], Tensor]
"""Loss of each row and component (…, m) of outputs (…, k) and targets (…, m)."""

FADED = 0.02
"""Share of the first learning rate that the last epoch has. Chosen."""
CLIP = 1.0
"""Norm above which a gradient is shortened. Chosen."""


@dataclass(frozen=True)
class TrainingRows:
    """Rows of one recording in time: ``inputs`` (n, k) and ``targets`` (n, m)."""

    inputs: Array
    targets: Array


@dataclass(frozen=True)
class TrainingPlan:
    """How a network is trained, by Adam with a rate that fades as a cosine.

    Recordings are cut into windows of ``window`` rows behind ``lead`` rows that are not scored.
    """

    epochs: int
    rate: float
    window: int
    lead: int
    batch: int
    seed: int


@dataclass(frozen=True)
class Windows:
    """Windows of recordings: inputs (w, l, k), targets (w, l, m), 1 where a row counts (w, l)."""

    inputs: Tensor
    targets: Tensor
    counts: Tensor

    def __len__(self) -> int:
        return len(self.counts)


def windows(sequences: Sequence[TrainingRows], plan: TrainingPlan, device: torch.device) -> Windows:
    """Cut recordings into windows, those that are too short filled up with rows that count not."""
    long = plan.lead + plan.window
    inputs, targets, counts = [], [], []
    for one in sequences:
        for begin in range(0, len(one.inputs), plan.window):
            first = max(begin - plan.lead, 0)
            rows = slice(first, begin + plan.window)
            count = np.ones(len(one.inputs[rows]))
            count[: begin - first] = 0.0
            missing = long - len(count)
            inputs.append(np.pad(one.inputs[rows], ((0, missing), (0, 0)), mode="edge"))
            targets.append(np.pad(one.targets[rows], ((0, missing), (0, 0))))
            counts.append(np.pad(count, (0, missing)))

    def tensor(parts: list[Array]) -> Tensor:
        return torch.as_tensor(np.array(parts), dtype=torch.float32, device=device)

    return Windows(tensor(inputs), tensor(targets), tensor(counts))


def trained(
    sequences: Sequence[TrainingRows],
    shape: Shape,
    plan: TrainingPlan,
    loss: Loss,
    *,
    folder: Path | None = None,
    device: str = "cpu",
    progress: Callable[[int, float], None] = lambda _epoch, _loss: None,
) -> Stacked:
    """Return a network trained on recordings.

    ``folder``: where an epoch's end is kept, to go on from; ``progress`` is told the epochs done
    and their mean loss.
    """
    on = torch.device(device)
    data = windows(sequences, plan, on)
    torch.manual_seed(plan.seed)
    network = Stacked(shape).to(on)
    adam = torch.optim.Adam(network.parameters(), lr=plan.rate)
    kept = None if folder is None else folder / f"{_key(data, shape, plan)}.pt"
    done = _go_on(kept, network, adam, on)
    for epoch in range(done, plan.epochs):
        for group in adam.param_groups:
            group["lr"] = _rate(plan, epoch)
        torch.manual_seed(plan.seed * 100_003 + epoch + 1)
        mean = _epoch(network, adam, data, loss, batch=plan.batch)
        if kept is not None:
            _keep(kept, network, adam, epoch + 1)
        progress(epoch + 1, mean)
    return network.eval()


def _rate(plan: TrainingPlan, epoch: int) -> float:
    share = 0.5 * (1.0 + np.cos(np.pi * epoch / max(plan.epochs - 1, 1)))
    return float(plan.rate * (FADED + (1.0 - FADED) * share))


def _epoch(
    network: Stacked, adam: torch.optim.Adam, data: Windows, loss: Loss, *, batch: int
) -> float:
    """Take every window once, in an order that torch draws, and return the mean loss."""
    order = torch.randperm(len(data)).to(data.counts.device)
    network.train()
    total, weight = 0.0, 0.0
    for part in torch.split(order, batch):
        adam.zero_grad()
        made, _ = network(data.inputs[part])
        counts = data.counts[part]
        rows = loss(made, data.targets[part]).mean(dim=-1)
        mean = torch.sum(rows * counts) / torch.sum(counts)
        mean.backward()  # type: ignore[no-untyped-call]
        torch.nn.utils.clip_grad_norm_(network.parameters(), CLIP)
        adam.step()
        total += float(mean.detach()) * len(part)
        weight += len(part)
    return total / weight


def _key(data: Windows, shape: Shape, plan: TrainingPlan) -> str:
    """Return what tells runs apart: data, shape, and how they are trained."""
    told = hashlib.sha256(repr((asdict(shape), asdict(plan))).encode())
    for one in (data.inputs, data.targets, data.counts):
        told.update(one.cpu().numpy().tobytes())
    return told.hexdigest()[:16]


def _go_on(
    kept: Path | None, network: Stacked, adam: torch.optim.Adam, device: torch.device
) -> int:
    """Return how many epochs were done before, having taken up where they ended."""
    if kept is None or not kept.exists():
        return 0
    found = torch.load(kept, map_location=device, weights_only=True)
    network.load_state_dict(found["network"])
    adam.load_state_dict(found["adam"])
    return int(found["epochs"])


def _keep(kept: Path, network: Stacked, adam: torch.optim.Adam, epochs: int) -> None:
    kept.parent.mkdir(parents=True, exist_ok=True)
    beside = kept.with_suffix(".part")
    torch.save(
        {"network": network.state_dict(), "adam": adam.state_dict(), "epochs": epochs}, beside
    )
    beside.replace(kept)
