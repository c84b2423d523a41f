"""`serve` and `token`: the database over HTTP, and who may use it."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from autodb.cli._common import Database, opened, say, show, table

if TYPE_CHECKING:
    from autodb.web.server import Certificate
    from autodb.web.settings import Settings

EXTRA = "serving needs the extra 'serve': pip install 'autodb[serve]' would work"

token = typer.Typer(help="Access tokens of the service.", no_args_is_help=True)
TokenName = Annotated[str, typer.Argument(help="Name of the token: who uses it.")]


def serve(
    host: Annotated[
        str,
        typer.Option(
            "--host", help="Address to listen at; any but this computer's own needs tokens."
        ),
    ] = "127.0.0.1",
    port: Annotated[
        int, typer.Option("--port", min=0, max=65535, help="Port to listen at; 0: a free one.")
    ] = 8321,
    write: Annotated[
        bool, typer.Option("--write", help="Let tokens of role operate or admin change something.")
    ] = False,
    name: Annotated[
        list[str] | None,
        typer.Option(
            "--name", metavar="HOST", help="Name of a host to answer to; may be given again."
        ),
    ] = None,
    certificate: Annotated[
        Path | None, typer.Option("--certificate", metavar="FILE", help="TLS certificate (PEM).")
    ] = None,
    key: Annotated[
        Path | None, typer.Option("--key", metavar="FILE", help="Key of the certificate (PEM).")
    ] = None,
    db: Database = None,
) -> None:
    """Answer look-ups over HTTP: read-only, and to this computer alone, unless told otherwise."""
    from autodb.errors import UnusableInput
    from autodb.store import database_url

    try:
        from autodb.web import server
        from autodb.web.app import make_app
        from autodb.web.settings import Settings
    except ImportError:
        raise UnusableInput(EXTRA) from None
    tls = _certificate(certificate, key)
    settings = Settings(database_url(db), host, port, write, tuple(name or ()), tls is not None)
    _refuse_unusable(settings, db)
    listening = server.bound(settings)
    shown = f"[{host}]" if ":" in host else host
    scheme, does = "https" if tls else "http", "read and write" if write else "read-only"
    at = f"{scheme}://{shown}:{listening.getsockname()[1]}"
    say(f"{at}/api/v1: {does}; Ctrl-C stops it")
    if not settings.on_loopback and tls is None:
        say("without TLS tokens can be read on their way: --certificate and --key would work")
    server.run(make_app(settings), listening, tls)


def _certificate(chain: Path | None, key: Path | None) -> "Certificate | None":
    """Return a certificate that can be used; raises UnusableInput."""
    import ssl

    from autodb.errors import UnusableInput
    from autodb.web.server import Certificate

    if chain is None and key is None:
        return None
    if chain is None or key is None:
        raise UnusableInput("--certificate and --key: both would work")
    try:
        ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER).load_cert_chain(chain, key)
    except (OSError, ssl.SSLError) as error:
        reason = error.strerror or error
        raise UnusableInput(
            f"{chain}, {key}: no certificate with its key ({reason}); both as PEM would work"
        ) from None
    return Certificate(chain, key)


def _refuse_unusable(settings: "Settings", db: str | None) -> None:
    """Raise UnusableInput where tokens are needed and there is none that is valid."""
    from autodb.agent.access import ROLES, Role, tokens
    from autodb.errors import UnusableInput

    needed = Role.OPERATE if settings.writes else Role.READ
    with opened(db) as store, store.reading() as session:
        roles = [ROLES[one.role] for one in tokens(session) if one.valid]
    if settings.on_loopback and not settings.writes:
        return
    if not any(role >= needed for role in roles):
        raise UnusableInput(
            "nobody could use it: 'autodb token add NAME --role "
            f"{needed.word}' makes the token that it needs"
        )


@token.command("add")
def add(
    name: TokenName,
    role: Annotated[
        str, typer.Option("--role", help="read, operate (also import and decide) or admin.")
    ] = "read",
    days: Annotated[
        int | None,
        typer.Option("--days", metavar="N", min=1, max=36500, help="Days that it is valid for."),
    ] = None,
    db: Database = None,
) -> None:
    """Make a token and print it, this once: only its hash is kept."""
    from autodb.agent.access import add_token

    with opened(db) as store:
        secret = add_token(store, name, role, days=days)
    say(secret)


@token.command("list")
def list_(db: Database = None) -> None:
    """List tokens: whose, what they allow, until when."""
    from autodb.agent.access import tokens

    with opened(db) as store, store.reading() as session:
        found = tokens(session)
    if not found:
        say("no token; 'autodb token add NAME' makes one")
        return
    rows = table("Tokens", "name", "role", "made", "until", "state")
    for one in found:
        state = "valid" if one.valid else "revoked" if one.revoked_at else "expired"
        until = one.expires_at or "revoked"
        rows.add_row(one.name, one.role, one.created_at[:10], until[:10], state)
    show(rows)


@token.command("revoke")
def revoke(name: TokenName, db: Database = None) -> None:
    """Revoke a token; the service refuses it within five seconds."""
    from autodb.agent.access import revoke_token

    with opened(db) as store:
        new = revoke_token(store, name)
    say(f"token '{name}': {'revoked' if new else 'was revoked already'}")
