"""`token`: who may use the service."""

from typing import Annotated

import typer

from autodb.cli._common import Database, Json, opened_store, say, say_json, show, table
from autodb.wording import day, msgid, phrase

token = typer.Typer(help="Access tokens of the service.", no_args_is_help=True)


VALID, REVOKED, EXPIRED = msgid("valid"), msgid("revoked"), msgid("expired")
TokenName = Annotated[str, typer.Argument(help="Name of the token: who uses it.")]


@token.command("add")
def add_token_command(
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
    from autodb.agent.operate.access import add_token

    with opened_store(db) as store:
        secret = add_token(store, name, role, days=days)
    say(secret)


@token.command("list")
def list_tokens_command(json: Json = False, db: Database = None) -> None:
    """List tokens: whose, what they allow, until when."""
    from autodb.agent.operate.access import tokens

    with opened_store(db) as store, store.reading() as session:
        found = [
            {
                "name": one.name,
                "role": one.role,
                "made": one.created_at,
                "until": one.expires_at or None,
                "state": VALID if one.valid else REVOKED if one.revoked_at else EXPIRED,
            }
            for one in tokens(session)
        ]
    if json:
        say_json(found)
        return
    if not found:
        say(phrase("no token; add one with 'autodb token add NAME'"))
        return
    rows = table(
        phrase("Tokens"),
        *(phrase("name"), phrase("role"), phrase("made"), phrase("until"), phrase("state")),
    )
    for row in found:
        until = day(str(row["until"])[:10]) if row["until"] else phrase(REVOKED)
        made = day(str(row["made"])[:10])
        rows.add_row(str(row["name"]), str(row["role"]), made, until, phrase(str(row["state"])))
    show(rows)


@token.command("revoke")
def revoke(name: TokenName, db: Database = None) -> None:
    """Revoke a token; the service refuses it within five seconds."""
    from autodb.agent.operate.access import revoke_token

    with opened_store(db) as store:
        new = revoke_token(store, name)
    said = msgid("token '{name}': revoked") if new else msgid("token '{name}': was revoked already")
    say(phrase(said, name=name))
