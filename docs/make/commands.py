"""The command reference, read off the command line itself."""

from typing import Any

from autodb.cli import commands
from autodb.cli._listed import example_lines

BEGIN, END = "<!-- commands: made by python -m docs.make -->\n", "<!-- end of commands -->\n"


def reference() -> str:
    """Return a section for every command: usage, what it does, its arguments and options."""
    return "\n".join(_sections("autodb", commands()))


def filled(page: str) -> str:
    """Return ``page`` with the reference between its two comments."""
    before, rest = page.split(BEGIN)
    _, after = rest.split(END)
    return f"{before}{BEGIN}\n{reference()}\n{END}{after}"


def _sections(path: str, command: Any) -> list[str]:
    """Return the section of a command, or those of all that it groups."""
    below = getattr(command, "commands", None)
    if below is None:
        return [_section(path, command)]
    return [text for name in below for text in _sections(f"{path} {name}", below[name])]


def _section(path: str, command: Any) -> str:
    name = path.removeprefix("autodb ")
    usage = " ".join(
        f"`{part}`" for part in (path, *(_usage(p) for p in command.params if not p.hidden))
    )
    lines = [f"## {name}", "", usage, "", str(command.help), ""]
    if command.params:
        lines += ["| takes | default | meaning |", "|---|---|---|"]
        lines += [*(_row(p) for p in command.params if not p.hidden), ""]
    lines += ["```sh", *example_lines(name), "```", ""]
    return "\n".join(lines)


def _row(parameter: Any) -> str:
    text, default = str(parameter.help).replace("\\[", "["), _default(parameter)
    said = text.rsplit("[default: ", maxsplit=1)
    if len(said) == 2:
        text, default = said[0].strip(), said[1].rstrip("].")
    return f"| `{_named(parameter)}` | {default} | {_sentence(text)} |"


def _default(parameter: Any) -> str:
    if parameter.required:
        return "required"
    return "" if parameter.default in (None, False) else f"`{parameter.default}`"


def _sentence(text: str) -> str:
    text = text.replace("|", "\\|")
    return text if text.endswith((".", "?")) else f"{text}."


def _usage(parameter: Any) -> str:
    named = _named(parameter)
    return named if parameter.required else f"[{named}]"


def _named(parameter: Any) -> str:
    """Return ``--option VALUE``, ``--flag`` or ``ARGUMENT``; … after one that can be repeated."""
    option = parameter.opts[0]
    more = "…" if parameter.nargs == -1 else ""
    if not option.startswith("-"):
        return f"{option.upper()}{more}"
    return option if _is_flag(parameter) else f"{option} {_value(parameter)}{more}"


def _is_flag(parameter: Any) -> bool:
    return bool(getattr(parameter, "is_flag", False))


def _value(parameter: Any) -> str:
    """Return what an option takes, named after it: its words are the reader's, not a type's."""
    known = {"--columns": "FILE", "--db": "URL", "--file": "FILE", "--out": "DIR"}
    known |= {
        "--simulation": "FILE",
        "--machine": "NAME",
        "--protocol": "NAME",
        "--includes": "TERM,…",
        "--group": "NAME",
        "--resample": "HZ",
    }
    option = str(parameter.opts[0])
    return parameter.metavar or known.get(option, option.removeprefix("--").upper())
