"""What an MTConnect agent says, as it is read."""

import asyncio
import json
from contextlib import aclosing
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import pytest
from numpy.testing import assert_allclose

from autodb.errors import UnusableInput
from autodb.live.agentfile import read_agentfile
from autodb.live.batch import Batch
from autodb.live.mtconnect import MtConnect
from autodb.live.mtconnect_documents import StreamParts, Wanted, read_streams
from autodb.live.source import Away
from autodb.proofs.machines.served.mtconnect import MtConnectServer
from tests.helpers.running_machine import (
    write_agentfile,
)
from tests.helpers.shifts import LATHE


def _streams(first: int, following: int, value: float) -> str:
    header = f'instanceId="7" firstSequence="{first}" nextSequence="{following}"'
    load = f'dataItemId="load" sequence="{following - 1}"'
    instant = f"2026-01-01T00:00:{following:02d}Z"
    return f"""<MTConnectStreams><Header {header}/>
    <Load {load} timestamp="{instant}">{value}</Load></MTConnectStreams>"""


FORGOTTEN = '<MTConnectError><Error errorCode="OUT_OF_RANGE">from: 7</Error></MTConnectError>'


@pytest.mark.parametrize("as_part", [True, False], ids=["in the stream", "as its answer"])
@pytest.mark.usefixtures("cli")
def test_what_is_forgotten_while_it_is_read_is_a_gap_at_once(
    monkeypatch: pytest.MonkeyPatch, as_part: bool
) -> None:
    """Read on from what the agent still has, without a word of its being away."""
    probe = '<a><DataItem id="load" category="SAMPLE" type="LOAD"/></a>'
    refused = (
        httpx.Response(200, content=_part(_streams(1, 7, 2.0)) + _part(FORGOTTEN))
        if as_part
        else httpx.Response(404, text=FORGOTTEN)
    )
    answers: dict[str, list[str | httpx.Response]] = {
        "/probe": [probe],
        "/current": [_streams(1, 5, 1.0), _streams(20, 30, 9.0), _streams(20, 30, 3.0)],
        "/sample": [refused, httpx.Response(200, content=_part(_streams(20, 31, 4.0)))],
    }

    def answer(request: httpx.Request) -> httpx.Response:
        said = answers[request.url.path].pop(0)
        return httpx.Response(200, text=said) if isinstance(said, str) else said

    path = write_agentfile(MtConnectServer(LATHE), LATHE, protocol="mtconnect")
    source = MtConnect(read_agentfile(path))
    source._items = ["load"]
    transport = httpx.MockTransport(answer)
    monkeypatch.setattr(source, "_client", lambda: httpx.AsyncClient(transport=transport))
    monkeypatch.setattr(source, "_base", "http://agent")
    found: list[tuple[Any, bool, int]] = []

    def keep(one: Batch) -> None:
        found.append((one.values["load"][1][0], one.gap, one.position["next"]))

    async def read() -> None:
        async with aclosing(source.batches(None)) as batches:
            async for one in batches:
                keep(one)

    with pytest.raises(Away, match="ended its stream"):
        asyncio.run(read())
    heard = [(2.0, False, 7)] if as_part else []
    assert found == [(1.0, False, 5), *heard, (3.0, True, 20), (4.0, False, 31)]
    assert not any(answers.values())


def _part(body: str) -> bytes:
    head = f"--b\r\nContent-type: text/xml\r\nContent-LENGTH: {len(body)}\r\n\r\n"
    return head.encode() + body.encode() + b"\r\n"


def test_parts_come_out_whole_however_they_come_in() -> None:
    stream = _part("<a>\r\n\r\n</a>") + _part("") + _part("<b/>")
    for step in (1, 2, 7, len(stream)):
        parts = StreamParts()
        found = [
            part
            for begin in range(0, len(stream), step)
            for part in parts.feed(stream[begin : begin + step])
        ]
        assert found == [b"<a>\r\n\r\n</a>", b"", b"<b/>"]
    with pytest.raises(ValueError, match="without Content-length"):
        StreamParts().feed(b"--b\r\nContent-type: text/xml\r\n\r\n")


