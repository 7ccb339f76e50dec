"""What all cases share: named inputs with ranges, checked before anything is computed."""

import difflib
import math
from abc import abstractmethod
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from types import UnionType
from typing import Annotated, Any, ClassVar, Literal, Protocol, Self, Union, get_args, get_origin

import annotated_types as at
from pydantic import BaseModel, ConfigDict, Field, PrivateAttr, Strict, ValidationError, model_validator
from pydantic.fields import FieldInfo

from flangeway.cases.summary import Summary, summary_numbers
from flangeway.checks import is_number
from flangeway.errors import InputError, short
from flangeway.solve import Status
from flangeway.system.file_content import toml_data
from flangeway.types import Key
from flangeway.units import Units, UsUnit, in_us_units, same_quantity, us_key

Progress = Callable[[str], None]

OF_REPORT = ("units", "report_title", "project", "author", "date")
"""Inputs that change nothing of what is computed."""

RENAMED = {
    "cant": "rail_inclination",
    "barycentre_height_mm": "centre_of_gravity_height_mm",
    "largest_lateral_mm": "maximum_lateral_mm",
    "largest_amplitude_mm": "maximum_amplitude_mm",
}
"""Keys of earlier versions, and what they are called now: the error for an old key names the new one."""
MAX_REPORTED = 5  # errors in one message; of the others only the number is given
MAX_NUMBER = 1e30  # no length, force or modulus is larger in its unit

_BOUNDS = ((at.Gt, "gt", "above"), (at.Ge, "ge", "from"), (at.Lt, "lt", "below"), (at.Le, "le", "up to"))


Pair = Annotated[tuple[float, float], Strict(False)]  # two numbers in a list, as files have them
Box = Annotated[tuple[float, float, float, float], Strict(False)]


class GivenText(str):
    """A value of the command line or of a CSV table: the input's type decides whether it is a number, true, or text."""


class Run(Protocol):
    """What every run of a case has, whatever the case."""

    @property
    def case(self) -> "Case":
        """The inputs."""

    @property
    def status(self) -> Status:
        """How it ended."""

    @property
    def summary(self) -> Summary:
        """Plain numbers with their units in the names."""


class Table(BaseModel):
    """A group of inputs inside a case: a table of a case file. A number is a number, not a text nor a truth value."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False, strict=True)

    @model_validator(mode="before")
    @classmethod
    def _typed(cls, values: Any) -> Any:
        """Read what is `GivenText`, take tuples and NumPy's numbers as Python's, and US units as metric ones."""
        if not isinstance(values, Mapping):
            return values
        found: dict[str, Any] = {}
        for key, value in values.items():
            name, unit = cls.input_named(key)
            if name not in cls.model_fields or (unit and (name in values or name in found)):  # unknown, or given twice
                found[key] = value
                continue
            read = _typed(value, cls.model_fields[name].annotation)
            found[name] = unit.to_metric(read) if unit else read
        return found

    @classmethod
    def input_named(cls, key: str) -> tuple[str, UsUnit | None]:
        """Name of the input that a key means, and the US unit that the key has; the key itself if there is none."""
        if key not in cls.model_fields:
            for name in cls.model_fields:
                unit = us_key(name)
                if unit is not None and unit.name == key:
                    return name, unit
        return key, None

    def refuse_without_effect(self, keys: Iterable[str], key: str, wanted: str, within: str = "") -> None:
        """Refuse inputs that another one leaves without effect, if they are not those by default.

        - `within`: path of this table in the case, before the inputs' names.
        """
        for name in keys:
            if getattr(self, name) != type(self).model_fields[name].default:
                raise InputError(
                    f"{within}{name} = {getattr(self, name)} with {key} = {getattr(self, key)}",
                    f"{name} with {key} = {wanted}",
                    f"leave {name} out, or give {key} = {wanted}",
                )


class Case(Table):
    """Inputs of a computation; units are in the names, and keys that are left out have defaults.

    Build one with `from_values`, which raises `InputError`.
    """

    name: ClassVar[str]
    title: ClassVar[str]
    units: Units = Field(
        "metric", description="units of results and messages; an input has the unit at the end of its key"
    )
    report_title: str | None = Field(
        None, max_length=200, description="title of the report (default: that of the case)"
    )
    project: str | None = Field(None, max_length=200, description="project, for the report")
    author: str | None = Field(None, max_length=200, description="author, for the report")
    date: str | None = Field(None, max_length=60, description="date, for the report (default: today)")
    _us_keys: set[str] = PrivateAttr(default_factory=set)  # inputs that were given in US units

    essential: ClassVar[tuple[str, ...]] = ()  # keys that are set in a new case file; the others are there as comments
    example: ClassVar[Mapping[str, Any]] = {}  # values of a new case file where they are not the defaults

    @classmethod
    def from_values(cls, values: Mapping[str, Any], where: Callable[[Key], str] = lambda _: "") -> Self:
        """Return the case with some inputs changed.

        Parameters
        ----------
        values
            Inputs by key; text that may be a number is `GivenText`.
        where
            Text before the message about a key, such as its file and line.

        Raises
        ------
        InputError
            If a key is unknown or a value is not allowed; the message says for each what is allowed.

        """
        try:
            _refuse_huge(values, where)
            case = cls(**values)
        except ValidationError as reason:
            raise _input_error(cls, reason, values, where) from None
        case._us_keys |= _us_keys(cls, values)
        return case

    def as_written(self, message: str) -> str:
        """Return a message with the inputs that were given in US units in them, or all of it if results are to be."""
        return in_us_units(message, None if self.units == "us" else self._us_keys)

    @contextmanager
    def errors_as_written(self, place: Callable[[str], str] = lambda _: "") -> Iterator[None]:
        """Raise errors with all parts `as_written`, after the place that a function finds for what was given."""
        try:
            yield
        except InputError as reason:
            given, allowed, advice = map(self.as_written, (reason.given, reason.allowed, reason.advice))
            raise InputError(f"{place(given)}{given}", allowed, advice) from reason

    @classmethod
    def tables_of_inputs(cls, units: Units = "metric") -> list[tuple[str, list[tuple[str, str, str, str]]]]:
        """Key, default, what is allowed, and meaning of every input; those inside tables apart, by the table's path."""
        return _inputs_of(cls, "", units)


