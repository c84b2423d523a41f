"""Answers as JSON, with the mark of the state of the database that they are of."""

from functools import cache
from typing import Any

from fastapi import Request, Response
from pydantic import TypeAdapter


@cache
def adapter(kind: Any) -> TypeAdapter[Any]:
    """Return what writes and reads a type as JSON, made once."""
    return TypeAdapter(kind)


def tag_of(mark: str) -> str:
    """Return the entity tag of a state of the database."""
    return f'"{mark}"'


def unchanged(request: Request, mark: str) -> Response | None:
    """Return the answer to who has one of this state already, else None."""
    tag = tag_of(mark)
    known = request.headers.get("if-none-match")
    if known is None or tag not in (one.strip() for one in known.split(",")):
        return None
    return Response(status_code=304, headers={"ETag": tag})


def answer(kind: Any, value: object, mark: str) -> Response:
    """Return a value as JSON."""
    body = adapter(kind).dump_json(value)
    return Response(body, media_type="application/json", headers={"ETag": tag_of(mark)})