def test_a_time_series_ends_at_its_timestamp() -> None:
    """MTConnect, TimeSeries: the timestamp is that of the last value; unknown is no number."""
    text = """<MTConnectStreams xmlns="urn:mtconnect.org:MTConnectStreams:2.2">
    <Header instanceId="7" nextSequence="9" firstSequence="1"/><Streams><Samples>
    <LoadTimeSeries dataItemId="a" sequence="4" timestamp="2026-01-01T00:00:01.123456789Z"
      sampleCount="3">1 2.5 -3e2</LoadTimeSeries>
    <Position dataItemId="b" sequence="6" timestamp="2026-01-01T00:00:02Z@0.5">5</Position>
    <Position dataItemId="b" sequence="5" timestamp="2026-01-01T00:00:01Z">UNAVAILABLE</Position>
    <Execution dataItemId="c" sequence="7" timestamp="2026-01-01T00:00:01Z">ACTIVE</Execution>
    <Warning dataItemId="d" sequence="8" timestamp="2026-01-01T00:00:01Z"/>
    <Position dataItemId="e" sequence="8" timestamp="2026-01-01T00:00:01Z">1</Position>
    </Samples></Streams></MTConnectStreams>"""
    found = read_streams(text.encode(), {"a": 100.0}, {name: {None} for name in "abcd"})
    start = 1767225600.0
    assert_allclose(found.values["a"][0], start + 1.123456 - np.array([0.02, 0.01, 0.0]))
    assert found.values["a"][1] == [1.0, 2.5, -300.0]
    assert found.values["b"] == ([start + 1.0, start + 2.0], [None, 5.0])
    assert found.values["c"][1] == ["ACTIVE"]
    assert found.values["d"][1] == ["Warning"]
    assert set(found.values) == {"a", "b", "c", "d"}
    assert found.following == 9
    with pytest.raises(ValueError, match="no sampleRate"):
        read_streams(text.encode(), {}, {"a": {None}})
    with pytest.raises(ValueError, match="too far back"):
        read_streams(b"<MTConnectError><Error>too far back</Error></MTConnectError>", {}, {})


def test_bare_line_feeds_part_a_stream_too() -> None:
    bodies = ("<a>\n\n\n</a>", "<b/>")
    stream = "".join(
        f"--b\nContent-type: text/xml\nContent-length: {len(body)}\n\n{body}\n" for body in bodies
    ).encode()
    for step in (1, 3, len(stream)):
        parts = StreamParts()
        pieces = [stream[begin : begin + step] for begin in range(0, len(stream), step)]
        found = [part for piece in pieces for part in parts.feed(piece)]
        assert found == [body.encode() for body in bodies]


IN_SPACE = """<MTConnectStreams><Header instanceId="7" nextSequence="9" firstSequence="1"/>
<PathPosition dataItemId="p" sequence="4" timestamp="2026-01-01T00:00:01Z">1.5 -2 3e1</PathPosition>
<VariableDataSet dataItemId="v" sequence="5" timestamp="2026-01-01T00:00:02Z" count="2">
  <Entry key="R10">2.5</Entry><Entry key="NAME">C45</Entry></VariableDataSet>
<VariableDataSet dataItemId="v" sequence="6" timestamp="2026-01-01T00:00:03Z" count="1">
  <Entry key="R10" removed="true"/></VariableDataSet>
<PathPosition dataItemId="p" sequence="7"
  timestamp="2026-01-01T00:00:04Z">UNAVAILABLE</PathPosition>
</MTConnectStreams>"""


def test_parts_of_positions_and_of_sets_of_data_are_items() -> None:
    """MTConnect: three numbers in space; a set says only the entries that changed."""
    wanted: Wanted = {"p": {"x", "z"}, "v": {"R10", "NAME"}}
    found = read_streams(IN_SPACE.encode(), {}, wanted).values
    assert {key: said[1] for key, said in found.items()} == {
        "p[x]": [1.5, None], "p[z]": [30.0, None], "v[R10]": [2.5, None], "v[NAME]": ["C45"],
    }  # fmt: skip


def _answering(
    monkeypatch: pytest.MonkeyPatch, items: list[str], answers: dict[str, str]
) -> MtConnect:
    """Return a source of items whose agent says these texts; the sample stream ends."""
    path = write_agentfile(MtConnectServer(LATHE), LATHE, protocol="mtconnect")
    source = MtConnect(read_agentfile(path))
    source._items = source._channels = items

    def answer(request: httpx.Request) -> httpx.Response:
        if request.url.path == "/sample":
            return httpx.Response(200, content=b"")
        return httpx.Response(200, text=answers[request.url.path])

    transport = httpx.MockTransport(answer)
    monkeypatch.setattr(source, "_client", lambda: httpx.AsyncClient(transport=transport))
    monkeypatch.setattr(source, "_base", "http://agent")
    return source


PROBE = """<a><DataItem id="p" name="Ppos" category="SAMPLE" type="PATH_POSITION"
  units="MILLIMETER_3D" nativeUnits="INCH_3D"/>
<DataItem id="v" category="EVENT" type="VARIABLE" representation="DATA_SET"/></a>"""


@pytest.mark.usefixtures("cli")
def test_what_is_offered_has_the_unit_it_is_sent_in(monkeypatch: pytest.MonkeyPatch) -> None:
    source = _answering(monkeypatch, ["Ppos[x]", "v[R10]"], {"/probe": PROBE, "/current": IN_SPACE})
    offered = asyncio.run(source.offered())
    assert [(one.item, one.unit) for one in offered] == [
        ("p[x]", "MILLIMETER"), ("p[y]", "MILLIMETER"), ("p[z]", "MILLIMETER"), ("v[R10]", ""),
        ("v[NAME]", ""),
    ]  # fmt: skip
    assert asyncio.run(source.units()) == {"Ppos[x]": "MILLIMETER"}
    source._items = ["Ppos"]
    with pytest.raises(
        UnusableInput, match=r"'Ppos' is 3 numbers; use one of them, like Ppos\[x\]"
    ):
        asyncio.run(source.units())


