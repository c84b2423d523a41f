"""What the product imports is among the dependencies that are always installed, or of an extra."""

import ast
import re
import sys
import tomllib
from importlib.metadata import PackageNotFoundError, packages_distributions, requires
from pathlib import Path

ROOT = Path(__file__).parents[2]
OF_EXTRAS = ("live", "web", "sensing/network", "proofs", "cli/develop")
"""Rooms that need more than what is always installed: extras, or what develops."""


def _names(requirements: list[str]) -> set[str]:
    found = (re.match(r"[\w.-]+", one) for one in requirements)
    return {one[0].lower().replace("_", "-") for one in found if one}


def _with_theirs(names: set[str]) -> set[str]:
    """Return packages with what they are installed with, without their extras."""
    found, left = set[str](), set(names)
    while left:
        one = left.pop()
        found.add(one)
        try:
            theirs = [text for text in requires(one) or () if "extra ==" not in text]
        except PackageNotFoundError:  # of another system
            continue
        left |= _names(theirs) - found
    return found


def _loaded_at_once(path: Path) -> set[str]:
    """Return the top names that importing a module imports itself, wherever they come from."""
    found = set()
    for node in ast.parse(path.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.Import):
            found |= {one.name.split(".")[0] for one in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            found.add(node.module.split(".")[0])
    return found - {"autodb"} - set(sys.stdlib_module_names)


def test_modules_without_an_extra_import_what_is_always_installed() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    always, from_ = _with_theirs(_names(project["dependencies"])), packages_distributions()
    lacking: dict[str, list[str]] = {}
    for path in sorted((ROOT / "autodb").rglob("*.py")):
        place = path.relative_to(ROOT / "autodb").as_posix()
        if place.startswith(OF_EXTRAS):
            continue
        for name in _loaded_at_once(path):
            if not {one.lower().replace("_", "-") for one in from_[name]} & always:
                lacking.setdefault(place, []).append(name)
    assert lacking == {}
