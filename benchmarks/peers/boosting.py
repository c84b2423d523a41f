"""scikit-learn's gradient boosting of histograms, stopped early on the held-out rows."""

from importlib.metadata import version

import numpy as np
from sklearn.ensemble import HistGradientBoostingRegressor

from benchmarks.peers.problem import Answer, Array, Problem, Split
from benchmarks.peers.regression import Predict, answered

VERSION = f"scikit-learn {version('scikit-learn')}"
MOST_ROWS = 20_000


def answer(problem: Problem) -> Answer:
    """Answer a problem."""
    return answered(problem, _fit, most_rows=MOST_ROWS)


def _fit(rows: Array, target: Array, parts: Split) -> Predict:
    model = HistGradientBoostingRegressor(
        learning_rate=0.05, max_iter=1000, early_stopping=True, random_state=0
    )
    fitted, held = parts.fitted, parts.held_out
    model.fit(rows[fitted], target[fitted], X_val=rows[held], y_val=target[held])

    def predict(asked: Array) -> Array:
        return np.asarray(model.predict(asked), dtype=np.float64)

    return predict
