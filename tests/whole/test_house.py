"""The house's own rules: imports, wheel, docs, schema of what is listed."""

import ast
import importlib
import re
import subprocess
import sys
import tomllib
import zipfile
from collections import Counter
from pathlib import Path

import grimp
import pytest
from hatchling.builders.wheel import WheelBuilder
from packaging.requirements import Requirement

from autodb.cli._listed import GROUPS
from autodb.terms.vocabulary import TERMS, vocabulary
from docs.make.terms import MANY
from tests.conftest import ROOT, Cli

HEAVY = {"numpy", "pandas", "scipy", "pyarrow", "plotly", "sqlalchemy", "pydantic", "pint", "torch"}
COMMANDS = {name for group in GROUPS.values() for name in group}
MODULES = sorted(
    ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")
    for path in (ROOT / "autodb").rglob("*.py")
    if path.stem != "__main__"
)


def test_every_module_can_be_imported() -> None:
    """One after another: as none imports another that imports it, their order changes nothing."""
    for name in MODULES:
        importlib.import_module(name)


def test_no_modules_import_each_other() -> None:
    """Types that are named in comments of types alone are left out."""
    graph = grimp.build_graph("autodb", exclude_type_checking_imports=True)
    left = {name: set(graph.find_modules_directly_imported_by(name)) for name in graph.modules}
    while ends := {name for name, imported in left.items() if not imported & left.keys()}:
        left = {name: imported for name, imported in left.items() if name not in ends}
    assert not left, f"in a circle or above one: {sorted(left)}"


@pytest.mark.parametrize("asked", [["--help"], ["prove", "--help"]], ids=" ".join)
def test_help_imports_no_heavy_library(asked: list[str]) -> None:
    code = f"import sys; from autodb.cli import run; run({asked}); print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    own = {"pydantic"} if len(asked) > 1 else set()  # typer reads a command's options with it
    assert (HEAVY - own) & set(done.stdout.split()) == set()


def test_help_lists_what_is_built(cli: Cli) -> None:
    text = cli("--help").out
    listed = set(re.findall(r"│ ([a-z]+) ", text))
    assert listed & COMMANDS == COMMANDS


@pytest.mark.parametrize("command", sorted(COMMANDS))
def test_every_command_is_in_the_docs(command: str) -> None:
    assert f"`autodb {command}" in (ROOT / "docs" / "commands.md").read_text()


def test_every_term_is_in_the_docs_and_the_vocabulary() -> None:
    text = (ROOT / "docs" / "terms.md").read_text()
    assert len({(term.name, term.form) for term in TERMS}) == len(TERMS)
    for term in TERMS:
        assert term.name in vocabulary()
        assert f"`{term.name}`" in text
        assert term.statement.endswith(".")
        assert term.source
        assert term.excited_by
        coefficients = term.parameters[: len(term.parameters) - len(term.shape)]
        ends = coefficients if len(coefficients) <= MANY else (coefficients[0], coefficients[-1])
        for parameter in (*ends, *term.shape):
            assert f"`{parameter.name}`" in text


def test_links_in_the_docs_lead_somewhere() -> None:
    for page in (ROOT / "README.md", ROOT / "CONTRIBUTING.md", *(ROOT / "docs").rglob("*.md")):
        for target in re.findall(r"\]\(([^)#:]+)\)", page.read_text()):
            assert (page.parent / target).exists(), f"{page.name}: {target}"


