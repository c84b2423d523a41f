"""How far the friction of a real axis depends on the rows that are kept, and on a lag in the model.

`python -m benchmarks.kept_rows DATA_EMPS.mat`: the direction-dependent model with deviation, one
row in 4, 10 and 20 kept, with `lag` and without; the range in docs/method/identify.md.
"""

import sys
from pathlib import Path

import numpy as np

from autodb.assets import kit
from autodb.records import source as records
from autodb.records.tables import Recording
from autodb.sensing.drives.feed_axis import identify
from autodb.sensing.drives.moves.protocol import FilterProtocol

TERMS = ("inertia", "viscous", "coulomb", "asymmetry")
SPEEDS_MM_S = np.array([-100.0, -50.0, 50.0, 100.0])


def main(path: Path) -> None:
    """Print Coulomb and viscous friction, and friction at four velocities, with their sd."""
    moves = records.read(path, columns=kit("sample_jobs") / "emps" / "columns.toml")
    if not isinstance(moves, Recording):
        sys.exit(f"{path}: not a recording over time")
    for decimate in (4, 10, 20):
        for terms in (TERMS, (*TERMS, "lag")):
            model = identify(moves, protocol=FilterProtocol(100.0, decimate), terms=terms)
            found = {t.term: t for t in reversed(model.fitted)}
            coulomb, viscous = found["coulomb"], found["viscous"]
            line = f"one row in {decimate}, {'with' if 'lag' in terms else 'without'} lag: "
            line += f"Coulomb {coulomb.value:.2f} ± {coulomb.sd:.2f} N, "
            line += f"viscous {1e3 * viscous.value:.1f} ± {1e3 * (viscous.sd or 0.0):.1f} N·s/m"
            if model.steady is not None:
                value, sd = model.steady.friction(SPEEDS_MM_S)
                each = zip(SPEEDS_MM_S, value, sd, strict=True)
                line += ";" + ",".join(f" {v:+g} mm/s {f:.1f} ± {s:.1f} N" for v, f, s in each)
            print(line)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
