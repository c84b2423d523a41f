"""What is wrong with a value is said in plain words, in the language of the reader."""

from typing import Annotated, Any, Literal

import pytest
from pydantic import BaseModel, ConfigDict, Field, ValidationError, field_validator

from autodb.wording.mistakes import mistake_words
from autodb.wording.presentation import Presentation, presented


class _Cut(BaseModel):
    model_config = ConfigDict(extra="forbid")

    depth_mm: Annotated[float, Field(gt=0.0, le=40.0, allow_inf_nan=False)] = 1.0
    count: Annotated[int, Field(ge=1, lt=10)] = 1
    name: str = ""
    operation: Literal["turn", "face"] = "turn"
    coolant: bool = True
    passes: list[float] = []
    tool: dict[str, float] = {}
    work: "_Cut | None" = None

    @field_validator("name")
    @classmethod
    def _no_slash(cls, name: str) -> str:
        if "/" in name:
            raise ValueError("a name has no slash")
        return name


MISTAKES = [
    ({"depth_mm": "a"}, "must be a number, not 'a'", "muss eine Zahl sein, nicht 'a'"),
    ({"depth_mm": None}, "must be a number, not this", "muss eine Zahl sein, nicht dies"),
    ({"depth_mm": float("inf")}, "must be a finite number, not inf", None),
    ({"depth_mm": -0.5}, "must be greater than 0, not -0.5", "muss größer als 0 sein, nicht -0,5"),
    ({"depth_mm": 50}, "must be at most 40, not 50", None),
    ({"count": 1.5}, "must be a whole number, not 1.5", None),
    ({"count": 0}, "must be at least 1, not 0", None),
    ({"count": 10}, "must be less than 10, not 10", None),
    ({"name": 3}, "must be a text, not 3", "muss ein Text sein, nicht 3"),
    ({"name": "a/b"}, "a name has no slash", "a name has no slash"),
    ({"operation": "saw"}, "must be one of 'turn', 'face', not 'saw'", None),
    ({"coolant": "much"}, "must be true or false, not 'much'", None),
    ({"passes": 3}, "must be a list, not 3", None),
    ({"tool": True}, "must be a table of keys, not true", None),
    ({"work": "x" * 99}, f"must be a table of keys, not '{'x' * 38}…", None),
]


@pytest.mark.parametrize(("said", "english", "german"), MISTAKES)
def test_each_kind_of_mistake_has_words(
    said: dict[str, Any], english: str, german: str | None
) -> None:
    with pytest.raises(ValidationError) as error:
        _Cut.model_validate(said)
    (mistake,) = error.value.errors()
    assert mistake_words(mistake) == english
    with presented(Presentation(language="de")):
        assert german in (None, mistake_words(mistake))
        assert german is not None or mistake_words(mistake) != english


def test_what_is_missing_is_said_so() -> None:
    class Named(BaseModel):
        name: str

    with pytest.raises(ValidationError) as error:
        Named.model_validate({})
    assert mistake_words(error.value.errors()[0]) == "is missing"