def test_the_wheel_holds_the_kits_and_nothing_else(tmp_path: Path) -> None:
    built = next(WheelBuilder(str(ROOT)).build(directory=str(tmp_path), versions=["standard"]))
    names = zipfile.ZipFile(built).namelist()
    for part in (
        "autodb/_assets/calibration/turning-aluminium.toml",
        "autodb/_assets/calibration/milling-c45.toml",
        "autodb/_assets/calibration/drilling-c45.toml",
        "autodb/_assets/calibration/conventional/ti6al4v.toml",
        "autodb/_assets/calibration/conventional/c45.toml",
        "autodb/_assets/schema/migrations/versions/0001_first_tables.py",
        "autodb/_assets/schema/migrations/versions/0002_a_database_that_lasts.py",
        "autodb/_assets/schema/migrations/versions/0003_what_a_cause_was_confirmed_as.py",
        "autodb/_assets/schema/migrations/versions/0004_how_far_off_a_drive_model_is.py",
        "autodb/_assets/schema/job.schema.json",
        "autodb/_assets/sample_jobs/stepped_shaft/job.toml",
        "autodb/_assets/sample_jobs/stepped_shaft/machine.toml",
        "autodb/proofs/cases/tables/published_tables.csv",
        "autodb/reports/templates/page.html.j2",
        "autodb/reports/templates/site/site.js",
        "autodb/wording/de.po",
        "autodb/py.typed",
    ):
        assert part in names
    allowed = re.compile(
        r"autodb/(?!_assets).*\.(py|typed|j2|js|po)|autodb/proofs/cases/tables/published_tables\.csv|"
        r"autodb/_assets/(calibration|schema|sample_jobs)/.*"
        r"\.(py|mako|toml|csv|parquet|json|md|nc)|autodb-[^/]+\.dist-info/.*"
    )
    assert [name for name in names if not allowed.fullmatch(name)] == []


def test_every_installed_version_is_pinned() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    extras = [name for extra in project["optional-dependencies"].values() for name in extra]
    wanted = [
        name for name in (*project["dependencies"], *extras) if not name.startswith("autodb[")
    ]
    pinned = {
        line.split("==")[0].lower().replace("_", "-")
        for line in (ROOT / "constraints.txt").read_text().splitlines()
        if "==" in line
    }
    for requirement in wanted:
        name = re.split(r"[\[<>=~! ]", requirement)[0].lower().replace("_", "-")
        assert name in pinned, name


def test_public_functions_say_what_they_do() -> None:
    for path in (ROOT / "autodb").rglob("*.py"):
        body = ast.parse(path.read_text()).body
        inside = [n for c in body if isinstance(c, ast.ClassDef) for n in c.body]
        for node in [*body, *inside]:
            if isinstance(node, ast.FunctionDef | ast.ClassDef) and not node.name.startswith("_"):
                assert ast.get_docstring(node), f"{path.name}:{node.lineno} {node.name}"


HOLES = {
    "cryptography": ("44.0.0", "CVE-2024-12797"),
    "distributed": ("2026.1.0", "CVE-2026-23528"),
    "filelock": ("3.20.2", "CVE-2026-22701"),
    "h11": ("0.14.0", "CVE-2025-43859"),
    "jinja2": ("3.1.5", "CVE-2025-27516"),
    "python-multipart": ("0.0.21", "CVE-2026-24486"),
    "starlette": ("0.49.0", "CVE-2025-62727"),
    "tornado": ("6.5.4", "CVE-2026-31958"),
    "urllib3": ("2.6.2", "CVE-2026-21441"),
}
"""The last version of a library with a hole that is known, and the hole."""


@pytest.mark.parametrize("name", HOLES)
def test_no_version_with_a_known_hole_is_installed(name: str) -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    groups = [project["dependencies"], *project["optional-dependencies"].values()]
    asked = [Requirement(text) for group in groups for text in group]
    stated = [one.specifier for one in asked if one.name.lower() == name and one.specifier]
    version, hole = HOLES[name]
    assert stated
    assert not any(one.contains(version) for one in stated), hole


REPEATED = {"main", "open_file"}
"""Public names of several modules: a program's entry, and what opens each kind of file."""


def test_a_public_name_has_one_meaning() -> None:
    there: dict[str, set[Path]] = {}
    for path in (ROOT / "autodb").rglob("*.py"):
        for node in ast.parse(path.read_text("utf-8")).body:
            if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
                there.setdefault(node.name, set()).add(path)
    assert {n for n, paths in there.items() if len(paths) > 1 and n[0] != "_"} == REPEATED


def test_rooms_are_small() -> None:
    modules = [path for path in (ROOT / "autodb").rglob("*.py") if path.stem != "__init__"]
    rooms = Counter(path.parent for path in modules)
    assert max(rooms.values()) <= 20
    loose = {path.stem for path in modules if path.parent == ROOT / "autodb"}
    assert loose == {"__main__", "assets", "errors"}


def test_test_modules_are_short() -> None:
    long = {
        str(path.relative_to(ROOT))
        for path in (ROOT / "tests").rglob("*.py")
        if len(path.read_text("utf-8").splitlines()) > 400
    }
    assert long == set()
