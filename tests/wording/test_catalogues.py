"""The German catalogue has every sentence that is said, and says each with the same numbers."""

from string import Formatter
from typing import Any

import pytest

from autodb.cli.develop import catalogues
from autodb.wording.catalogues import LANGUAGES, preferred_language

OTHERS = [language for language in LANGUAGES if language != "en"]


@pytest.mark.parametrize("language", OTHERS)
def test_a_catalogue_is_up_to_date_and_lacks_nothing(language: str) -> None:
    written = catalogues.catalogue_path(language).read_bytes()
    assert written == catalogues.updated(language), (
        "run 'python -m autodb.cli.develop.catalogues', and translate what is new"
    )
    found = catalogues.read_catalogue(language)
    for message in found:
        assert all(_forms(message.string)), f"not translated: {message.id}"
        assert not message.fuzzy, message.id
    assert not found.obsolete


@pytest.mark.parametrize("language", OTHERS)
def test_a_sentence_has_the_same_parts_in_every_language(language: str) -> None:
    for message in catalogues.read_catalogue(language):
        for english, text in zip(_forms(message.id), _forms(message.string), strict=True):
            if message.id:
                assert _parts(text) <= _parts(english), english
                assert _parts(english) - _parts(text) <= {"count"}, english
                assert _ends(english) == _ends(text), english


def test_the_language_that_is_liked_best_is_taken() -> None:
    for accepted, language in (
        ("de-DE,de;q=0.9,en;q=0.8", "de"),
        ("en-US,en;q=0.9,de;q=0.8", "en"),
        ("fr, de;q=0.2", "de"),
        ("fr", "en"),
        ("de;q=nonsense, en;q=0.1", "en"),
        ("de;q=0", "en"),
        ("", "en"),
    ):
        assert preferred_language(accepted) == language, accepted


def _forms(said: Any) -> list[str]:
    """Return a sentence, or that for one and that for many."""
    return [said] if isinstance(said, str) else list(said)


def _parts(text: str) -> set[str]:
    return {name for _, name, _, _ in Formatter().parse(text) if name is not None}


def _ends(text: str) -> tuple[bool, bool]:
    """Return whether a text begins or ends with a space, which joins it to others."""
    return text.startswith(" "), text.endswith(" ")
