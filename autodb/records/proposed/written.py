"""Side files written: of what is proposed for a file's columns, and of what is stated."""

import json
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import tomli_w

from autodb.files.operation_words import suggested_operation
from autodb.files.side import FileColumn, SideFile, stated_side
from autodb.records.proposed.columns import ProposedBase
from autodb.records.proposed.cuts import ChannelProposal

_FROM_FILE = "the proposed side file"


def proposed_side(found: Sequence[ProposedBase]) -> SideFile:
    """Return what is proposed for a file as a side file; of a channel the first proposal."""
    channels: dict[str, Any] = {}
    for one in (proposal for base in found for proposal in base.proposals):
        channels.setdefault(one.channel, _stated(one))
    own = {one.channel for base in found for one in base.proposals if one.channel == one.column}
    channels = {name: said for name, said in channels.items() if name not in own}
    means = {text: name for text in _operations(found) if (name := suggested_operation(text))}
    said: dict[str, Any] = {"channels": channels}
    if means:
        said["values"] = {"operation": means}
    return stated_side(said, where=_FROM_FILE)


def side_file_of(found: Sequence[ProposedBase], name: str) -> str:
    """Return the side file that is proposed for a file called ``name``, with the reasons."""
    because = {one.channel: one.because for base in reversed(found) for one in base.proposals}
    unknown = [text for text in _operations(found) if suggested_operation(text) is None]
    lines = [f"# no operation is known for {_text(text)}" for text in unknown]
    written = side_text(proposed_side(found), because)
    return "\n".join(
        [
            f"# proposed by 'autodb look {name}'; check it",
            written.rstrip(),
            *lines,
            *_of_all_rows(found),
            "",
        ]
    )


def _of_all_rows(found: Sequence[ProposedBase]) -> Iterator[str]:
    """Yield how to say of all rows at once what no column of a table of cuts says."""
    cuts = [one for one in found if one.holds_cuts]
    said = {one.channel for base in cuts for one in base.proposals}
    if not cuts or {"work.material", "tool"} <= said:
        return
    yield "# of cuts nothing is learnt while nobody says of what material and with which tool;"
    yield "# where all are alike, without the '#' and with your names:"
    if "work.material" not in said:
        yield "# [recording]"
        yield '# work = "C45"  # as jobs call it'
    if "tool" not in said:
        yield "# [tool]"
        yield '# name = "CNMG 120408"'


def side_text(side: SideFile, because: Mapping[str, str] | None = None) -> str:
    """Return a side file as TOML; ``because``: remarks behind channels."""
    rest = side.model_dump(mode="json", exclude_defaults=True)
    said = {key: rest.pop(key) for key in ("channels", "values") if key in rest}
    others = tomli_w.dumps(rest)
    return "\n".join([*_tables(side, said.get("values", {}), because or {}), others])


def _tables(side: SideFile, values: Mapping[str, Any], because: Mapping[str, str]) -> Iterator[str]:
    yield "[channels]"
    for channel, spec in side.channels.items():
        remark = f"  # {because[channel]}" if channel in because else ""
        yield f"{_text(channel)} = {_column(spec)}{remark}"
    if values:
        yield "[values]"
    for key, means in values.items():
        pairs = [f"{_text(text)} = {_text(name)}" for text, name in means.items()]
        yield f"{key} = {{{', '.join(pairs)}}}"


def _operations(found: Sequence[ProposedBase]) -> list[str]:
    return list(dict.fromkeys(text for base in found for text in base.operations))


def _stated(one: ChannelProposal) -> dict[str, Any]:
    if one.column == "*":
        return {"row_in": "*"} | ({"step_s": float(one.unit)} if one.unit else {})
    return {"column": one.column} | ({"unit": one.unit} if one.unit else {})


def _column(spec: FileColumn) -> str:
    said = spec.model_dump(mode="json", exclude_defaults=True)
    if said.keys() == {"column"}:
        return _text(str(spec.column))
    return f"{{{', '.join(f'{key} = {_text(value)}' for key, value in said.items())}}}"


def _text(value: object) -> str:
    """Return a text, a number or a truth as TOML writes it, which JSON does alike."""
    return json.dumps(value, ensure_ascii=False)
