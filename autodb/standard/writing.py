"""Writes a protocol as a TOML file that reads back as the same protocol."""

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from autodb.errors import UnusableInput
from autodb.files.targets import hidden, replace_by
from autodb.standard.protocol import CutProtocol
from autodb.wording import phrase


def as_toml(protocol: CutProtocol) -> str:
    """Return a protocol as TOML; what it does not state is left out."""
    stated = protocol.model_dump(exclude_none=True, exclude_defaults=True)
    return "\n".join(_section("", stated)).strip() + "\n"


def _section(path: str, values: Mapping[str, Any]) -> Iterator[str]:
    """Yield a table's own keys, then the tables in it under their full names."""
    for key, value in values.items():
        if not isinstance(value, (dict, tuple)):
            yield f"{key} = {json.dumps(value, ensure_ascii=False)}"
    for key, value in values.items():
        name = f"{path}.{key}" if path else key
        if isinstance(value, tuple):
            for part in value:
                yield from ("", f"[[{name}]]")
                yield from _section(name, part)
        elif isinstance(value, dict):
            own = any(not isinstance(part, (dict, tuple)) for part in value.values())
            yield from ("", f"[{name}]") if own else ()
            yield from _section(name, value)


def write_once(text: str, path: Path) -> bool:
    """Write a file whole or not at all; False where it is there already with the same text.

    Raises UnusableInput where it is there with another.
    """
    with hidden(path) as part:
        if path.exists():
            if path.read_bytes() == text.encode():
                return False
            raise UnusableInput(
                phrase("{file}: is there already and differs; use another --out", file=path)
            )
        part.write_text(text, encoding="utf-8")
        replace_by(part, path)
    return True
