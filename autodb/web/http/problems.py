"""What a request gets in place of an answer: one line that ends in the remedy."""

from collections.abc import Sequence
from typing import Any

from fastapi.responses import JSONResponse
from pydantic import BaseModel

from autodb.wording import language_of, phrase
from autodb.wording.mistakes import mistake_words


class HttpProblem(BaseModel):
    """Why there is no answer; ``detail`` is one line, which ends in the remedy."""

    detail: str


WORDS = {
    400: "Not a request that can be read.",
    401: "No token, or one that is not valid.",
    403: "The token's role does not allow it, or the service is read-only.",
    404: "There is none of that name or number.",
    408: "It took too long to be sent.",
    409: "Something else was decided meanwhile.",
    413: "Larger than is taken.",
    422: "Unusable input: which key, and the remedy.",
    429: "Too often; Retry-After says when to try again.",
    503: "The database is away, locked or damaged, or too much waits: then Retry-After says when "
    "to try again.",
}


def problems(*statuses: int) -> dict[int | str, dict[str, Any]]:
    """Return how a route's document names the statuses that are no answer; any may get 400."""
    every = sorted({400, *statuses})
    return {one: {"model": HttpProblem, "description": WORDS[one]} for one in every}


def problem(status: int, detail: str, headers: dict[str, str] | None = None) -> JSONResponse:
    """Return the response for what could not be answered."""
    language = {"Content-Language": language_of(detail)}
    made = HttpProblem(detail=str(detail)).model_dump()
    return JSONResponse(made, status, {**language, **(headers or {})})


def first_of(errors: Sequence[Any]) -> str:
    """Return the first error of a model in one line: where, and why."""
    first = errors[0]
    where = ".".join(str(part) for part in first["loc"] if part != "body")
    message = mistake_words(first)
    return phrase("{where}: {problem}", where=where, problem=message) if where else message
