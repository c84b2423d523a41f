"""Answers as JSON, with the mark of the state of the database that they are of."""

import re
from functools import cache
from typing import Any

from fastapi import Request, Response
from pydantic import TypeAdapter

ANY = "*"
_TAG = re.compile(r'(?:W/)?("[^"]*")')
"""An entity tag, of which what follows a W/ counts (RFC 9110, section 8.8.3)."""


@cache
def adapter(kind: Any) -> TypeAdapter[Any]:
    """Return what writes and reads a type as JSON, made once."""
    return TypeAdapter(kind)


def tag_of(mark: str) -> str:
    """Return the entity tag of a state of the database."""
    return f'"{mark}"'


def unchanged(request: Request, mark: str) -> Response | None:
    """Return the answer to who has one of this state already, else None.

    Whether a tag is weak does not matter here (RFC 9110, section 13.1.2).
    """
    tag = tag_of(mark)
    return _not_modified(tag) if tag in _TAG.findall(_known(request)) else None


def conditional(request: Request, kind: Any, value: object, mark: str) -> Response:
    """Return a value as JSON, or that it is there, to who wants it only where it is not (`*`)."""
    if _known(request).strip() == ANY:
        return _not_modified(tag_of(mark))
    return json_answer(kind, value, mark)


def _known(request: Request) -> str:
    """Return the tags that who asks has answers of; a list may come as several headers."""
    return ",".join(request.headers.getlist("if-none-match"))


def _not_modified(tag: str) -> Response:
    return Response(status_code=304, headers={"ETag": tag})


def json_answer(kind: Any, value: object, mark: str) -> Response:
    """Return a value as JSON."""
    body = adapter(kind).dump_json(value)
    return Response(body, media_type="application/json", headers={"ETag": tag_of(mark)})
