"""Which modules of the package a proof's runs reach: what its figures hang on."""

import ast
from collections.abc import Iterable
from functools import cache
from pathlib import Path

import autodb

ROOT = Path(autodb.__file__).parent
APART = ("cli", "proofs/cases", "proofs/machines", "reports", "web", "wording")
"""Folders that make no interval; the generator's own modules are hashed by themselves."""
PACKAGE, PROOFS = "autodb", "autodb.proofs"
BY_NAME = ("importlib", "importlib.import_module")


def product_sources(*modules: str) -> list[Path]:
    """Return the files that modules import, at whatever depth and also within functions.

    A package that loads its parts by name is reached whole; a run that does so asks commands,
    which may reach everything.
    """
    apart = [ROOT / folder for folder in APART]
    files = sorted(_modules()[name] for name in _reached(modules))
    return [path for path in files if not any(map(path.is_relative_to, apart))]


def _reached(modules: Iterable[str]) -> set[str]:
    """Return modules and all that they import; the package itself loads nothing until asked.

    What a module outside the package reaches is not known: everything.
    """
    found, left = {PACKAGE}, set(modules)
    if not left <= set(_modules()):
        return set(_modules())
    while left:
        name = left.pop()
        found.add(name)
        imported, by_name = _imported(name)
        if by_name and _is_in(name, PROOFS):
            return set(_modules())
        if by_name:
            imported = imported | {other for other in _modules() if _is_in(other, _package(name))}
        left |= imported - found
    return found


def _is_in(name: str, package: str) -> bool:
    """Say whether a module is a package or within it."""
    return name == package or name.startswith(f"{package}.")


def _package(name: str) -> str:
    """Return the package that a module is in: itself, if it is one."""
    return name if _modules()[name].name == "__init__.py" else name.rpartition(".")[0]


@cache
def _modules() -> dict[str, Path]:
    """Return the file of each module of the package."""
    paths = {path.relative_to(ROOT.parent).with_suffix(""): path for path in ROOT.rglob("*.py")}
    return {
        ".".join(path.parent.parts if path.name == "__init__" else path.parts): file
        for path, file in paths.items()
    }


@cache
def _imported(name: str) -> tuple[frozenset[str], bool]:
    """Return which modules one imports, with their packages, and whether it loads any by name."""
    named = set()
    for node in ast.walk(ast.parse(_modules()[name].read_text("utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module:
            named |= {node.module, *(f"{node.module}.{one.name}" for one in node.names)}
        elif isinstance(node, ast.Import):
            named |= {one.name for one in node.names}
    parts = [one.split(".") for one in named & set(_modules())]
    packages = {".".join(part[: n + 1]) for part in parts for n in range(len(part))}
    return frozenset(packages), any(
        one.endswith(f".{BY_NAME}") or one == "importlib" for one in named
    )
