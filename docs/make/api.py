"""The reference of `import autodb`, read off its docstrings."""

import inspect
import re
from collections.abc import Iterator
from types import FunctionType
from typing import Any

import autodb
from autodb.library import answers, edges, found, planned, results

BEGIN, END = "<!-- library: made by python -m docs.make -->\n", "<!-- end of library -->\n"
RESULTS = (
    answers.ImportResult,
    answers.CalibrateResult,
    answers.RefreshResult,
    answers.ForcesResult,
    answers.PredictResult,
    answers.LookupResult,
    answers.PairsResult,
    edges.EdgeChangeResult,
    edges.EdgesResult,
    planned.ToolLifeResult,
    planned.StabilityResult,
    found.ExplainResult,
    found.IdentifyResult,
    results.ResultPage,
)
EXAMPLE = re.compile(r"^>>> .*", re.MULTILINE | re.DOTALL)


def reference() -> str:
    """Return a section for each function, for the two classes, and for every result."""
    functions = [name for name in autodb.__all__ if isinstance(getattr(autodb, name), FunctionType)]
    parts = [_function(f"autodb.{name}", getattr(autodb, name)) for name in functions]
    parts += [_class(each) for each in (autodb.Database, autodb.ShopMachine, *RESULTS)]
    return "\n".join(parts)


def filled(page: str) -> str:
    """Return ``page`` with the reference between its two comments."""
    before, rest = page.split(BEGIN)
    _, after = rest.split(END)
    return f"{before}{BEGIN}\n{reference()}\n{END}{after}"


def _function(name: str, function: Any) -> str:
    return f"## {name}\n\n{_call(name, function)}\n\n{_text(function)}\n"


def _class(each: type) -> str:
    lines = [f"## {each.__name__}", "", _text(each), ""]
    for name, method in _members(each):
        call = f"`.{name}`" if isinstance(method, property) else _call(f".{name}", method)
        lines += [f"{call}", "", _text(method), ""]
    return "\n".join(lines)


def _members(each: type) -> Iterator[tuple[str, Any]]:
    for name, member in vars(each).items():
        if not name.startswith("_") and isinstance(member, property | FunctionType):
            yield name, member


def _call(name: str, function: Any) -> str:
    """Return a call with its arguments, without their types."""
    known = inspect.signature(function).parameters.values()
    bare = [one.replace(annotation=inspect.Parameter.empty) for one in known if one.name != "self"]
    return f"`{name}{inspect.Signature(bare)}`"


def _text(documented: Any) -> str:
    """Return a docstring as Markdown, its example as code."""
    text = inspect.cleandoc(str(documented.__doc__)).replace("``", "`")
    example = EXAMPLE.search(text)
    if example is None:
        return text
    return f"{text[: example.start()]}```pycon\n{example[0].rstrip()}\n```"
