"""Sugeno systems learned from rows (ANFIS, Jang 1993): rules in words, intervals, new rows.

model = fit(inputs, values, nearby(grid((2, 3))))      # n rows of 2 inputs, 6 rules
predict(model, inputs).interval()
sentences(model, ("current", "feed", "force"), ("A", "mm/rev", "N"))
"""

from autodb.fitting.anfis.fitted_system import Learner, fit_anfis, fit_consequents
from autodb.fitting.anfis.hybrid import Hybrid
from autodb.fitting.anfis.memberships import BELL, GAUSS, Membership
from autodb.fitting.anfis.monotone import Monotone, NotMonotone
from autodb.fitting.anfis.premises import Premises, clusters, nearby, premise_grid
from autodb.fitting.anfis.sentences import plain_consequents, rule_sentences
from autodb.fitting.anfis.settling import PremisesNotSettled, Projection
from autodb.fitting.anfis.standardised import Unvarying
from autodb.fitting.anfis.sums import Sums
from autodb.fitting.anfis.system import (
    Anfis,
    AnfisPrediction,
    Hull,
    TooFewRows,
    evaluate,
    predict_anfis,
    refreshed,
    tally,
    without_rows,
)

__all__ = [
    "BELL",
    "GAUSS",
    "Anfis",
    "AnfisPrediction",
    "Hull",
    "Hybrid",
    "Learner",
    "Membership",
    "Monotone",
    "NotMonotone",
    "Premises",
    "PremisesNotSettled",
    "Projection",
    "Sums",
    "TooFewRows",
    "Unvarying",
    "clusters",
    "evaluate",
    "fit_anfis",
    "fit_consequents",
    "nearby",
    "plain_consequents",
    "predict_anfis",
    "premise_grid",
    "refreshed",
    "rule_sentences",
    "tally",
    "without_rows",
]
