"""`serve`: the database over HTTP."""

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from autodb.cli._common import (
    Database,
    from_anywhere,
    opened_store,
    say,
    until_stopped,
)

if TYPE_CHECKING:
    from autodb.web.http.settings import RequestLimits, Settings
    from autodb.web.server import Certificate

EXTRA = "serving needs the extra 'serve'; run pip install 'autodb[serve]'"


Host = Annotated[
    str,
    typer.Option("--host", help="Address to listen at; any but this computer's own needs tokens."),
]
Port = Annotated[
    int, typer.Option("--port", min=0, max=65535, help="Port to listen at; 0: a free one.")
]
Write = Annotated[
    bool, typer.Option("--write", help="Let tokens of role operate or admin change something.")
]
HostNames = Annotated[
    list[str] | None,
    typer.Option(
        "--name",
        metavar="HOST",
        help="Name of a host to answer to, by tokens alone; may be given again.",
    ),
]
Proxies = Annotated[
    list[str] | None,
    typer.Option(
        "--proxy",
        metavar="ADDRESS",
        help="Address, or network, of a proxy whose X-Forwarded-For and -Proto are believed; "
        "may be given again.",
    ),
]
CertificateFile = Annotated[
    Path | None, typer.Option("--certificate", metavar="FILE", help="TLS certificate (PEM).")
]
KeyFile = Annotated[
    Path | None, typer.Option("--key", metavar="FILE", help="Key of the certificate (PEM).")
]
RecordingsFolder = Annotated[
    Path | None,
    typer.Option(
        "--recordings",
        metavar="FOLDER",
        help="Folder that keeps recordings which are sent, with --write; default: recordings, "
        "beside the database's file.",
    ),
]
UploadMib = Annotated[
    int | None,
    typer.Option(
        "--upload-mib",
        metavar="N",
        min=1,
        max=1_000_000,
        help="Largest recording that may be sent, in MiB, with --write; default: 256.",
    ),
]
PageUnits = Annotated[
    Literal["si", "inch"],
    typer.Option(
        "--units",
        envvar="AUTODB_UNITS",
        show_envvar=False,
        help="Units of the pages, where their reader has chosen none: si, or inch.",
    ),
]
Unit = Annotated[
    bool, typer.Option("--unit", help="Print a systemd unit that serves so; serve nothing.")
]


def serve(
    host: Host = "127.0.0.1",
    port: Port = 8321,
    write: Write = False,
    name: HostNames = None,
    proxy: Proxies = None,
    certificate: CertificateFile = None,
    key: KeyFile = None,
    recordings: RecordingsFolder = None,
    upload_mib: UploadMib = None,
    units: PageUnits = "si",
    unit: Unit = False,
    db: Database = None,
) -> None:
    """Serve pages and look-ups; without options read-only, and to this computer alone."""
    from autodb.errors import UnusableInput
    from autodb.store import database_url
    from autodb.web.http import arenas

    arenas.share_one()  # before anything that is loaded begins a thread
    try:
        from autodb.web import server
        from autodb.web.app import make_app
        from autodb.web.http.settings import Settings
    except ImportError:
        raise UnusableInput(EXTRA) from None
    tls = _certificate(certificate, key)
    settings = Settings(
        database_url(db), host, port, write, tuple(name or ()), tls is not None, recordings,
        _limits(upload_mib), _proxies(proxy or ()), units,
    )  # fmt: skip
    _refuse_idle(settings, upload_mib)
    _refuse_unusable(settings, db)
    if unit:
        _print_unit(settings, certificate, key)
        return
    listening = server.bound(settings)
    shown = f"[{host}]" if ":" in host else host
    scheme, does = "https" if tls else "http", "read and write" if write else "read-only"
    at = f"{scheme}://{shown}:{listening.getsockname()[1]}"
    say(f"{at} (and {at}/api/v1): {does}; Ctrl-C stops it")
    if not settings.on_loopback and tls is None:
        say("without TLS, tokens can be read in transit; use --certificate and --key")
    with until_stopped():
        server.run_server(make_app(settings), listening, tls, settings.proxies)


