"""Stacked LSTM layers with a linear head, and running one on rows as they come.

Cell without peepholes: f, i, o = σ(W h + U x + b), g = tanh(…), c' = f c + i g, h' = o tanh c'.
Source: P0 section 2.3, equations 11 to 16; Hochreiter and Schmidhuber 1997.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

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


def device() -> str:
    """Return where networks are trained: on a GPU where there is one."""
    return "cuda" if torch.cuda.is_available() else "cpu"


def side_by_side(members: Sequence[Stacked]) -> Stacked:
    """Return one network that is several of one shape beside each other, their outputs in turn.

    Run at once they cost about what one does: its weights are theirs along the diagonal.
    """
    shape, count = members[0].shape, len(members)
    cells = shape.cells
    whole = Stacked(replace(shape, cells=count * cells, outputs=count * shape.outputs, dropout=0.0))
    with torch.no_grad():
        for name, weights in whole.layers.named_parameters():
            weights.zero_()
            gates = weights.view(4, count, cells, -1)
            inner = weights.dim() == 2 and not name.endswith("ih_l0")
            for k, member in enumerate(members):
                columns = slice(k * cells, (k + 1) * cells) if inner else slice(None)
                gates[:, k, :, columns] = member.layers.get_parameter(name).view(4, cells, -1)
        whole.head.weight.zero_()
        for k, member in enumerate(members):
            rows = slice(k * shape.outputs, (k + 1) * shape.outputs)
            whole.head.weight[rows, k * cells : (k + 1) * cells] = member.head.weight
            whole.head.bias[rows] = member.head.bias
    return whole.eval()


def ran(network: Stacked, rows: Array, state: State | None = None) -> tuple[Array, State]:
    """Return outputs (n, outputs) of rows (n, inputs) behind a state, and the state after them.

    The network is in the mode for use (``eval``).
    """
    device = next(network.parameters()).device
    with torch.inference_mode():
        given = torch.as_tensor(rows, dtype=torch.float32, device=device)[None]
        made, state = network(given, state)
    return made[0].cpu().numpy().astype(np.float64), state
