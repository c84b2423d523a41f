"""Leave each part of the published EMPS model out of a simulation and print what explain names.

`python -m benchmarks.left_out DATA_EMPS.mat`: the table in docs/method/explain.md.
"""

import sys
from pathlib import Path

from autodb.assets import kit
from autodb.explain import explain
from autodb.records import source as records
from autodb.records.tables import Recording
from autodb.sensing.drives.feed_axis import predict_effort
from autodb.sensing.drives.fit.axis_model import terms_with

# Janot, Gautier, Brunot 2019, symmetric model, in N per mm/s², mm/s and 1
PUBLISHED = {"coulomb": 20.3935, "viscous": 0.2035034, "inertia": 0.0951089, "gravity": -3.1648}


def main(path: Path) -> None:
    """Print one line a part: what was left out, what is named, and its main parameter."""
    moves = records.read(path, columns=kit("sample_jobs") / "emps" / "columns.toml")
    if not isinstance(moves, Recording):
        sys.exit(f"{path}: not a recording over time")
    for left_out, published in PUBLISHED.items():
        kept = {term: value for term, value in PUBLISHED.items() if term != left_out}
        effort = predict_effort(moves, "x", terms_with(kept, "N"))
        simulation = Recording(path=path, channels={"t": moves.t_s, "x.drive_force": effort})
        answer = explain(moves, simulation).explanation.channels["x.drive_force"]
        named = [cause.term for cause in answer.missing if cause.kind == "missing"]
        line = f"left out {left_out}: named {', '.join(named)}"
        for cause in answer.missing:
            if cause.term == left_out:
                value = list(cause.parameters.values())[1].value
                line += f"; {value:.5g}, published {published:.5g} ({value / published - 1:+.1%})"
        print(line)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