class RunnableCase(Case):
    """A case that `flangeway run` computes."""

    @abstractmethod
    def check(self) -> None:
        """Raise `InputError` for what is wrong beyond single values, without computing."""

    position_keys: ClassVar[tuple[str, ...]] = ()
    """Inputs that leave the bodies as they are: cases that differ in these only share their `prepared` bodies."""

    @property
    def min_together(self) -> int | None:
        """Minimum number of cases with the same bodies for which preparing these pays; None: it never does."""
        return None

    def check_position(self) -> None:
        """Raise `InputError` for what is wrong with the inputs `position_keys`, where the others are checked."""

    def prepared(self, progress: Progress = lambda _: None) -> Any:
        """Return the bodies with what all cases with the same bodies share."""
        raise NotImplementedError

    def run_on(self, bodies: Any, progress: Progress = lambda _: None) -> Run:
        """Compute the case on bodies that are `prepared` for one that differs in `position_keys` only."""
        raise NotImplementedError

    def columns(self) -> tuple[str, ...]:
        """Return the columns of a row of a campaign if they are known before it is computed."""
        return ()

    def patch_columns(self) -> tuple[str, ...]:
        """Return the columns of the table of patches of a campaign."""
        return ()

    def row(self, run: Any) -> dict[str, Any]:
        """Return the numbers of a run by columns of a row of a campaign: all single numbers of its summary."""
        return summary_numbers(run.summary)

    def patch_rows(self, run: Any) -> list[dict[str, Any]]:  # noqa: ARG002 (cases without patches)
        """Return the rows of a run in the table of patches of a campaign."""
        return []

    def warnings_of(self, run: Any) -> Sequence[str]:
        """Return what limits the results of a run."""
        content = run.summary.to_dict()
        return content.get("warnings") or content.get("notices") or ()

    @abstractmethod
    def run(self, progress: Progress = lambda _: None) -> Run:
        """Compute the case.

        Raises
        ------
        InputError
            If the inputs make no problem that can be solved.
        MissingLibraryError
            If the mesh generator lacks a shared library of the system.

        """


