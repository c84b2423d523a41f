"""Pages as they are read, and a language in which every sentence that is looked up shows."""

import json
import re
from collections.abc import Iterable
from gettext import NullTranslations
from html.parser import HTMLParser
from string import Formatter
from typing import Any

from autodb.files.channels import OUR_UNITS
from autodb.terms.vocabulary import all_terms
from tests.helpers.site import STRANGE

OPEN, CLOSE = "⟦", "⟧"
_MARKED = re.compile(f"{OPEN}[^{OPEN}{CLOSE}]*{CLOSE}")
_READ_ALOUD = ("aria-label", "title", "placeholder", "alt")
_UNREAD = ("script", "style", "code", "title")
_VOID = ("meta", "link", "input", "br", "hr", "img", "progress")

NAMES = (
    STRANGE, "lathe-1", "lath-1", "steel bar", "carbide insert", "Schruppen", "autodb", "English",
    "later-week", "brass", "HSS", "operator", "operate",
)  # fmt: skip
"""What people, files and programs are called."""
CHANNEL = (
    r"\b(?:[xyzwuvabc]|spindle|force|torque|cutting|tool|work|job|pocket|chip)(?:[._][a-z_]+)+"
)
DATA = re.compile(
    "|".join(
        (
            *map(re.escape, NAMES),
            *(rf"\b{one.name}\b" for one in all_terms()),
            *(rf"\b{one.name}\b" for term in all_terms() for one in term.parameters),
            r"[\w.-]*\.(?:csv|toml|sqlite3|json|nc|parquet)\b", r"(?:/[\w.-]+){2,}",  # files
            CHANNEL, r"\b[A-Z]\d\b", r"\{\w+\}",  # edges; what a page's script fills in
            r"\b(?:k_c1\.1|m_c|[Kkm]_\w+)\b", r"\b(?:chip|shear|friction|flow)_\w+",  # coefficients
            r"\b(?:included|corner|edge|relief|rake)_\w+",  # numbers of a tool
            r"\b\w+_(?:mm|mm_rev|mm_tooth|m_min|rpm|deg|N_m|Hz|ratio)\b",  # keys of files
            r"axes\.[\w.]+",
            r"'[^']*'", r"^\s*cut\s*$", r"\bln\b", r"\bUTC\b", r"\bMiB\b", r"\brms\b", r"\bHz\b",
            r"\bR²|kJ|cm³|N/mm|min\b",
            *(rf"\b{re.escape(one)}\b" for one in OUR_UNITS),
            r"\b(?:lbf|ksi|hp|in|ft|inch)\b", r"\be[+-]\d+",
        )
    )
)  # fmt: skip


class Marked(NullTranslations):
    """A language whose sentences are the English ones, what is not filled in between marks.

    Quotation marks stay outside: what stands between two is filled in, or is to be typed.
    """

    def gettext(self, message: str) -> str:
        """Return a sentence marked."""
        if message.startswith("%Y"):
            return message
        twice = "{{" in message
        return "".join(
            re.sub(r"[^']*\w[^']*", rf"{OPEN}\g<0>{CLOSE}", _braced(text) if twice else text)
            + ("" if name is None else f"{{{name}}}")
            for text, name, _, _ in Formatter().parse(message)
        )

    def ngettext(self, msgid1: str, msgid2: str, n: int) -> str:
        """Return the sentence for a count marked."""
        return self.gettext(msgid1 if n == 1 else msgid2)


def _braced(text: str) -> str:
    """Return a text whose braces are no places of a sentence."""
    return text.replace("{", "{{").replace("}", "}}")


def unmarked(text: str) -> str:
    """Return what of a text was not looked up."""
    return _MARKED.sub(" ", text)


def left(texts: Iterable[str]) -> list[str]:
    """Return what of texts that are said in German was looked up nowhere, and is no data either."""
    rest = [DATA.sub(" ", unmarked(text)) for text in texts]
    return [text for text in rest if re.search(r"[A-Za-zÄÖÜäöüß]{2,}", text)]


def left_of_page(html: str) -> list[str]:
    """Return what a page says in no language, of the whole of it, or of a piece."""
    whole = html if html.startswith("<!doctype") else f'<html lang="de">{html}</html>'
    return left(text for text, language in Read(whole).texts if language == "de")


class Read(HTMLParser):
    """What is read of a page: texts with the language that they are said to be in.

    Those of ``<code>`` are typed as they are; those of plots are read from their data.
    """

    def __init__(self, html: str) -> None:
        super().__init__()
        self.texts: list[tuple[str, str]] = []
        self._stack: list[tuple[str, str]] = []
        self._data: list[str] | None = None
        self.feed(html)

    @property
    def language(self) -> str:
        """The language of where the reader is."""
        return self._stack[-1][1] if self._stack else ""

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Go into a part, and read what is said of it."""
        known = dict(attrs)
        language = known.get("lang") or self.language
        for name in _READ_ALOUD:
            if known.get(name):
                self.texts.append((str(known[name]), language))
        if tag not in _VOID:
            self._stack.append((tag, language))
        if tag == "script" and known.get("type") == "application/json":
            self._data = []

    def handle_endtag(self, tag: str) -> None:
        """Leave a part."""
        if self._data is not None:
            self.texts += [(one, self.language) for one in _of_json("".join(self._data))]
            self._data = None
        while self._stack and self._stack.pop()[0] != tag:
            pass

    def handle_data(self, data: str) -> None:
        """Read a text."""
        if self._data is not None:
            self._data.append(data)
        elif data.strip() and not any(tag in _UNREAD for tag, _ in self._stack):
            self.texts.append((data, self.language))


def _of_json(text: str) -> list[str]:
    """Return the texts of a page's data: of a plot those that it shows, else all."""
    read = json.loads(text)
    if "figure" not in read:
        return list(read.values())
    figure = read["figure"]
    layout = figure["layout"]
    shown = [one.get("text") for one in layout.get("annotations", ())]
    axes = (layout[name] for name in layout if re.match("[xy]axis", name))
    shown += [one.get("title", {}).get("text") for one in axes]
    for trace in figure["data"]:
        shown.append(trace.get("name"))
        hover: Any = trace.get("text") or []
        shown += [hover] if isinstance(hover, str) else hover
        shown.append(trace.get("hovertemplate"))
    plain = (re.sub(r"<[^>]+>|%\{[^}]*\}", " ", str(one)) for one in shown if one)
    return [one for one in plain if one.strip()]
