"""What several recordings say together, as a page that loads nothing from outside."""

from pathlib import Path

from autodb.explain.answer import IntervalValue
from autodb.explain.several_recordings import FACTORS, ExplainedTogether, Located
from autodb.reports import amounts, figures
from autodb.reports.explanation import certainty_words, parameter_words, term_words
from autodb.reports.explanation_plots import channel_words
from autodb.wording import phrase


def recording_folders(found: ExplainedTogether) -> list[str]:
    """Return the name of each recording's own folder: its number and its file's name."""
    stems = (Path(setup.recording).stem for setup in found.recordings)
    return [f"{number}-{stem}" for number, stem in enumerate(stems, start=1)]


def render_together(found: ExplainedTogether) -> str:
    """Return the page: what was recorded with what, and where each effect sits."""
    return figures.whole_page(
        "together.html.j2",
        title=phrase("{count} recordings together", count=len(found.recordings)),
        found=found,
        factors=[one for one in FACTORS if any(s.level(one) for s in found.recordings)],
        folders=recording_folders(found),
        file_name=file_name,
        number=effect_number,
        heading=heading,
        certainty_words=certainty_words,
        parameter_words=parameter_words,
        factor_words=phrase,
    )


def file_name(path: str) -> str:
    """Return a path's last part."""
    return Path(path).name


def heading(effect: Located) -> str:
    """Return what an effect is and where it shows, in shop words."""
    scale = effect.term == "scale"
    what = phrase("a change of scale") if scale else term_words(effect.term)
    return phrase("{channel}: {what}", channel=channel_words(effect.channel), what=what)


def effect_number(value: IntervalValue | None) -> str:
    """Return an effect's number in one recording, a dash where it could not show."""
    if value is None:
        return "—"
    return amounts.quantity(value.value, value.unit) if value.unit else amounts.number(value.value)
