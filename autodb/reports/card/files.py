"""Writes a card whole or not at all: a page, or a PDF that a browser prints of it."""

import os
import shutil
import subprocess
import tempfile
from pathlib import Path

from autodb.errors import UnusableInput
from autodb.files.targets import hidden, needs_folder, replace_by
from autodb.reports.card.machine_card import CalibrationCard
from autodb.reports.card.render import render_card
from autodb.reports.written import contained, write_page
from autodb.wording import phrase

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome")
"""Names under which a browser that prints without a screen is searched for."""
PRINT_S = 180
"""Seconds after which a browser that prints one page is taken to hang."""
WINDOW_PX = "860,1200"
"""Window that the page is laid out in first: plots are then drawn about as wide as on A4."""


def check_card_target(path: Path, *, self_contained: bool = False) -> None:
    """Raise UnusableInput where a card could not be written to ``path``.

    A PDF is not said to be ``self_contained``, as each is.
    """
    if path.suffix not in (".html", ".pdf"):
        raise UnusableInput(phrase("{file}: a card is FILE.html or FILE.pdf", file=path))
    if path.is_dir():
        raise UnusableInput(
            phrase("{file}: is a folder; --card needs the name of a file", file=path)
        )
    needs_folder(path)
    if path.suffix == ".pdf":
        if self_contained:
            raise UnusableInput(
                phrase("{file}: --self-contained is of a page; leave it out for a PDF", file=path)
            )
        _browser(path)


def write_card(card: CalibrationCard, path: Path, *, self_contained: bool = False) -> None:
    """Write a card; an earlier file of that name is replaced. Raises as ``check_card_target``.

    Raises UnusableInput also when the browser does not print.
    """
    check_card_target(path)
    if path.suffix != ".pdf":
        write_page(path, render_card(card), self_contained=self_contained)
        return
    with hidden(path) as part:
        _print(contained(render_card(card)), part, path)
        replace_by(part, path)


def _browser(path: Path) -> str:
    for name in BROWSERS:
        found = shutil.which(name)
        if found:
            return found
    raise UnusableInput(
        phrase(
            "{file}: there is no browser to print it ({names}); install one of them, or "
            "use --card {name}",
            file=path,
            names=", ".join(BROWSERS),
            name=path.with_suffix(".html").name,
        )
    )


def _print(html: str, part: Path, path: Path) -> None:
    """Have the browser print a page; it has its own home there, so that none is left."""
    with tempfile.TemporaryDirectory(prefix="autodb-card-") as home:
        page, printed = Path(home) / "card.html", Path(home) / "card.pdf"
        page.write_text(html, encoding="utf-8")
        command = [
            _browser(path), "--headless", "--disable-gpu", "--no-first-run",
            f"--window-size={WINDOW_PX}", f"--user-data-dir={home}/profile",
            "--no-pdf-header-footer", f"--print-to-pdf={printed}", *_as_root(), page.as_uri(),
        ]  # fmt: skip
        said = _said(command)
        if not printed.is_file():
            why = said.strip().splitlines()[-1:] or ["it said nothing"]
            raise UnusableInput(
                phrase(
                    "{file}: {command} did not print it ({why}); use --card {name}",
                    file=path,
                    command=command[0],
                    why=why[0],
                    name=path.with_suffix(".html").name,
                )
            )
        shutil.copyfile(printed, part)


def _said(command: list[str]) -> str:
    """Run a browser and return what it complained of."""
    try:
        done = subprocess.run(command, capture_output=True, timeout=PRINT_S, check=False)
    except subprocess.TimeoutExpired:
        return f"not done in {PRINT_S} s"
    return done.stderr.decode(errors="replace")


def _as_root() -> list[str]:
    """Return what the superuser has to add: for it the browser has no sandbox."""
    return ["--no-sandbox"] if os.name == "posix" and os.geteuid() == 0 else []
