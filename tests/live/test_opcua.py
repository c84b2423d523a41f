"""An OPC UA server as it is read: namespaces by URI, units, security."""

import asyncio
from collections.abc import Awaitable, Callable, Iterable
from contextlib import aclosing
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import pytest
from asyncua import ua
from asyncua.crypto.cert_gen import generate_private_key, generate_self_signed_app_certificate
from asyncua.crypto.permission_rules import SimpleRoleRuleset, User, UserRole
from asyncua.server.server import Server
from asyncua.server.user_managers import UserManager
from cryptography.hazmat.primitives.serialization import Encoding, NoEncryption, PrivateFormat
from cryptography.x509.oid import ExtendedKeyUsageOID

from autodb.agent.operate.checking import check_machine
from autodb.errors import UnusableInput
from autodb.live.agentfile import AgentFile
from autodb.live.batch import Batch, Position
from autodb.live.opcua import OpcUa
from tests.conftest import Cli
from tests.helpers.shifts import free_port

LEFT, RIGHT = "urn:shop:left", "urn:shop:right"
ITEM = f"nsu={LEFT};s=X.Current"
SECRET = "OPC_SECRET"


def _plan(port: int, item: str, **source: str) -> AgentFile:
    return AgentFile.model_validate(
        {
            "machine": "m", "rate_hz": 10.0,
            "source": {
                "protocol": "opcua", "url": f"opc.tcp://127.0.0.1:{port}/", "publish_ms": 50.0,
                **source,
            },
            "channels": {"x.current": item},
            "cut": {"while": [{"item": item, "above": 0.0}]},
        }
    )  # fmt: skip


async def _served(
    port: int, order: tuple[str, ...], then: Callable[[], Awaitable[None]], server: Server
) -> None:
    """Serve machines, X.Current of each a node of its namespace, registered in an order."""
    server.set_endpoint(f"opc.tcp://127.0.0.1:{port}/")
    for uri in order:
        space = await server.register_namespace(uri)
        node = await server.nodes.objects.add_variable(
            ua.NodeId(ua.String("X.Current"), ua.Int16(space)),
            "X.Current",
            1.0 if uri == LEFT else 2.0,
        )
        info = ua.EUInformation(DisplayName=ua.LocalizedText("mA"))
        await node.add_property(0, "EngineeringUnits", info)
    async with server:
        await then()


async def _plainly(port: int, order: tuple[str, ...], then: Callable[[], Awaitable[None]]) -> None:
    server = Server()
    await server.init()
    await _served(port, order, then, server)


async def _first(plan: AgentFile, after: Position | None = None) -> Batch:
    async with aclosing(OpcUa(plan).batches(after)) as batches:
        async for one in batches:
            if one.values:
                return one
    raise AssertionError("nothing was said")


def test_a_namespaces_uri_finds_its_machine_in_whatever_order(cli: Cli) -> None:
    """By its number the other machine is read; the number's URI is kept, and another refused."""
    del cli
    port, before = free_port(), []
    for order in ((LEFT, RIGHT), (RIGHT, LEFT)):

        async def read(order: tuple[str, ...] = order) -> None:
            item = f"nsu={LEFT};s=X.Current"
            assert (await _first(_plan(port, item))).values[item][1] == [1.0]
            offered = [one.item for one in await OpcUa(_plan(port, item)).offered()]
            assert f"nsu={RIGHT};s=X.Current" in offered
            numbered = _plan(port, "ns=2;s=X.Current")
            if order[0] == LEFT:
                before.append((await _first(numbered)).position)
            else:
                with pytest.raises(UnusableInput, match=f"namespace 2 was {LEFT} and is {RIGHT}"):
                    await _first(numbered, before[0])
            with pytest.raises(UnusableInput, match="has no namespace urn:shop:lefd"):
                await _first(_plan(port, "nsu=urn:shop:lefd;s=X.Current"))

        asyncio.run(_plainly(port, order, read))


def test_check_fails_where_a_unit_is_not_the_stated_one(cli: Cli) -> None:
    del cli
    port = free_port()
    item = f"nsu={LEFT};s=X.Current"

    async def read() -> None:
        found = await asyncio.to_thread(check_machine, _plan(port, item), listing=False)
        assert found.never == (
            f'{item} is sent in mA, and x.current is read in A; state unit = "mA"',
        )

    asyncio.run(_plainly(port, (LEFT,), read))


class _OneUser(UserManager):
    """Lets in the user `agent` with the password `1234`, and nobody else."""

    def get_user(  # type: ignore[no-untyped-def]  # asyncua's own is not typed
        self, iserver, username=None, password=None, certificate=None
    ) -> User | None:
        del iserver, certificate
        known = username == "agent" and password == "1234"
        return User(role=UserRole.User) if known else None


