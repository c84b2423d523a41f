"""Stored sentences are said again for the reader; what is not known stays as it was stored."""

from string import Formatter

import pytest

from autodb.files.units import shop_units
from autodb.terms.vocabulary import WITHOUT_TERM, all_terms
from autodb.wording import Presentation, language_of, presented
from autodb.wording.catalogues import catalogue
from autodb.wording.kept import (
    CAUSES,
    SENTENCES,
    VALUES,
    StoredSentence,
    said_again,
    stored_sentences,
)

GERMAN = Presentation("de")
N_PER_LBF = 4.4482216152605
STORED = (
    (
        "usable: R² 0.992 (95 % 0.988 to 0.995) on held-out groups (cutting condition), lower "
        "bound above 0.3",
        "brauchbar: R² 0,992 (95 %: 0,988 bis 0,995) auf ausgelassenen Gruppen (Schnittbedingung), "
        "untere Grenze über 0,3",
    ),
    (
        "x stands still: a passive force shows in no current",
        "x steht still: Eine Passivkraft zeigt sich in keinem Strom",
    ),
    (
        "spindle was calibrated with gear range 'high' or 'low', not 'mid'",
        "spindle wurde mit Getriebestufe 'high' oder 'low' kalibriert, nicht mit 'mid'",
    ),
    (
        "z: 7 of the 12 new cuts are outside the calibrated range: feed speed 30 to 600 mm/min; "
        "current 0.5 to 3.2 A; their intervals are wider",
        "z: 7 der 12 neuen Schnitte liegen außerhalb des kalibrierten Bereichs: "
        "Vorschubgeschwindigkeit 30 bis 600 mm/min; Strom 0,5 bis 3,2 A; ihre Intervalle sind "
        "breiter",
    ),
    (
        "drive: 3 missing rows filled from their neighbours; gap of 1.5 s after 20.25 s; 1000 Hz, "
        "2 pieces of even rows",
        "drive: 3 fehlende Zeilen aus ihren Nachbarn ergänzt; Lücke von 1,5 s nach 20,25 s; "
        "1000 Hz, 2 Stücke gleichmäßiger Zeilen",
    ),
    (
        "mismatch 4: now force.y: tool_wear (missing), in 3 cuts of 2 recordings, 1 excluded",
        "Abweichung 4: jetzt force.y: Werkzeugverschleiß (fehlt), in 3 Schnitten aus 2 Aufnahmen, "
        "1 ausgeschlossen",
    ),
    (
        "Let the machine rest for 800 min, then make 5 cuts like cut 12, with a feed of 0.2 mm "
        "instead of 0.1 mm: there wear and heat would differ by up to 1200 N in force.y, scatter "
        "is 3.1 N a cut; together 5.2 standard deviations.",
        "Die Maschine 800 min ruhen lassen, dann 5 Schnitte wie Schnitt 12, mit einem Vorschub "
        "von 0,2 mm statt 0,1 mm machen: Dort würden sich wear und heat in force.y um bis zu "
        "1200 N unterscheiden, bei einer Streuung von 3,1 N je Schnitt; zusammen 5,2 "
        "Standardabweichungen.",
    ),
    (
        "The simulation leaves it out: up to 82.4 N (37.3 to 128).",
        "Die Simulation lässt das weg: bis 82,4 N (37,3 bis 128).",
    ),
)


@pytest.mark.parametrize(("english", "german"), STORED)
def test_what_was_stored_is_said_in_german(english: str, german: str) -> None:
    with presented(GERMAN):
        found = said_again(english)
    assert (str(found), language_of(found)) == (german, "de")
    assert said_again(english) == english


def test_every_sentence_that_is_stored_is_recognised_with_what_stands_in_it() -> None:
    """Whatever other sentences look like it."""
    assert len(stored_sentences()) > 100
    with presented(GERMAN):
        for one in stored_sentences():
            english, values = _filled(one)
            expected = catalogue("de").gettext(one.english).format(**values)
            assert str(said_again(english)) == expected
            assert language_of(said_again(english)) == "de"


def _filled(one: StoredSentence) -> tuple[str, dict[str, str]]:
    """Return a sentence with something in its places, and that as a German reader has it."""
    ours, theirs = {}, {}
    for _, name, _, _ in Formatter().parse(one.english):
        if name in SENTENCES:
            ours[name], theirs[name] = "time runs backwards: rows turned round", ""
            theirs[name] = catalogue("de").gettext(ours[name])
        elif name is not None and name.startswith(CAUSES):
            ours[name], theirs[name] = "a hard spot, weight on the table", ""
        elif name is not None:
            ours[name] = theirs[name] = f"'{name}'" if name == VALUES else f"Zq{len(ours)}"
    for name in (one for one in ours if one.startswith(CAUSES)):
        theirs[name] = ", ".join(map(catalogue("de").gettext, ours[name].split(", ")))
    return one.english.format(**ours), theirs


def test_sizes_are_in_the_units_of_the_shop() -> None:
    sizes = [f"{value / N_PER_LBF:.3g}" for value in (82.4, 37.3, 128.0)]
    with presented(Presentation("en", shop_units("inch"))):
        found = said_again("The simulation leaves it out: up to 82.4 N (37.3 to 128).")
    said = "The simulation leaves it out: up to {} lbf ({} to {}).".format(*sizes)
    assert (str(found), language_of(found)) == (said, "en")


@pytest.mark.parametrize(
    "text",
    [
        "of a version that nobody has",
        "x: of a version that nobody has",
        "usable: of a version that nobody has",
        "steel: 3 cuts are not used: of a version that nobody has",
        "time runs backwards: rows turned round; of a version that nobody has",
    ],
)
def test_what_is_not_known_stays_in_english_as_a_whole(text: str) -> None:
    with presented(GERMAN):
        found = said_again(text)
    assert (str(found), language_of(found)) == (text, "en")


def test_every_advice_is_said_in_german() -> None:
    with presented(GERMAN):
        every = (one.check for one in (*all_terms(), *WITHOUT_TERM) if one.check)
        assert {language_of(said_again(check)) for check in every} == {"de"}


def test_a_number_beside_an_amount_is_in_its_unit() -> None:
    stored = "The simulation has gravity with level 82.4 N; the recording says 37.3 (35 to 39.6)."
    sizes = [f"{value / N_PER_LBF:.3g}" for value in (82.4, 37.3, 39.6)]
    with presented(Presentation("en", shop_units("inch"))):
        found = said_again(stored)
    assert f"level {sizes[0]} lbf; the recording says {sizes[1]} (7.9 to {sizes[2]})" in found
