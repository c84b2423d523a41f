"""What templates say: sentences in the reader's language, and what is there in English alone."""

from urllib.parse import quote

from markupsafe import Markup, escape

from autodb.wording import ENGLISH, language_of, phrase, phrase_many, presentation


def page_sentence(english: str, **values: object) -> Markup:
    """Return a sentence in the reader's language; text in ``values`` is escaped.

    >>> page_sentence("Import {name}", name="a < b")
    Markup('Import a &lt; b')
    """
    return escape(str(phrase(english))).format(**values) if values else escape(str(phrase(english)))


def page_sentences(one: str, many: str, count: int, **values: object) -> Markup:
    """Return the sentence for a count, which it has as ``{count}``; text in it is escaped."""
    kept = {name: "{" + name + "}" for name in values}
    return escape(str(phrase_many(one, many, count, **kept))).format(**values)


def told(text: object, *, capital: bool = False) -> Markup:
    """Return a text that the program says; one that was stored is said again for the reader.

    What is in English alone says so to who reads aloud.

    ``capital``: it begins a line.
    """
    language, shown = language_of(text), str(text)
    if language == "en" and presentation() != ENGLISH:
        from autodb.wording.kept import said_again  # who says English needs none

        again = said_again(shown)
        language, shown = language_of(again), str(again)
    if capital:
        shown = f"{shown[:1].upper()}{shown[1:]}"
    if language == presentation().language:
        return escape(shown)
    return Markup('<span lang="{}">{}</span>').format(language, shown)


def code(text: str) -> Markup:
    """Return what is typed as it is."""
    return Markup("<code>{}</code>").format(text)


def link_to(to: str, words: str) -> Markup:
    """Return words that lead somewhere."""
    return Markup('<a href="{}">{}</a>').format(to, words)


def sign_in_link(at: str, words: str) -> Markup:
    """Return words that lead to the page for signing in, and from there back."""
    return link_to(f"/sign-in?then={quote(at)}", words)