def _inputs_of(table: type[Table], path: str, units: Units) -> list[tuple[str, list[tuple[str, str, str, str]]]]:
    rows, inner = [], []
    for key, field in table.model_fields.items():
        unit, meaning = us_key(key) if units == "us" else None, field.description or ""
        default = "needed" if field.is_required() else _default_text(field, unit)
        kind = table_in(field.annotation)
        if kind is not None:
            several = "[]" if any(get_origin(each) is list for each in alternatives(field.annotation)) else ""
            inner += _inputs_of(kind, f"{path}{key}{several}.", units)
            default = default if field.is_required() else "none"
        name, meaning = (unit.name if unit else key), (in_us_units(meaning) if units == "us" else meaning)
        rows.append((name, default, allowed(field, unit), meaning))
    return [(path.rstrip("."), rows), *inner]


GROUPS = {
    "rail": "Profiles",
    "gauge_mm": "Track and wheelset",
    "axle_load_kN": "Load and curve",
    "thickness_mm": "Bodies and material",
    "young_MPa": "Bodies and material",
    "model": "Position",
    "lateral_mm": "Position",
    "rail_support": "Rails on sleepers, wheels and axle",
    "wheel_young_MPa": "Materials of wheels and rails",
    **dict.fromkeys(("method", "upper_method", "size_mm", "cell_mm"), "Elements and mesh"),
    "pairing": "Contact",
    **dict.fromkeys(
        ("force_kN", "radius_mm", "width_mm", "shaft_radius_mm", "bore_radius_mm"), "Load and dimensions of the bodies"
    ),
    "equilibria": "Equilibrium",
    "longitudinal_creepage": "Motion and friction",
    "curve": "Creep curve and cells",
}
"""Captions of the groups of inputs, by the key that begins the group."""


def grouped(rows: list[tuple[str, str, str, str]]) -> dict[str, list[tuple[str, str, str, str]]]:
    """Return the inputs of a table in their groups, by the caption."""
    found: dict[str, list[tuple[str, str, str, str]]] = {}
    caption = ""
    for row in rows:
        caption = next((text for key, text in GROUPS.items() if row[0] == key or same_quantity(key, row[0])), caption)
        found.setdefault(caption, []).append(row)
    return found


def allowed(field: FieldInfo, unit: UsUnit | None = None) -> str:
    """Say in words what a field accepts, or its key in a US unit."""
    bounds = [
        f"{word} {(unit.of if unit else float)(getattr(limit, attribute)):g}"
        for kind, attribute, word in _BOUNDS
        for limit in field.metadata
        if isinstance(limit, kind)
    ]
    return " or ".join(_words(field.annotation, " ".join(bounds)))


def _words(annotation: Any, bounds: str = "") -> list[str]:
    """What the alternatives of a type are called."""
    words = []
    for kind in alternatives(annotation):
        origin, members = get_origin(kind), get_args(kind)
        if origin is Literal:
            words += [str(value) for value in members]
        elif kind is float:
            words.append(f"a number {bounds}".strip())
        elif kind is int:
            words.append(f"a whole number {bounds}".strip())
        elif kind is bool:
            words.append("true or false")
        elif kind is str:
            words.append("a name")
        elif origin is tuple:
            words.append(f"[{', '.join(' or '.join(_words(each, bounds)) for each in members)}]")
        elif members == (str,):
            words.append("a list of names")
        elif origin in (list, dict):
            inner = " or ".join(_words(members[-1], bounds)).replace("a table with", "tables with")
            words.append(f"{'a list' if origin is list else 'a table'}{f' of {inner}' if inner else ''}")
        elif table_in(kind):
            words.append(f"a table with the keys {', '.join(kind.model_fields)}")
    return words


def alternatives(annotation: Any) -> tuple[Any, ...]:
    """Types of a union, or the one type that there is."""
    if get_origin(annotation) is Annotated:
        annotation = get_args(annotation)[0]
    if get_origin(annotation) in (Union, UnionType):
        return tuple(kind for each in get_args(annotation) for kind in alternatives(each))
    return (annotation,)


def table_in(annotation: Any) -> type[Table] | None:
    """Type of the tables of an input, alone, in a list or by name; None for plain values."""
    for kind in alternatives(annotation):
        if isinstance(kind, type) and issubclass(kind, Table):
            return kind
        if get_origin(kind) in (list, dict):
            return table_in(get_args(kind)[-1])
    return None


