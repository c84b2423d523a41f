"""`PEER/bin/python answer.py NAME FOLDER`: one library learns FOLDER/train.npy, answers for both.

Writes answer.npy (train rows, then check rows) and prints the seconds that learning took. Two sets
an input and 16 rules for all. Everything is double precision where the library lets it be.
"""

import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Answer = Callable[[Array], Array]


def toolbox(x: Array, y: Array) -> Answer:
    """anfis-toolbox: bells, consequents by least squares, premises by Adam: its best trainer."""
    from anfis_toolbox import ANFISRegressor

    model = ANFISRegressor(
        n_mfs=2, mf_type="bell", optimizer="hybrid_adam", epochs=500, learning_rate=0.01
    )
    model.fit(x, y)
    return lambda at: np.asarray(model.predict(at), dtype=np.float64)


def torch_anfis(x: Array, y: Array) -> Answer:
    """torchanfis: Gaussians (it has no bells), hybrid; which sets its 16 rules ask for is drawn."""
    import torch
    from torchanfis import ANFISRegressor

    torch.manual_seed(0)
    torch.set_num_threads(1)
    model = ANFISRegressor(n_mfs=2, n_rules=16, training="hybrid", epochs=2000)
    model.fit(x, y)
    return lambda at: np.asarray(model.predict(at), dtype=np.float64)


def anfis_py(x: Array, y: Array) -> Answer:
    """ANFISpy: bells, everything by Adam on all rows at once, its rate falling to 0 (cosine)."""
    import torch
    from ANFISpy import ANFIS

    torch.manual_seed(0)
    torch.set_num_threads(1)
    torch.set_default_dtype(torch.float64)
    names = [f"x{j}" for j in range(x.shape[1])]
    inputs = {
        "n_sets": [2] * len(names),
        "uod": [(float(low), float(high)) for low, high in zip(x.min(0), x.max(0), strict=True)],
        "var_names": names,
        "mf_names": [["low", "high"]] * len(names),
    }
    model = ANFIS({"inputs": inputs, "output": {"var_names": "y", "n_classes": 1}}, "bell")
    given, wanted = torch.tensor(x), torch.tensor(y)[:, None]
    adam = torch.optim.Adam(model.parameters(), lr=0.05)
    rate = torch.optim.lr_scheduler.CosineAnnealingLR(adam, T_max=3000)
    for _ in range(3000):
        adam.zero_grad()
        loss = torch.mean((model(given).reshape(-1, 1) - wanted) ** 2)
        loss.backward()  # type: ignore[no-untyped-call]
        adam.step()
        rate.step()
    return lambda at: np.asarray(model(torch.tensor(at)).detach().numpy(), dtype=np.float64)


PEERS = {"anfis-toolbox": toolbox, "torchanfis": torch_anfis, "anfispy": anfis_py}


def main() -> None:
    """Answer as the named library does."""
    name, folder = sys.argv[1], Path(sys.argv[2])
    train, check = np.load(folder / "train.npy"), np.load(folder / "check.npy")
    start = time.perf_counter()
    answer = PEERS[name](train[:, :-1], train[:, -1])
    seconds = time.perf_counter() - start
    both = np.vstack([train, check])[:, :-1]
    np.save(folder / "answer.npy", answer(both).reshape(len(both)))
    print(seconds)


if __name__ == "__main__":
    main()
