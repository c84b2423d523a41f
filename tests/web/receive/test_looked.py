"""The import page looks at a file: what `look` sees, all that is wrong, and nothing is kept."""

import html
import json
import re
import tomllib
from pathlib import Path
from typing import Any

import pytest

from autodb.agent.operate.access import add_token
from autodb.errors import UnusableInput
from autodb.files.side import read_sidefile, stated_side
from autodb.files.text import TextSection
from autodb.records.proposed.choices import ColumnChoice, SideChoices
from autodb.records.proposed.looked import proposed_bases
from autodb.records.proposed.written import proposed_side, side_text
from autodb.store import Store, models
from autodb.web.receive.looking import FileToLook
from autodb.wording import Presentation, presented
from tests.helpers.sending import SEND, became_of, files_in, serving

LOOK = "/machines/lathe-1/import/look"
GERMAN = (
    "Nr;Bearbeitung;Werkstoff;Werkzeug;Vorschub;Schnitttiefe;Durchmesser;Strom Z;Notiz\n"
    "1;Längsdrehen;C45;CNMG;0,28;1,75;69;2891,3;gut\n"
    "2;Längsdrehen;C45;CNMG;0,24;1,25;71;2577,7;\n"
    "3;Abstechen;C45;CNMG;0,13;1,00;49;1884,1;\n"
).encode("cp1252")


@pytest.fixture
def week_de(tmp_path: Path) -> Path:
    """Return a table of cuts as a German shop writes it."""
    path = tmp_path / "sent" / "Woche.csv"
    path.parent.mkdir()
    path.write_bytes(GERMAN)
    return path


def _piece(store: Store, path: Path, side: str | None = None, **choices: Any) -> str:
    """Return the piece of the page on a file, as the process makes it that reads it."""
    if side is not None:
        path.with_suffix(".toml").write_text(side, encoding="utf-8")
    chosen = SideChoices(**choices) if choices else None
    return str(json.loads(FileToLook(path, chosen).do(store, lambda _: None)))


def _side(piece: str) -> str:
    found = re.search(r"<textarea[^>]*>(.*?)</textarea>", piece, re.DOTALL)
    assert found is not None
    return html.unescape(found[1])


def _problems(piece: str) -> list[str]:
    """Return what keeps a file out."""
    found = re.search(r'<div class="said".*?</div>', piece, re.DOTALL)
    said = re.findall(r"<li>(.*?)</li>", found[0], re.DOTALL) if found else []
    return [html.unescape(re.sub(r"<[^>]+>", "", one)) for one in said]


def test_it_proposes_what_look_does(store: Store, week_de: Path) -> None:
    piece = _piece(store, week_de)
    proposed = side_text(proposed_side(proposed_bases(week_de, TextSection())))
    assert _side(piece).strip() == proposed.strip()
    assert "semicolons between columns, decimal commas, cp1252" in piece
    assert _problems(piece) == []
    assert "no operation of ours: &#39;Abstechen&#39;" in piece
    assert "data-plain" not in piece


def test_what_was_chosen_is_imported_with_the_file_and_nothing_before(
    url: str, store: Store, operates: dict[str, str], tmp_path: Path, week_de: Path
) -> None:
    sent = {"recording": ("Woche.csv", GERMAN)}
    proposed = {"side": ("side.toml", _side(_piece(store, week_de)))}
    one = {"column": "Strom Z", "channel": "z.current", "unit": "mA", "turned": True}
    choices = {"columns": [one], "operations": {"Längsdrehen": "face"}}
    with serving(url) as client:
        looked = client.post(
            LOOK, headers=operates,
            files=sent | proposed | {"choices": ("choices", json.dumps(choices))},
        )  # fmt: skip
        assert looked.status_code == 200, looked.text
        assert files_in(tmp_path / "recordings") == []
        side = ("side.toml", _side(looked.text))
        became = became_of(client, client.post(SEND, files=sent | {"side": side}, headers=operates))
    assert became["state"] == "done", became
    assert became["came_in"]["cuts"] == 3
    with store.reading() as session:
        (row,) = session.query(models.StoredRecording).all()
        kept = read_sidefile(Path(row.path).with_suffix(".toml"))
    assert kept.channels["z.current"].sign == -1
    assert "z.current.range" not in kept.channels
    assert kept.values.operation["Längsdrehen"] == "face"