def closest(word: str, known: list[str]) -> str:
    """Advice that names the known word most like the given one."""
    near = difflib.get_close_matches(word, known, n=1, cutoff=0.5)
    return f"did you mean {near[0]}?" if near else "choose one of these"


def require_known(key: str, name: str, known: Collection[str], what: str = "") -> None:
    """Refuse a name that is not among the known ones, and name the one most like it; `what` these are is optional."""
    if name not in known:
        names = f"{f'{what}: ' if what else ''}{', '.join(known) or 'none'}"
        raise InputError(f"{key} = {name!r}", names, closest(name, [*known]) if known else "leave it out")


def key_text(key: Key) -> str:
    """Write a path of keys: ``bodies[1].young_MPa``, counted from 1."""
    text = ""
    for item in key:
        text += f"[{item + 1}]" if isinstance(item, int) else f".{item}" if text else item
    return text


def _text(value: object) -> str:
    if value is None or isinstance(value, bool):
        return "none" if value is None else str(value).lower()
    return f"{value:.10g}" if isinstance(value, float) else str(value)


def _refuse_huge(value: Any, where: Callable[[Key], str], key: Key = ()) -> None:
    """Refuse numbers, also as text and inside tables, whose squares and products would leave the range of floats."""
    if isinstance(value, Mapping):
        for name, inner in value.items():
            _refuse_huge(inner, where, (*key, name))
    elif isinstance(value, list | tuple):
        for item, inner in enumerate(value):
            _refuse_huge(inner, where, (*key, item))
    elif isinstance(value, int | float | GivenText):
        try:
            number = abs(float(value))
        except ValueError:  # a name
            return
        except OverflowError:  # an integer of hundreds of digits
            number = 2.0 * MAX_NUMBER
        if MAX_NUMBER < number < math.inf:
            raise InputError(
                f"{where(key)}{key_text(key)} = {short(value)}", f"numbers up to {MAX_NUMBER:g}", "correct it"
            )


def _typed(value: Any, annotation: Any) -> Any:
    """A value as the types of an input want it, where that is no guess."""
    kinds = alternatives(annotation)
    if isinstance(value, GivenText):
        return _read(value, kinds)
    if is_number(value) and not isinstance(value, int | float):
        return value.item() if hasattr(value, "item") else float(value)
    inner = next((get_args(kind)[-1] for kind in kinds if get_origin(kind) in (dict, list)), Any)
    if isinstance(value, Mapping) and table_in(inner) is None and all(table_in(kind) is None for kind in kinds):
        return {key: _typed(each, inner) for key, each in value.items()}
    return list(value) if isinstance(value, tuple) else value


def _read(text: GivenText, kinds: tuple[Any, ...]) -> Any:
    """Value of a text as one of some types; the text where none of them fits."""
    choices = [choice for kind in kinds if get_origin(kind) is Literal for choice in get_args(kind)]
    readers: list[Callable[[str], Any]] = [{str(choice): choice for choice in choices}.__getitem__]
    if bool in kinds:
        readers.append(lambda word: {"true": True, "false": False}[word.lower()])
    readers += [kind for kind in (int, float) if kind in kinds]
    if Any in kinds or text[:1] in ("[", "{"):
        readers.append(lambda toml: toml_data(f"value = {toml}", "")["value"])
    for read in readers:
        try:
            return read(text)
        except (KeyError, ValueError, InputError):
            continue
    return str(text)


def _default_text(field: FieldInfo, unit: UsUnit | None) -> str:
    default = field.get_default(call_default_factory=True)
    return f"{unit.of(default):.6g}" if unit and is_number(default) else _text(default)


def merged(values: Mapping[str, Any], over: Mapping[str, Any]) -> dict[str, Any]:
    """Return inputs with others over them, which also replace the same quantities in the other units."""
    kept = {key: value for key, value in values.items() if not any(same_quantity(key, new) for new in over)}
    return {**kept, **over}


def _advice(key: str, field: FieldInfo, unit: UsUnit | None) -> str:
    meaning = in_us_units(field.description or "") if unit else field.description
    if field.is_required():
        return f"give {key}: {meaning}"
    return f"leave {key} out for the default {_default_text(field, unit)} ({meaning})"


