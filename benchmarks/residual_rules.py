"""Whether rules (ANFIS) on what a calibration's form leaves say more than the form alone.

    python -m benchmarks.residual_rules FIRST_SEED LAST_SEED

Spindle and Z of the proof of calibration's lathes, with the cuts of its ANFIS (103 and 240). Root
mean square errors on cuts left out, over those of the form that `calibrate` takes: that form with
rules fitted to its residual, over the current, or over current and speed (feed speed of Z); rules
of the same inputs in its place; and, as where no form has the drive's physics, a straight line,
alone and with rules on its residual. Printed are medians over the lathes, and on how many of them
the way is better by two standard errors.
"""

import sys
from collections import defaultdict
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.fitting import anfis
from autodb.fitting.linear import Undetermined
from autodb.proofs.machines.lathe.reference_lathe import RULES, campaign
from autodb.proofs.runs.lathe.lathe_ours import calibration_table
from autodb.sensing.ranges.choosing import FOLDS, best, fold_errors, squares_less, try_forms
from autodb.sensing.ranges.forms import FEED_FORMS, LINE, SPINDLE_FORMS, CurrentForm, MeasuredCuts
from autodb.sensing.ranges.points import calibration_points

Array = NDArray[np.float64]

BETTER = 2.0
"""Standard errors by which rules must be better to be taken, as in ``forms``."""
FORMS = {"spindle": SPINDLE_FORMS, "z": FEED_FORMS}


@dataclass(frozen=True)
class Beside:
    """Another way's error over that of the form taken, and by how many standard errors less."""

    ratio: float
    less: float


def axis_rows(seed: int, axis: str) -> dict[str, Beside]:
    """Return how each way does on an axis of a lathe."""
    points = calibration_points(calibration_table(campaign(seed, RULES), axis), axis)
    sensed, target, groups = points.sensed, points.target, points.groups
    taken = best(try_forms(FORMS[axis], sensed, target, groups, folds=FOLDS), groups)
    speed = sensed.speed_rpm if axis == "spindle" else sensed.feed_mm_s
    current, both = sensed.current[:, None], np.column_stack([sensed.current, speed])
    ways: dict[str, tuple[CurrentForm | None, Array | None]] = {
        "the form, rules over its current": (taken.form, current),
        "the form, rules over current and speed": (taken.form, both),
        "rules over current and speed alone": (None, both),
        "a straight line": (LINE, None),
        "a straight line, rules over current and speed": (LINE, both),
    }
    known = taken.errors
    assert known is not None
    found = {}
    for name, (form, inputs) in ways.items():
        errors = fold_errors(_errors_of(form, inputs, sensed, target), target, groups, folds=FOLDS)
        ratio = float(np.sqrt(np.mean(errors**2) / np.mean(known**2)))
        found[name] = Beside(ratio, squares_less(errors, known, groups))
    return found


def _errors_of(
    form: CurrentForm | None, inputs: Array | None, sensed: MeasuredCuts, target: Array
) -> Callable[[NDArray[np.bool_]], Array]:
    """Return what gives the errors of rows held out, of a form, rules of inputs (n, d), or both."""

    def errors(held: NDArray[np.bool_]) -> Array:
        left = target
        if form is not None:
            law = form.fit(sensed.at(~held), target[~held])
            left = target - law.form.value(law.coefficients, sensed)
        if inputs is None:
            return left[held]
        start = anfis.premise_grid((2,) * inputs.shape[1])
        rules = anfis.fit_anfis(inputs[~held], left[~held], [start])
        return np.asarray(left[held] - anfis.evaluate(rules, inputs[held]))

    return errors


def main() -> None:
    """Print the table of all lathes."""
    seeds = range(int(sys.argv[1]), int(sys.argv[2]) + 1)
    print(f"| axis | way | error over the form's, median of {len(seeds)} | better on |")
    print("| --- | --- | ---: | ---: |")
    for axis in FORMS:
        found = defaultdict(list)
        for seed in seeds:
            try:
                for name, one in axis_rows(seed, axis).items():
                    found[name].append(one)
            except Undetermined:
                print(f"{axis} of lathe {seed} is not determined", file=sys.stderr)
        for name, rows in found.items():
            median = float(np.median([one.ratio for one in rows]))
            better = sum(one.less > BETTER for one in rows)
            print(f"| {axis} | {name} | {median:.3f} | {better} |")


if __name__ == "__main__":
    main()
