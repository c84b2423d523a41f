"""An OPC UA server as it is read: namespaces by URI, units, security."""

import asyncio
from collections.abc import Awaitable, Callable
from contextlib import aclosing
from pathlib import Path

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


def test_a_secured_server_is_read_with_certificate_and_user(
    cli: Cli, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Basic256Sha256, signed and encrypted; the client calls itself what its certificate does."""
    del cli
    monkeypatch.setenv(SECRET, "1234")
    own, own_key = _certificate("agent", "urn:shop:agent")
    theirs, their_key = _certificate("server", "urn:freeopcua:python:server")
    port, item = free_port(), f"nsu={LEFT};s=X.Current"
    server = Server(user_manager=_OneUser())
    server.set_security_policy(
        [ua.SecurityPolicyType.Basic256Sha256_SignAndEncrypt],
        permission_ruleset=SimpleRoleRuleset(),  # type: ignore[no-untyped-call]
    )

    async def read() -> None:
        secured = f"Basic256Sha256,SignAndEncrypt,{own},{own_key}"
        plan = _plan(port, item, security=secured, user="agent", password_env=SECRET)
        assert (await _first(plan)).values[item][1] == [1.0]
        monkeypatch.setenv(SECRET, "12345")
        with pytest.raises(UnusableInput, match=r"127\.0\.0\.1"):
            await _first(plan)
        for wrong, line in (
            ("Basic256Sha256,SignAndEncrypt,none.der,none.pem", "no file none.der"),
            ("Basic256Sha256", "is not POLICY,MODE,CERTIFICATE,KEY"),
            (f"Basic256Sha256,SignAndEncrypt,{own_key},{own_key}", "is no certificate"),
        ):
            with pytest.raises(UnusableInput, match=line):
                await _first(_plan(port, item, security=wrong))

    async def load_and_serve() -> None:
        await server.init()
        await server.load_certificate(str(theirs))
        await server.load_private_key(str(their_key))
        await _served(port, (LEFT,), read, server)

    asyncio.run(load_and_serve())