def _input_error(
    case: type[Case], reason: ValidationError, values: Mapping[str, Any], where: Callable[[Key], str]
) -> InputError:
    given, allow, advice = [], [], []
    in_us = values.get("units") == "us"
    faults: dict[Key, tuple[Any, type[Table], FieldInfo | None]] = {}
    for error in reason.errors(include_url=False, include_context=False):
        key, table, field = _found(case, error["loc"])
        faults.setdefault(_written(values, key), (error, table, field))
    for key, (error, table, field) in [*faults.items()][:MAX_REPORTED]:
        name, text = str(key[-1]) if key else "", key_text(key)
        last = next((item for item in reversed(key) if isinstance(item, str)), "")
        unit = table.input_named(last)[1]
        if error["type"] == "missing" and field is not None:
            unit = us_key(name) if in_us else None
            name = unit.name if unit else name
            given.append(f"{where(key[:-1])}no {key_text((*key[:-1], name))}")
            allow.append(f"{name} is {allowed(field, unit)}")
            advice.append(_advice(name, field, unit))
        elif field is None and unit is not None:
            given.append(f"{where(key)}{text}, and the same quantity in another unit")
            allow.append("one of them")
            advice.append(f"leave {name} or the other one out")
        elif field is None:
            known = sorted(table.model_fields, key=OF_REPORT.__contains__)  # the last ones of the list
            us = {each: unit.name for each in known if (unit := us_key(each))}
            shown = [us.get(each, each) for each in known] if in_us else known
            inside = key_text(key[:-1])
            given.append(f"{where(key)}there is no input called {short(name)}{f' in {inside}' if inside else ''}")
            allow.append(f"the inputs of {inside or case.name}: {', '.join(shown)}")
            new = RENAMED.get(name)
            advice.append(
                f"{name} is now {new}" if new in known else closest(name, shown if in_us else [*known, *us.values()])
            )
        else:
            given.append(f"{where(key)}{text} = {short(_at(values, key, error['input']))}")
            allow.append(f"{last} is {allowed(field, unit)}")
            advice.append(_advice(last, field, unit))
    if len(faults) > MAX_REPORTED:
        given.append(f"and {len(faults) - MAX_REPORTED} more")
    return InputError("; ".join(given), "; ".join(dict.fromkeys(allow)), "; ".join(dict.fromkeys(advice)))


def _written(values: Any, key: Key) -> Key:
    """Path of an input with its keys as they were written, which may have US units."""
    found: list[str | int] = []
    for item in key:
        if isinstance(values, Mapping) and item not in values:
            item = next((name for name in values if same_quantity(str(item), str(name))), item)  # noqa: PLW2901
        found.append(item)
        values = _at(values, (item,), None)
    return tuple(found)


def _us_keys(table: type[Table], values: Mapping[str, Any]) -> set[str]:
    """Return the inputs, those of tables inside too, that are given in US units."""
    found = set()
    for key, value in values.items():
        name, unit = table.input_named(key)
        found |= {name} if unit else set()
        kinds = alternatives(table.model_fields[name].annotation)
        by_name = isinstance(value, Mapping) and any(get_origin(kind) is dict for kind in kinds)
        inner = table_in(table.model_fields[name].annotation)
        for each in value.values() if by_name else value if isinstance(value, list) else [value]:
            if inner is not None and isinstance(each, Mapping):
                found |= _us_keys(inner, each)
    return found


def _at(values: Any, key: Key, otherwise: Any) -> Any:
    """The value as it was given at a path; another one where the path leads nowhere."""
    for item in key:
        try:
            values = values[item]
        except (KeyError, IndexError, TypeError):
            return otherwise
    return values


def _found(case: type[Table], location: Key) -> tuple[Key, type[Table], FieldInfo | None]:
    """Path of a fault without the names of alternatives, the table it is in, and the field, None for unknown keys."""
    path: list[str | int] = []
    table: type[Table] = case
    inner: type[Table] | None = case
    field: FieldInfo | None = None
    by_name = False
    for item in location:
        if isinstance(item, int) or by_name:
            path.append(item)
            by_name = False
        elif inner is not None and item in inner.model_fields:
            table, field = inner, inner.model_fields[item]
            path.append(item)
            inner = table_in(field.annotation)
            by_name = any(get_origin(kind) is dict for kind in alternatives(field.annotation))
        elif inner is not None and not item.startswith(("list[", "dict[")):
            return (*path, item), inner, None
        else:
            break  # the name of one of several types
    return tuple(path), table, field
