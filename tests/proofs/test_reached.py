"""A proof's figures hang on the modules that its runs reach, and on no others."""

import subprocess
import sys
from pathlib import Path

import pytest

from autodb.proofs.catalogue import PROOFS
from autodb.proofs.reached import APART, ROOT, product_sources

RUNS = {proof.name: proof.run.__module__ for proof in PROOFS}


def _reached(name: str) -> set[str]:
    return {path.relative_to(ROOT).as_posix() for path in product_sources(RUNS[name])}


def test_what_pairs_do_is_nothing_to_a_table_that_tilts() -> None:
    assert "pairs/averaging.py" in _reached("pair-laws")
    assert "pairs/averaging.py" not in _reached("table")
    assert "sensing/table/model.py" in _reached("table")


def test_an_import_within_a_function_counts() -> None:
    assert "proofs/runs/mill/network_run.py" in _reached("mill-networks")


def test_a_package_that_loads_by_name_is_reached_whole() -> None:
    signals = {path.relative_to(ROOT).as_posix() for path in (ROOT / "signals").rglob("*.py")}
    assert signals <= _reached("table")


def test_a_run_of_commands_reaches_all_that_makes_an_answer() -> None:
    apart = [ROOT / folder for folder in APART]
    every = {
        path.relative_to(ROOT).as_posix()
        for path in ROOT.rglob("*.py")
        if not any(map(path.is_relative_to, apart))
    }
    assert _reached("real") == every


@pytest.mark.parametrize("name", ["weeks", "explain"])
def test_all_that_an_import_loads_is_reached(name: str) -> None:
    lines = (
        f"import sys, {RUNS[name]}",
        "print(*(m.__file__ for n, m in sys.modules.items() if n.startswith('autodb')), sep='\\n')",
    )
    done = subprocess.run(
        [sys.executable, "-c", "\n".join(lines)], capture_output=True, text=True, check=True
    )
    loaded = {Path(line).relative_to(ROOT).as_posix() for line in done.stdout.split()}
    counted = {file for file in loaded if not file.startswith(APART)}
    assert len(counted) > 30
    assert counted <= _reached(name)
