"""What is wrong with a file is said in German to a German page, and in English to a program."""

from typing import Any

from tests.helpers.sending import SEND, became_of, serving

LOOK = "/machines/lathe-1/import/look"
IN_GERMAN = {"Accept-Language": "de", "X-Shown-In": "de"}
BAD = b"t,x.current\n0,1\n1,two\n2,3\n3,4\n4,5\n5,6\n6,7\n"
LINE = "bad.csv: column 'x.current', row 2: 'two' is not a number; write a number or leave the cell"
GERMAN = "bad.csv: Spalte 'x.current', Zeile 2: 'two' ist keine Zahl; eine Zahl schreiben oder die"


def _file(name: str, text: bytes) -> dict[str, Any]:
    return {"recording": (name, text)}


def test_an_import_that_is_refused_says_why_in_the_language_of_its_page(
    url: str, operates: dict[str, str]
) -> None:
    with serving(url) as client:
        sent = client.post(SEND, files=_file("bad.csv", BAD), headers=operates)
        assert became_of(client, sent)["refused"].startswith(LINE)
        shown = client.get(sent.headers["location"], headers=IN_GERMAN)
        assert shown.json()["refused"].startswith(GERMAN)
        assert shown.headers["content-language"] == "de"
        to_program = client.get(sent.headers["location"], headers={"Accept-Language": "de"})
        assert to_program.json()["refused"].startswith(LINE)


def test_a_file_that_is_looked_at_is_refused_in_german(url: str, operates: dict[str, str]) -> None:
    with serving(url) as client:
        headers = operates | IN_GERMAN
        empty = client.post(LOOK, files=_file("leer.csv", b""), headers=headers)
        assert "leer.csv: Die Datei ist leer" in empty.text
        short = client.post(LOOK, files=_file("kurz.csv", b"t,x.current\n"), headers=headers)
        assert "<li>keine Zeilen mit Daten unter der Kopfzeile</li>" in short.text
        other = client.post(LOOK, files=_file("plan.doc", b"x"), headers=headers)
        assert "plan.doc: unbekannte Art von Datei; .csv" in other.text
        assert [one.status_code for one in (empty, short, other)] == [422, 200, 422]
