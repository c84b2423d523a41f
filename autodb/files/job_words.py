"""Jobs in words: a line a cut, or the program, its stock and tools; and what a form calls these."""

from collections.abc import Iterator, Sequence

from autodb.files.cut_words import FormField, cut_in_words
from autodb.files.job import OTHERS, Job, JobProgram, ProgramTool
from autodb.wording import amount_words, listed, msgid, phrase

TOOL_FIELDS = (
    FormField(
        "edge_mm", msgid("Effective edge length"), "mm", msgid("effective edge length {value}")
    ),
    FormField("kappa_deg", msgid("Entering angle"), "deg", msgid("entering angle {value}")),
    FormField("width_mm", msgid("Width of the blade"), "mm", msgid("blade {value} wide")),
    FormField("diameter_mm", msgid("Diameter"), "mm", msgid("diameter {value}")),
    FormField("teeth", msgid("Teeth"), "1", msgid("{value} teeth")),
    FormField("corner_radius_mm", msgid("Corner radius"), "mm", msgid("corner radius {value}")),
    FormField("helix_deg", msgid("Helix angle"), "deg", msgid("helix angle {value}")),
    FormField("offset_mm", msgid("Offset in G41 and G42"), "mm", msgid("offset {value}")),
)
KINDS = {
    "outside": (msgid("outside turning"), ("edge_mm", "kappa_deg")),
    "boring": (msgid("boring"), ("edge_mm", "kappa_deg")),
    "grooving": (msgid("grooving, parting"), ("width_mm", "corner")),
    "threading": (msgid("threading"), ()),
    "end_mill": (
        msgid("end mill"),
        ("diameter_mm", "teeth", "corner_radius_mm", "helix_deg", "offset_mm"),
    ),
    "drill": (msgid("drill"), ("diameter_mm",)),
}
"""What a program's tools may be: how it is called, and what is stated of it."""
CORNERS = {
    "chuck": msgid("its corner towards the chuck is programmed"),
    "away": msgid("its corner away from the chuck is programmed"),
}


def job_in_words(job: Job) -> Iterator[str]:
    """Yield what a job asks for: a line a cut, or its program and what that meets."""
    for number, cut in enumerate(job.cut, start=1):
        name = cut.name or phrase("cut {number}", number=number)
        yield phrase("{name}: {cut}", name=name, cut=cut_in_words(cut))
    if job.program is not None:
        yield phrase("program {file}", file=job.program.file)
        yield _stock(job.program)
        if read := list(_read_as(job.program)):
            yield phrase("read as: {said}", said=listed(read))
        for name, tool in job.program.tools.items():
            yield _tool(name, tool)


def _stock(program: JobProgram) -> str:
    """Return the bar, the blank or the block that a program meets."""
    if program.block_mm is not None:
        spans = zip("xyz", program.block_mm[::2], program.block_mm[1::2], strict=True)
        return phrase("a block: {spans}", spans=listed([_span(*span) for span in spans]))
    bore = program.bore_diameter_mm
    hole = [] if bore is None else [phrase("bored to {value}", value=amount_words(bore, "mm"))]
    if program.stock is not None:
        ends = program.stock[0][0], program.stock[-1][0]
        largest = max(diameter for _, diameter in program.stock)
        wide = phrase("diameter up to {value}", value=amount_words(largest, "mm"))
        return phrase("a blank: {said}", said=listed([_span("z", *ends), wide, *hole]))
    wide = phrase("diameter {value}", value=amount_words(program.stock_diameter_mm or 0.0, "mm"))
    face = phrase("face at z = {value}", value=amount_words(program.stock_face_mm or 0.0, "mm"))
    return phrase("a bar: {said}", said=listed([wide, face, *hole]))


def _read_as(program: JobProgram) -> Iterator[str]:
    """Yield how a program is read where it does not say it, as far as the job states it."""
    yield from (word for word in (program.control, program.units) if word is not None)
    if program.diameter is not None:
        yield phrase("X in diameters") if program.diameter else phrase("X in radii")
    if program.feeds is not None:
        yield phrase("F a minute") if program.feeds == "minute" else phrase("F a revolution")


def _span(axis: str, low: float, high: float) -> str:
    return phrase(
        "{axis} {low} to {high}",
        axis=axis,
        low=amount_words(low, "mm"),
        high=amount_words(high, "mm"),
    )


def _tool(name: str, tool: ProgramTool) -> str:
    corner = [phrase(CORNERS[tool.corner])] if tool.kind == "grooving" else []
    said = listed([phrase(KINDS[tool.kind][0]), *_numbers(tool), *corner])
    if name == OTHERS:
        return phrase("all other tools: {said}", said=said)
    return phrase("tool {name}: {said}", name=name, said=said)


def _numbers(tool: ProgramTool) -> Sequence[str]:
    stated = ((one, getattr(tool, one.key)) for one in TOOL_FIELDS)
    return [
        phrase(one.said, value=value if one.unit == "1" else amount_words(value, one.unit))
        for one, value in stated
        if value is not None
    ]
