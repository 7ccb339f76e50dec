"""What all cases share: named inputs with ranges, checked before anything is computed."""

import difflib
from collections.abc import Mapping
from types import UnionType
from typing import Any, ClassVar, Literal, Self, Union, get_args, get_origin

import annotated_types as at
from pydantic import BaseModel, ConfigDict, ValidationError
from pydantic.fields import FieldInfo

from flangeway.errors import InputError

_BOUNDS = ((at.Gt, "gt", "above"), (at.Ge, "ge", "from"), (at.Lt, "lt", "below"), (at.Le, "le", "up to"))


class Case(BaseModel):
    """Inputs of a computation; every key bears its unit, and what is left out has a default.

    Build one with `from_values`, which raises `InputError`.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    name: ClassVar[str]
    title: ClassVar[str]

    @classmethod
    def from_values(cls, values: Mapping[str, Any]) -> Self:
        """Return the case with some inputs changed; numbers may be given as text.

        Raises
        ------
        InputError
            If a key is unknown or a value is not allowed; the message says what is, for each.

        """
        try:
            return cls(**values)
        except ValidationError as reason:
            raise _input_error(cls, reason) from None

    @classmethod
    def inputs(cls) -> list[tuple[str, str, str, str]]:
        """Key, default, what is allowed, and meaning of every input."""
        return [
            (key, _text(field.default), allowed(field), field.description or "")
            for key, field in cls.model_fields.items()
        ]


def allowed(field: FieldInfo) -> str:
    """Say in words what a field accepts."""
    bounds = [
        f"{word} {getattr(limit, attribute):g}"
        for kind, attribute, word in _BOUNDS
        for limit in field.metadata
        if isinstance(limit, kind)
    ]
    words = []
    for kind in _alternatives(field.annotation):
        if get_origin(kind) is Literal:
            words += [str(value) for value in get_args(kind)]
        elif kind is float:
            words.append(" ".join(["a number", *bounds]))
        elif kind is int:
            words.append(" ".join(["a whole number", *bounds]))
        elif kind is str:
            words.append("a name")
    return " or ".join(words)


def _alternatives(annotation: Any) -> tuple[Any, ...]:
    """Types of a union, or the one type that there is."""
    return get_args(annotation) if get_origin(annotation) in (Union, UnionType) else (annotation,)


def closest(word: str, known: list[str]) -> str:
    """Advice that names the known word most like the given one."""
    near = difflib.get_close_matches(word, known, n=1, cutoff=0.5)
    return f"did you mean {near[0]}?" if near else "choose one of these"


def _text(value: object) -> str:
    return f"{value:.10g}" if isinstance(value, float) else str(value)


def _input_error(case: type[Case], reason: ValidationError) -> InputError:
    given, allow, advice = [], [], []
    for error in reason.errors():
        key = str(error["loc"][0])
        given.append(f"{key} = {error['input']!r}")
        field = case.model_fields.get(key)
        if field is None:
            known = list(case.model_fields)
            given[-1] = f"an input called {key!r}"
            allow.append(f"the inputs of {case.name}: {', '.join(known)}")
            advice.append(closest(key, known))
        else:
            allow.append(f"{key} is {allowed(field)}")
            advice.append(f"leave {key} out to take {_text(field.default)} ({field.description})")
    return InputError("; ".join(given), "; ".join(allow), "; ".join(advice))