def _certificate(name: str, uri: str) -> tuple[Path, Path]:
    """Write a certificate of an application and its key; return both files."""
    key = generate_private_key()
    made = generate_self_signed_app_certificate(
        key, name, {"organizationName": "shop"}, [x509_uri(uri)], [ExtendedKeyUsageOID.CLIENT_AUTH]
    )
    files = Path(f"{name}.der"), Path(f"{name}.pem")
    files[0].write_bytes(made.public_bytes(Encoding.DER))
    files[1].write_bytes(
        key.private_bytes(Encoding.PEM, PrivateFormat.TraditionalOpenSSL, NoEncryption())
    )
    return files


def x509_uri(uri: str):  # type: ignore[no-untyped-def]  # as cryptography names it
    """Return an application's URI as certificates have it."""
    from cryptography import x509

    return x509.UniformResourceIdentifier(uri)


@dataclass
class _Secured:
    """A server that takes Basic256Sha256, signed and encrypted, and one user alone."""

    port: int
    server: Server
    own: tuple[Path, Path]

    def plan(self, **other: str) -> AgentFile:
        """Return the plan of an agent with its own certificate, or another text of security."""
        secured = f"Basic256Sha256,SignAndEncrypt,{self.own[0]},{self.own[1]}"
        said = {"security": secured, "user": "agent", "password_env": SECRET}
        return _plan(self.port, ITEM, **said | other)

    def serve(self, then: Callable[[], Awaitable[None]]) -> None:
        """Serve while something is done."""
        files = _certificate("server", "urn:freeopcua:python:server")

        async def served() -> None:
            await self.server.init()
            await self.server.load_certificate(str(files[0]))
            await self.server.load_private_key(str(files[1]))
            await _served(self.port, (LEFT,), then, self.server)

        asyncio.run(served())


@pytest.fixture
def secured(cli: Cli, monkeypatch: pytest.MonkeyPatch) -> _Secured:
    """Return a secured server, in a folder that is the test's own."""
    del cli
    monkeypatch.setenv(SECRET, "1234")
    server = Server(user_manager=_OneUser())
    server.set_security_policy(
        [ua.SecurityPolicyType.Basic256Sha256_SignAndEncrypt],
        permission_ruleset=SimpleRoleRuleset(),  # type: ignore[no-untyped-call]
    )
    return _Secured(free_port(), server, _certificate("agent", "urn:shop:agent"))


def test_a_secured_server_is_read_with_certificate_and_user(
    secured: _Secured, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Basic256Sha256, signed and encrypted; the client calls itself what its certificate does."""
    key = secured.own[1]

    async def read() -> None:
        assert (await _first(secured.plan())).values[ITEM][1] == [1.0]
        monkeypatch.setenv(SECRET, "12345")
        with pytest.raises(UnusableInput, match=r"127\.0\.0\.1"):
            await _first(secured.plan())
        for wrong, line in (
            ("Basic256Sha256,SignAndEncrypt,none.der,none.pem", "no file none.der"),
            ("Basic256Sha256", "is not POLICY,MODE,CERTIFICATE,KEY"),
            (f"Basic256Sha256,SignAndEncrypt,{key},{key}", "is no certificate"),
        ):
            with pytest.raises(UnusableInput, match=line):
                await _first(secured.plan(security=wrong))

    secured.serve(read)


def test_what_a_secured_server_remembers_is_read_behind_where_one_was_then_it_goes_on(
    secured: _Secured,
) -> None:
    """Its history has what was said while nobody listened; nothing is lost or comes twice."""
    begins = datetime.now(UTC).replace(microsecond=0)  # asyncua keeps its history in order of time
    server = secured.server

    async def said(numbers: Iterable[int]) -> None:
        node = server.get_node(ua.NodeId(ua.String("X.Current"), ua.Int16(2)))
        for number in numbers:
            stamp: Any = begins + timedelta(seconds=5 + 0.5 * number)
            value = ua.DataValue(ua.Variant(float(number)), SourceTimestamp=stamp)
            await server.write_attribute_value(node.nodeid, value)
        storage = server.iserver.history_manager.storage  # is filled a while behind
        while not (await storage.read_node_history(node.nodeid, stamp, None, nb_values=1))[0]:
            await asyncio.sleep(0.05)

    async def read() -> None:
        node = server.get_node(ua.NodeId(ua.String("X.Current"), ua.Int16(2)))
        await server.historize_node_data_change(node, timedelta(days=3650))
        await said([10])
        first = await _first(secured.plan())
        await said(range(11, 40))
        heard: list[Batch] = []
        async with aclosing(OpcUa(secured.plan()).batches(first.position)) as batches:
            async for one in batches:
                heard.append(one)
                if len(heard) == 1:
                    await said([40])
                if one.values and one.values[ITEM][1][-1] == 40.0:
                    break
        values = [value for one in heard for value in one.values.get(ITEM, ((), ()))[1]]
        assert list(dict.fromkeys([*first.values[ITEM][1], *values])) == [
            *map(float, range(10, 41))
        ]
        assert not any(one.gap or one.lost for one in heard)
        instants = [at for one in heard for at in one.values.get(ITEM, ((), ()))[0]]
        assert instants == sorted(instants)

    secured.serve(read)
