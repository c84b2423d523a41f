"""Stacked LSTM layers with a linear head, and running one on rows as they come.

Cell without peepholes: f, i, o = σ(W h + U x + b), g = tanh(…), c' = f c + i g, h' = o tanh c'.
Source: P0 section 2.3, equations 11 to 16; Hochreiter and Schmidhuber 1997.
"""

from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

Array = NDArray[np.float64]
State = tuple[Tensor, Tensor]
"""Hidden and cell state of every layer."""


@dataclass(frozen=True)
class Shape:
    """Size of a network: inputs, cells a layer, layers, outputs; ``dropout`` between layers."""

    inputs: int
    outputs: int
    cells: int = 20
    layers: int = 3
    dropout: float = 0.0


class Stacked(nn.Module):
    """LSTM layers one behind the other, and a linear head."""

    def __init__(self, shape: Shape) -> None:
        super().__init__()
        self.shape = shape
        self.layers = nn.LSTM(
            shape.inputs, shape.cells, shape.layers, batch_first=True, dropout=shape.dropout
        )
        self.last = nn.Dropout(shape.dropout)
        self.head = nn.Linear(shape.cells, shape.outputs)

    def forward(self, rows: Tensor, state: State | None = None) -> tuple[Tensor, State]:
        """Return outputs (b, n, outputs) of rows (b, n, inputs), and the state after them."""
        hidden, state = self.layers(rows, state)
        return self.head(self.last(hidden)), state


def ran(network: Stacked, rows: Array, state: State | None = None) -> tuple[Array, State]:
    """Return outputs (n, outputs) of rows (n, inputs) behind a state, and the state after them."""
    network.eval()
    device = next(network.parameters()).device
    with torch.inference_mode():
        given = torch.as_tensor(rows, dtype=torch.float32, device=device)[None]
        made, state = network(given, state)
    return made[0].cpu().numpy().astype(np.float64), state
