"""`make bench`: what the program does most, as ratios to limits and to the last version's.

A ratio that has grown by more than SLOWER over `benchmarks/figures.json` is measured once more; if
it still has, or is beyond its own limit, the exit status is 1. `python -m benchmarks --keep` writes
the figures anew, which every version does once; `python -m benchmarks WORD` measures only what has
the word in its name.
"""

import argparse
import json
import sys
import tempfile
import time
from pathlib import Path

import autodb
from benchmarks.core import MEASURES, Measure
from benchmarks.timing import in_turn_s

FIGURES = Path(__file__).parent / "figures.json"
SLOWER = 1.3


def main() -> int:
    """Measure, print and compare; return the exit status."""
    asked = argparse.ArgumentParser(prog="python -m benchmarks")
    asked.add_argument("word", nargs="?", default="", help="only what has this in its name")
    asked.add_argument("--keep", action="store_true", help="write the figures to compare with")
    given = asked.parse_args()
    version, last = _kept()
    begun, ratios, slower = time.perf_counter(), dict[str, float](), list[str]()
    for one in MEASURES:
        if given.word in one.name:
            ratios[one.name], grown = _measured(one, last.get(one.name))
            if grown is not None and grown > SLOWER:
                slower.append(
                    f"more than {SLOWER} times as slow as in the last version: {one.name}"
                )
            if one.most is not None and ratios[one.name] > one.most:
                slower.append(f"more than {one.most:g} × {one.limit}: {one.name}")
    print(f"{time.perf_counter() - begun:.0f} s; compared with version {version}")
    if given.keep:
        kept = {"version": autodb.__version__, "ratios": {**last, **ratios}}
        FIGURES.write_text(json.dumps(kept, indent=1, ensure_ascii=False) + "\n")
        return 0
    for line in slower:
        print(line, file=sys.stderr)
    return 1 if slower else 0


def _kept() -> tuple[str, dict[str, float]]:
    """Return the last version and its ratios."""
    if not FIGURES.exists():
        return "none", {}
    kept = json.loads(FIGURES.read_text())
    return kept["version"], kept["ratios"]


def _measured(one: Measure, last: float | None) -> tuple[float, float | None]:
    """Print a measure; return its ratio to its limit, and how much that has grown."""
    with tempfile.TemporaryDirectory() as folder:
        ours, limit = one.prepared(Path(folder))
        took_s, limit_s = in_turn_s(ours, limit, one.runs)
        if last is not None and took_s / limit_s > SLOWER * last:
            took_s, limit_s = in_turn_s(ours, limit, one.runs)
    ratio = took_s / limit_s
    grown = None if last is None else ratio / last
    then = "" if grown is None else f", {grown:.2f} × the last version's"
    print(f"{one.name}: {_time(took_s)}, {ratio:.3g} × {one.limit}{then}", flush=True)
    return ratio, grown


def _time(seconds: float) -> str:
    return f"{seconds:.2f} s" if seconds >= 1.0 else f"{1e3 * seconds:.3g} ms"


if __name__ == "__main__":
    sys.exit(main())
