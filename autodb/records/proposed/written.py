"""A side file of what is proposed for a file's columns, with the reasons as remarks."""

import json
from collections.abc import Iterator, Sequence

from autodb.files.operation_words import suggested_operation
from autodb.records.proposed.columns import ProposedBase
from autodb.records.proposed.cuts import ChannelProposal


def side_file_of(found: Sequence[ProposedBase], name: str) -> str:
    """Return the side file of a file called ``name`` as TOML; of a channel the first proposal."""
    return "\n".join([f"# proposed by 'autodb look {name}'; check it", *_lines(found)]) + "\n"


def _lines(found: Sequence[ProposedBase]) -> Iterator[str]:
    yield "[channels]"
    taken: set[str] = set()
    for one in (proposal for base in found for proposal in base.proposals):
        if one.channel not in taken and one.channel != one.column:
            yield f"{json.dumps(one.channel)} = {_column(one)}  # {one.because}"
        taken.add(one.channel)
    operations = dict.fromkeys(text for base in found for text in base.operations)
    if operations:
        yield "[values]"
        known = [(text, suggested_operation(text)) for text in operations]
        means = [f"{_text(text)} = {_text(name)}" for text, name in known if name is not None]
        yield f"operation = {{{', '.join(means)}}}"
        yield from (f"# no operation is known for {_text(t)}" for t, name in known if name is None)


def _column(one: ChannelProposal) -> str:
    if one.column == "*":
        return f'{{row_in = "*", step_s = {one.unit}}}' if one.unit else '{row_in = "*"}'
    if one.unit:
        return f"{{column = {_text(one.column)}, unit = {_text(one.unit)}}}"
    return _text(one.column)


def _text(text: str) -> str:
    """Return a text as TOML writes it between quotes, which JSON does alike."""
    return json.dumps(text, ensure_ascii=False)
