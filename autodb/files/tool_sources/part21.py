"""Attribute files of tool catalogues: ISO 13399 as ISO 10303-21 writes it (`.p21`).

A catalogue hands out one for a tool, alone or in a package (`.zip`, of the Generic Tool
Classification) with drawings and models. Each value has a symbol of ISO 13399 beside a code of its
dictionary, which is for sale; read are the symbols. A package with the files of an insert and of
its holder is one tool. Sources: files that a public importer of such data describes; symbols as
catalogues of Dormer Pramet and Tungaloy print them.
"""

import math
import re
import zipfile
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

from autodb.errors import UnusableInput
from autodb.wording import phrase

SUFFIX, PACKAGE = ".p21", ".zip"
_BYTES = 32 << 20
"""No attribute file of a tool is larger, nor are all those of a package."""
_MM = {"": 1.0, "mm": 1.0, "cm": 10.0, "m": 1000.0, "in": 25.4, "inch": 25.4, '"': 25.4}
_LENGTHS = ("DC", "RE")
_ANGLES = ("FHA", "SIG", "KAPR", "EPSR", "LAMS", "GAMO")
_COUNTS = ("ZEFP", "ZEFF", "NOF")
_OURS = {
    "end_mill": {
        "DC": "diameter_mm", "ZEFF": "teeth", "ZEFP": "teeth", "FHA": "helix_deg",
        "RE": "corner_radius_mm",
    },
    "drill": {
        "DC": "diameter_mm", "ZEFF": "teeth", "NOF": "teeth", "FHA": "helix_deg",
        "SIG": "point_angle_deg",
    },
    "turning_insert": {
        "RE": "nose_radius_mm", "KAPR": "kappa_deg", "EPSR": "included_deg",
        "LAMS": "inclination_deg",
    },
}  # fmt: skip
"""Our name by kind of tool and symbol; of two that say one thing, the later symbol counts."""
_PART = re.compile(r"'(?:[^']|'')*'|[;(),]|[^';(),]+")
_INSTANCE = re.compile(r"#(\d+)\s*=\s*(\w+)")
_WIDE = re.compile(r"\\X2\\((?:[0-9A-F]{4})+)\\X0\\")


class _Entity(NamedTuple):
    """An instance of the exchange structure: its type, what its brackets hold of first rank."""

    kind: str
    said: tuple[str, ...]


def said_in_file(path: Path, name: str | None) -> dict[str, Any]:
    """Return what an attribute file says as a tool file would; raises UnusableInput."""
    return _tool(path, [path.read_bytes()], name)


def said_in_package(path: Path, name: str | None) -> dict[str, Any]:
    """Return what the attribute files of a package say together, as a tool file would."""
    try:
        found = list(_members(path))
    except (zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError, RuntimeError) as error:
        raise UnusableInput(
            phrase(
                "{file}: is no whole package ({error}); download it again", file=path, error=error
            )
        ) from None
    if not found:
        raise UnusableInput(
            phrase(
                "{file}: has no attribute file (.p21); use a package of the Generic Tool "
                "Classification (GTC)",
                file=path,
            )
        )
    return _tool(path, found, name)


def _members(path: Path) -> Iterator[bytes]:
    """Yield the attribute files of a package, and of packages that it holds for each tool."""
    left = _BYTES

    def of(package: zipfile.ZipFile, within: bool) -> Iterator[bytes]:
        nonlocal left
        for member in package.infolist():
            suffix = Path(member.filename).suffix.lower()
            if suffix != SUFFIX and not (within and suffix == PACKAGE):
                continue
            left -= member.file_size
            if left < 0:
                raise UnusableInput(
                    phrase(
                        "{file}: its attribute files have more than {n} MB; use a package of one "
                        "tool",
                        file=path,
                        n=_BYTES >> 20,
                    )
                )
            if suffix == SUFFIX:
                yield package.read(member)
            else:
                with package.open(member) as inner, zipfile.ZipFile(inner) as of_tool:
                    yield from of(of_tool, within=False)

    with zipfile.ZipFile(path) as package:
        yield from of(package, within=True)


def _tool(path: Path, files: list[bytes], name: str | None) -> dict[str, Any]:
    """Return kind, name and geometry that attribute files say; raises UnusableInput."""
    values: dict[str, float] = {}
    names: list[str] = []
    for data in files:
        entities = _entities(path, data)
        names += _designations(entities)
        for symbol, value in _values(path, entities):
            if values.setdefault(symbol, value) != value:
                raise UnusableInput(
                    phrase(
                        "{file}: says {symbol} twice, {first} and {second}; use data of one tool",
                        file=path,
                        symbol=symbol,
                        first=f"{values[symbol]:g}",
                        second=f"{value:g}",
                    )
                )
    kind = _kind(values)
    if kind is None:
        raise UnusableInput(
            phrase(
                "{file}: does not say by symbols of ISO 13399 what is needed of an end mill (DC, "
                "ZEFP), a drill (DC, SIG) or a turning tool (RE, KAPR), only: {known}; write a "
                "tool file (TOML)",
                file=path,
                known=", ".join(values) or "-",
            )
        )
    found = {ours: values[symbol] for symbol, ours in _OURS[kind].items() if symbol in values}
    if "GAMO" in values and kind == "turning_insert":
        slope = math.cos(math.radians(found.get("inclination_deg", 0.0)))
        found["rake_deg"] = math.degrees(math.atan(math.tan(math.radians(values["GAMO"])) * slope))
    called = name or " / ".join(dict.fromkeys(names)) or path.stem
    return {"name": called, "kind": kind, "geometry": found}


