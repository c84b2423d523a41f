"""`fleet`: many machines of one database: refreshed at once, and what they know together."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from autodb.cli._common import (
    Database,
    Json,
    opened_store,
    progress_bar,
    say,
    say_json,
    show,
    table,
    working,
)
from autodb.cli._reader import headed, in_english
from autodb.wording import phrase, presentation, presented
from autodb.wording.kept import said_again

if TYPE_CHECKING:
    from distributed import Client

    from autodb.agent.fleet.clusters import ShownCertificates
    from autodb.agent.fleet.tasks import MachineTask, RefreshedMachine
    from autodb.store import Store

NOT_REFRESHED = 1

fleet = typer.Typer(
    help="Many machines of one database: refresh them all, and fit what they share.",
    no_args_is_help=True,
)
Standard = Annotated[
    list[Path] | None,
    typer.Option(
        "--standard", metavar="FILE", help="Standard cuts of known force, beside those of the kit."
    ),
]

Scheduler = Annotated[
    str | None,
    typer.Option(
        "--scheduler",
        metavar="ADDRESS",
        help="Spread them over this Dask scheduler's workers: tls://HOST:PORT.",
    ),
]
AuthorityFile = Annotated[
    Path | None,
    typer.Option("--ca", metavar="FILE", help="Authority of the cluster's certificates (PEM)."),
]
CertificateFile = Annotated[
    Path | None,
    typer.Option("--certificate", metavar="FILE", help="Our certificate of it (PEM)."),
]
KeyFile = Annotated[
    Path | None, typer.Option("--key", metavar="FILE", help="Key of our certificate (PEM).")
]
Workers = Annotated[
    int | None,
    typer.Option("--workers", metavar="N", min=1, help="Or over N processes of this computer."),
]
Inboxes = Annotated[
    Path | None,
    typer.Option(
        "--inboxes", metavar="DIR", help="Folder with an inbox for each machine, of its name."
    ),
]
OnlyMachines = Annotated[
    list[str] | None, typer.Option("--machine", help="Only this one; may be given again.")
]


@fleet.command("refresh")
def refresh_fleet_command(
    scheduler: Scheduler = None,
    ca: AuthorityFile = None,
    certificate: CertificateFile = None,
    key: KeyFile = None,
    workers: Workers = None,
    inboxes: Inboxes = None,
    machine: OnlyMachines = None,
    standard: Standard = None,
    db: Database = None,
) -> None:
    """Refresh all machines, and fit again what they share."""
    from autodb.errors import UnusableInput
    from autodb.files.targets import expect_folder
    from autodb.store import database_url

    if scheduler is not None and workers is not None:
        raise UnusableInput(phrase("--scheduler and --workers: use one of them"))
    where = _Where(scheduler, workers, _shown(scheduler, ca, certificate, key))
    if inboxes is not None:
        expect_folder(inboxes)
    url = database_url(db)
    with opened_store(db) as store:
        machines, sharing = _machines(store, url, machine or [], inboxes)
    failed, reader = list[str](), presentation()
    with progress_bar("refreshing", len(machines)) as progress:
        done: list[str] = []

        def tell(one: "RefreshedMachine") -> None:
            done.append(one.machine)
            progress(len(done))
            with presented(reader):
                for line in _lines(one):
                    say(line)
            if one.failed is not None:
                failed.append(one.machine)

        with in_english():  # what is found is kept
            _run(machines, sharing, where, url, tell)
    _learn(db, standard)
    if failed:
        say(
            phrase(
                "{n} of {n_2} machines not refreshed: {names}",
                n=len(failed),
                n_2=len(machines),
                names=", ".join(failed[:5]),
            )
        )
        raise typer.Exit(NOT_REFRESHED)


def _machines(
    store: "Store", url: str, wanted: Sequence[str], inboxes: Path | None
) -> "tuple[list[MachineTask], set[str]]":
    """Return the machines to refresh, and the names of those whose recordings may leave them."""
    from sqlalchemy import select

    from autodb.agent.fleet.tasks import MachineTask
    from autodb.agent.learn.shared_priors import RECORDINGS
    from autodb.agent.rows.machines import find_machine
    from autodb.errors import UnusableInput
    from autodb.store import models

    with store.reading() as session:
        rows = [find_machine(session, name) for name in wanted] or list(
            session.scalars(
                select(models.Machine)
                .where(models.Machine.retired_at.is_(None))
                .order_by(models.Machine.name)
            )
        )
        if not rows:
            raise UnusableInput(
                phrase("no machine works here; add one with 'autodb machine add NAME'")
            )
        found = []
        for row in rows:
            inbox = None if inboxes is None else (inboxes / row.name).resolve()
            there = inbox is not None and inbox.is_dir()
            found.append(MachineTask(url, row.name, str(inbox) if there else None))
        return found, {row.name for row in rows if row.shares == RECORDINGS}


def _run(
    machines: "Sequence[MachineTask]",
    sharing: set[str],
    where: "_Where",
    url: str,
    tell: "Callable[[RefreshedMachine], None]",
) -> None:
    """Refresh machines where they may be: what leaves no machine stays with this process."""
    from autodb.agent.fleet import tasks

    away = [one for one in machines if where.workers is not None or one.name in sharing]
    here = list(machines)
    if where.scheduler is not None or where.workers is not None:
        from autodb.agent.fleet.spreading import refresh_all

        with _cluster(where, url) as client:
            refresh_all(client, away, tell)
        here = [one for one in machines if one not in away]
    if here and where.scheduler is not None:
        say(phrase("{n} machines share no recordings: refreshed here", n=len(here)))
    for one in here:
        tell(tasks.whole_task(one))


@dataclass(frozen=True)
class _Where:
    """What machines are spread over: a scheduler, or workers of this computer; None: neither."""

    scheduler: str | None
    workers: int | None
    shown: "ShownCertificates | None"


def _shown(
    scheduler: str | None, ca: Path | None, certificate: Path | None, key: Path | None
) -> "ShownCertificates | None":
    """Return what is shown to a scheduler; raises UnusableInput for a part, or without one."""
    from autodb.agent.fleet.clusters import ShownCertificates
    from autodb.errors import UnusableInput

    if ca is None and certificate is None and key is None:
        return None
    if scheduler is None or ca is None or certificate is None or key is None:
        raise UnusableInput(
            phrase("--ca, --certificate and --key: give all three, with --scheduler")
        )
    return ShownCertificates(ca, certificate, key)


@contextmanager
def _cluster(where: _Where, url: str) -> "Iterator[Client]":
    from autodb.agent.fleet.clusters import scheduler_at, workers_here

    if where.scheduler is None:
        made = workers_here(where.workers or 1)
    else:
        made = scheduler_at(where.scheduler, url, where.shown)
    with made as client:
        yield client


def _lines(one: "RefreshedMachine") -> list[str]:
    called = {"machine": one.machine}
    if one.failed is not None:
        return [phrase("{machine}: not refreshed: {why}", **called, why=said_again(one.failed))]
    return [phrase("{machine}: {what}", **called, what=said_again(line)) for line in one.lines]


@fleet.command("learn")
def learn_command(standard: Standard = None, db: Database = None) -> None:
    """Fit again what machines share, and name the machine that disagrees."""
    _learn(db, standard)


def _learn(db: str | None, standard: Sequence[Path] | None) -> None:
    from autodb.agent.fleet.sharing import learn_fleet
    from autodb.standard import read_protocol

    protocols = [read_protocol(str(path)) for path in standard or ()]
    with (
        in_english(),  # what is found is kept
        opened_store(db) as store,
        working("fitting what machines share") as progress,
    ):
        done = learn_fleet(store, protocols=protocols, progress=progress)
    for line in done.lines():
        say(line)


@fleet.command("show")
def show_fleet_command(json: Json = False, db: Database = None) -> None:
    """Show what machines share of each material, and which machine disagrees."""
    from autodb.agent.fleet.known_together import shared_knowledge

    with in_english(json), opened_store(db) as store, store.reading() as session:
        found = shared_knowledge(session)
    if json:
        say_json(asdict(found))
        return
    heads = (
        phrase("machines"), phrase("tools"), phrase("tools apart"), phrase("machines apart"),
        phrase("shear stress, MPa"), phrase("friction, °"), phrase("K_te, N/mm"),
    )  # fmt: skip
    title = phrase("Parameters shared by machines")
    rows = table(title, phrase("material"), *map(headed, heads))
    for one in found.materials:
        rows.add_row(
            one.material, str(one.machines), str(one.tools),
            f"{100.0 * one.tools_apart:.0f} %", f"{100.0 * one.machines_apart:.0f} %", *one.numbers,
        )  # fmt: skip
    show(rows)
    for named in found.named:
        say(named.words)