def test_all_that_keeps_a_file_out_is_said_at_once(store: Store, week_de: Path) -> None:
    side = (
        '[channels]\n"cut" = "Nr"\n"z.current" = {column = "Strom Z", unit = "mV"}\n'
        '"work.diameter" = {column = "Durchmesser", unit = "s"}\n"force.z" = "Ff"\n'
    )
    piece = _piece(store, week_de, side)
    said = _problems(piece)
    assert [[word for word in ("'Ff'", "'mV'", "'s'") if word in one] for one in said] == [
        ["'Ff'"], ["'mV'"], ["'s'"],
    ]  # fmt: skip
    assert "data-take disabled" in piece
    stated = stated_side(tomllib.loads(side), where="side")
    assert _side(piece).strip() == side_text(stated).strip()


def test_a_file_that_is_read_wrongly_is_read_as_stated(store: Store, tmp_path: Path) -> None:
    path = tmp_path / "odd.csv"
    rows = "".join(f"{k}|{3 * k}\n" for k in range(40))
    path.write_text(f"made by hand 1 2\nZeit|Weg\n{rows}")
    wrong = _piece(store, path, text={"separator": ";", "header_line": "2", "first_line": "90"})
    assert _problems(wrong)
    assert "data-text" in wrong
    right = _piece(
        store, path, _side(wrong), text={"separator": "|", "header_line": "2", "first_line": ""}
    )
    assert 'separator = "|"' in _side(right)
    assert 'data-column="Weg"' in right


def test_names_of_columns_are_text_on_the_page(store: Store, tmp_path: Path) -> None:
    path = tmp_path / "odd.csv"
    rows = "".join(f"{k},{2 * k},x\n" for k in range(30))
    path.write_text(f't,<script>alert(1)</script>,"a"" onfocus=""b"\n{rows}')
    piece = _piece(store, path)
    assert "<script" not in piece
    assert "&lt;script&gt;alert(1)&lt;/script&gt;" in piece
    assert 'data-column="a&#34; onfocus=&#34;b"' in piece


def test_a_plain_file_says_that_there_is_nothing_to_ask(
    store: Store, tmp_path: Path, week: bytes
) -> None:
    path = tmp_path / "week.csv"
    path.write_bytes(week)
    assert "data-plain" in _piece(store, path)


def test_what_cannot_be_chosen_is_refused(store: Store, week_de: Path) -> None:
    with pytest.raises(UnusableInput, match=r"did you mean x\.current"):
        _piece(store, week_de, columns=(ColumnChoice("Nr", "x.curent"),))
    with pytest.raises(UnusableInput, match="chanels"):
        _piece(store, week_de, "[chanels]\n")


@pytest.mark.parametrize(
    ("files", "status", "line"),
    [
        ({"recording": ("a.exe", b"x")}, 422, "unknown kind of file"),
        ({"recording": ("a.csv", b"")}, 422, "the file is empty"),
        ({"side": ("a.toml", b"")}, 422, "recording: missing"),
        ({"recording": ("a.csv", GERMAN), "choices": ("c", b"{")}, 422, "choices: "),
        ({"recording": ("a.csv", b"1," * 2**20)}, 413, "larger than 1 MiB"),
    ],
)
def test_what_cannot_be_looked_at_is_refused(
    url: str, operates: dict[str, str], files: dict[str, Any], status: int, line: str
) -> None:
    with serving(url, recording_MiB=1) as client:
        got = client.post(LOOK, files=files, headers=operates)
    assert (got.status_code, line in html.unescape(got.text)) == (status, True), got.text


def test_who_may_only_read_does_not_have_files_read(url: str, store: Store) -> None:
    reads = {"Authorization": f"Bearer {add_token(store, 'office', 'read', days=1)}"}
    sent = {"recording": ("Woche.csv", GERMAN)}
    with serving(url) as client, serving(url, writes=False) as read_only:
        assert client.post(LOOK, files=sent).status_code == 401
        assert client.post(LOOK, files=sent, headers=reads).status_code == 403
        assert read_only.post(LOOK, files=sent, headers=reads).status_code == 403


def test_the_reasons_are_german_on_a_german_page(store: Store, week_de: Path) -> None:
    with presented(Presentation("de")):
        piece = _piece(store, week_de)
    text = " ".join(html.unescape(re.sub(r"<[^>]+>", " ", piece)).split())
    for said in (
        "3 Schnitte, 9 Spalten", "Strichpunkte zwischen den Spalten, Dezimalkommas",
        "ihr Name; zu groß für Ampere", "Fehlt für calibrate: eine gemessene Kraft", "2891,3",
        "1,884 bis 2,891 A",
    ):  # fmt: skip
        assert said in text, said