def _limits(upload_mib: int | None) -> "RequestLimits":
    from autodb.web.http.settings import RequestLimits

    return RequestLimits() if upload_mib is None else RequestLimits(recording_MiB=upload_mib)


def _proxies(given: Sequence[str]) -> tuple[str, ...]:
    """Return addresses and networks; raises UnusableInput for what is none."""
    from ipaddress import ip_network

    from autodb.errors import UnusableInput

    for one in given:
        try:
            ip_network(one)
        except ValueError as error:
            raise UnusableInput(
                f"--proxy '{one}': {error}; write one such as 127.0.0.1 or 192.0.2.0/24"
            ) from None
    return tuple(given)


def _refuse_idle(settings: "Settings", upload_mib: int | None) -> None:
    """Raise UnusableInput for options that would change nothing, or name no folder."""
    from autodb.errors import UnusableInput
    from autodb.files.targets import expect_folder

    folder = settings.recordings
    if not settings.writes and (folder is not None or upload_mib is not None):
        raise UnusableInput("--recordings and --upload-mib: recordings are taken with --write only")
    if folder is not None:
        expect_folder(folder)


def _print_unit(settings: "Settings", certificate: Path | None, key: Path | None) -> None:
    """Print a systemd unit that serves as it is said, every path a whole one."""
    import getpass

    from autodb.store import file_of, on_server
    from autodb.web.unit import Runs, unit

    url = from_anywhere(settings.url)
    here = not on_server(url)
    folders = [file_of(url).parent] if here else []
    if settings.recordings is not None:
        folders.append(settings.recordings.resolve())
    user = file_of(url).owner() if here else getpass.getuser()
    command = [sys.executable, "-m", "autodb", "serve", "--db", url]
    say(
        unit(settings, Runs((*command, *_options(settings, certificate, key)), user, folders, here))
    )


def _options(settings: "Settings", certificate: Path | None, key: Path | None) -> list[str]:
    """Return the options that say these settings."""
    from autodb.web.http.settings import Settings

    paths = {"--certificate": certificate, "--key": key, "--recordings": settings.recordings}
    said = [word for o, path in paths.items() if path for word in (o, str(path.resolve()))]
    said += [word for name in settings.names for word in ("--name", name)]
    said += [word for proxy in settings.proxies for word in ("--proxy", proxy)]
    if settings.units != Settings.units:
        said += ["--units", settings.units]
    if settings.writes:
        said += ["--write", "--upload-mib", str(settings.limits.recording_MiB)]
    return ["--host", settings.host, "--port", str(settings.port), *said]


def _certificate(chain: Path | None, key: Path | None) -> "Certificate | None":
    """Return a certificate that can be used; raises UnusableInput."""
    import ssl

    from autodb.errors import UnusableInput
    from autodb.web.server import Certificate

    if chain is None and key is None:
        return None
    if chain is None or key is None:
        raise UnusableInput("--certificate and --key: give both")
    try:
        ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER).load_cert_chain(chain, key)
    except (OSError, ssl.SSLError) as error:
        reason = error.strerror or error
        raise UnusableInput(
            f"{chain}, {key}: these are not a certificate with its key ({reason}); give both as PEM"
        ) from None
    return Certificate(chain, key)


def _refuse_unusable(settings: "Settings", db: str | None) -> None:
    """Raise UnusableInput where tokens are needed and there is none that is valid."""
    from autodb.agent.operate.access import ROLES, Role, tokens
    from autodb.errors import UnusableInput

    needed = Role.OPERATE if settings.writes else Role.READ
    with opened_store(db) as store, store.reading() as session:
        roles = [ROLES[one.role] for one in tokens(session) if one.valid]
    if settings.anonymous and not settings.writes:
        return
    if not any(role >= needed for role in roles):
        raise UnusableInput(
            "nobody could use it; add the token that it needs with 'autodb token add NAME "
            f"--role {needed.word}'"
        )