def _kind(values: dict[str, float]) -> str | None:
    """Return what kind of tool has such values: only a drill has a point angle."""
    if "DC" not in values:
        return "turning_insert" if {"RE", "KAPR", "LAMS", "GAMO"} & values.keys() else None
    if "SIG" in values:
        return "drill"
    return "end_mill" if {"ZEFP", "ZEFF"} & values.keys() else None


def _entities(path: Path, data: bytes) -> dict[str, _Entity]:
    """Return the instances of an exchange structure by number; raises UnusableInput."""
    text = data.decode("utf-8", "replace")
    if len(data) > _BYTES or not text.lstrip("\ufeff \r\n").startswith("ISO-10303-21"):
        raise UnusableInput(
            phrase(
                "{file}: is no attribute file of ISO 13399 (it would begin with ISO-10303-21); "
                "download the tool's data again",
                file=path,
            )
        )
    if not text.rstrip("\0\x1a \r\n\t").endswith("END-ISO-10303-21;"):
        raise UnusableInput(
            phrase(
                "{file}: ends before its end (END-ISO-10303-21); download the tool's data again",
                file=path,
            )
        )
    found: dict[str, _Entity] = {}
    said: list[str] = []
    depth, before = 0, ""
    for part in _PART.findall(text):
        if part == ";":
            head = _INSTANCE.search(before)
            if head is not None:
                found[head[1]] = _Entity(head[2], tuple(one.strip() for one in said))
            said, depth, before = [], 0, ""
        elif depth == 0 and part not in "(),":
            before += part
        elif part == "(" and depth == 0:
            said, depth = [""], 1
        elif part == "," and depth == 1:
            said.append("")
        else:
            depth += {"(": 1, ")": -1}.get(part, 0)
            if depth > 0:
                said[-1] += part
    return found


def _values(path: Path, entities: dict[str, _Entity]) -> Iterator[tuple[str, float]]:
    """Yield the values that count, by symbol: in millimetres, degrees, or counted."""
    for kind, said in entities.values():
        if kind != "NUMERICAL_VALUE" or len(said) < 4:
            continue
        symbol, value = _text(said[0]), _text(said[3])
        if symbol not in (*_LENGTHS, *_ANGLES, *_COUNTS):
            continue
        unit = entities.get(said[2].lstrip("#"), _Entity("", ()))
        unit_name = _text(unit.said[0]) if unit.kind == "UNIT" and unit.said else ""
        factor = 1.0
        if symbol in _LENGTHS:
            factor = _MM.get(unit_name.lower(), math.nan)
        elif symbol in _ANGLES and unit_name.lower() == "rad":
            factor = math.degrees(1.0)
        try:
            number = float(value.replace(",", ".")) * factor
        except ValueError:
            number = math.nan
        if not math.isfinite(number):
            raise UnusableInput(
                phrase(
                    "{file}: {symbol} = '{value}' {unit} is no quantity; use data in mm or inch",
                    file=path,
                    symbol=symbol,
                    value=value,
                    unit=unit_name,
                )
            )
        yield symbol, number


def _designations(entities: dict[str, _Entity]) -> Iterator[str]:
    """Yield what the items are called: by their maker's name, or their order number."""
    for kind, said in entities.values():
        if kind == "ITEM" and len(said) >= 3:
            yield _resolved(said[2], entities) or _text(said[1])


def _resolved(reference: str, entities: dict[str, _Entity], depth: int = 3) -> str:
    """Return the text that a reference leads to, or nothing."""
    if reference.startswith("'"):
        return _text(reference)
    pointed = entities.get(reference.lstrip("#"))
    if pointed is None or depth == 0:
        return ""
    wanted = {"MULTI_LANGUAGE_STRING": -1, "STRING_WITH_LANGUAGE": 0}.get(pointed.kind)
    if wanted is None or not pointed.said:
        return ""
    return _resolved(pointed.said[wanted], entities, depth - 1)


def _text(said: str) -> str:
    """Return what a string holds, characters beyond ASCII as ISO 10303-21 writes them."""
    inner = said[1:-1].replace("''", "'") if said.startswith("'") else said
    return _WIDE.sub(lambda m: bytes.fromhex(m[1]).decode("utf-16-be", "replace"), inner).strip()