@pytest.mark.usefixtures("cli")
def test_an_agent_that_starts_anew_under_its_old_number_is_read_from_its_beginning(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Its numbers are lower than those we have: it was asked for number 900 for ever."""
    answers = {"/probe": '<a><DataItem id="load"/></a>', "/current": _streams(1, 5, 2.0)}
    source = _answering(monkeypatch, ["load"], answers)
    found: list[Batch] = []

    async def read() -> None:
        after = {"instance": "7", "next": 900, "upto_s": 1.0}
        async with aclosing(source.batches(after)) as batches:
            async for one in batches:
                found.append(one)  # noqa: PERF401 - the stream ends by an error

    with pytest.raises(Away, match="ended its stream"):
        asyncio.run(read())
    assert [(one.gap, one.position["next"]) for one in found] == [(True, 1)]


def _said(first: int, last: int, *, since: str, rows: list[int] | None = None) -> str:
    """Return observations of an agent which began to count at an instant, one a second."""
    header = f'instanceId="7" firstSequence="{first}" nextSequence="{last + 1}"'
    loads = "".join(
        f'<Load dataItemId="load" sequence="{row}" timestamp="{since}:{row:02d}Z">{row}</Load>'
        for row in (range(first, last + 1) if rows is None else rows)
    )
    return f"<MTConnectStreams><Header {header}/>{loads}</MTConnectStreams>"


@pytest.mark.usefixtures("cli")
@pytest.mark.parametrize(
    ("since", "first", "begins", "why"),
    [
        ("2026-01-01T00:00", 1, 21, ""),
        ("2026-01-01T00:07", 1, 1, "the agent was started anew, and says its old instance"),
        ("2026-01-01T00:07", 12, 12, "the agent was started anew, and says its old instance"),
        ("2026-01-01T00:07", 30, 30, "the agent's buffer has no more all that was said meanwhile"),
    ],
    ids=["goes on", "anew", "anew, and has forgotten its first", "forgotten, cannot be known"],
)
def test_an_agent_that_counted_past_where_we_were_is_known_by_what_we_heard_last(
    monkeypatch: pytest.MonkeyPatch, since: str, first: int, begins: int, why: str
) -> None:
    """It was started anew under its old instance, and has come further than number 20."""
    asked: list[int] = []

    def answer(request: httpx.Request) -> httpx.Response:
        if request.url.path == "/probe":
            return httpx.Response(200, text='<a><DataItem id="load"/></a>')
        if request.url.path == "/current":
            at = int(request.url.params.get("at", 40))
            return httpx.Response(200, text=_said(first, 40, since=since, rows=[at]))
        asked.append(int(request.url.params["from"]))
        rest = [*range(asked[-1], 41)]
        return httpx.Response(200, content=_part(_said(first, 40, since=since, rows=rest)))

    source = _answering(monkeypatch, ["load"], {})
    transport = httpx.MockTransport(answer)
    monkeypatch.setattr(source, "_client", lambda: httpx.AsyncClient(transport=transport))
    earlier = read_streams(_said(1, 20, since="2026-01-01T00:00").encode(), {}, {"load": {None}})
    heard = json.loads(json.dumps(earlier.mark))  # as the journal has it
    after = {"instance": "7", "next": 21, "upto_s": earlier.values["load"][0][-1], "heard": heard}
    found: list[Batch] = []

    async def read() -> None:
        async with aclosing(source.batches(after)) as batches:
            async for one in batches:
                found.append(one)  # noqa: PERF401 - the stream ends by an error

    with pytest.raises(Away, match="ended its stream"):
        asyncio.run(read())
    assert asked == [begins]
    assert (found[0].gap, found[0].why) == (bool(why), why)
    said = [value for one in found if not one.gap for value in one.values["load"][1]]
    assert said == [float(row) for row in range(begins, 41)]
    assert list(found[-1].position["heard"]) == [40, "load", f"{since}:40Z"]


def test_what_is_known_again_is_no_condition_of_several() -> None:
    text = """<MTConnectStreams><Header/><Samples>
    <Load dataItemId="load" sequence="4" timestamp="2026-01-01T00:00:04Z">1</Load>
    <Fault dataItemId="load" sequence="9" timestamp="2026-01-01T00:00:09Z"/>
    </Samples></MTConnectStreams>"""
    found = read_streams(text.encode(), {}, {"load": {None}})
    assert found.mark == (4, "load", "2026-01-01T00:00:04Z")


@pytest.mark.usefixtures("lathe")
def test_an_agent_that_talks_nonsense_is_away() -> None:
    source = MtConnect(read_agentfile(Path("agent.toml")))
    with pytest.raises(Away, match="cannot be read"):
        source._read(b"<html>")
    assert issubclass(Away, UnusableInput)
