"""What all cases share: named inputs with ranges, checked before anything is computed; and a case on a finer mesh."""

import ast
import difflib
import inspect
import math
import sys
from abc import abstractmethod
from collections import ChainMap
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cache
from itertools import pairwise
from pathlib import Path
from types import UnionType
from typing import Annotated, Any, ClassVar, Literal, Self, TypeAlias, Union, cast, get_args, get_origin

import annotated_types as at
from pydantic import BaseModel, ConfigDict, Field, Strict, ValidationError, model_validator
from pydantic.fields import FieldInfo

from flangeway.cases.summary import RunResult, mapped, summary_numbers
from flangeway.checks import is_number
from flangeway.errors import InputError, short
from flangeway.system.file_content import toml_data
from flangeway.types import Key, Progress
from flangeway.units import Units, UsUnit, metric_key, same_quantity, us_key

# --- What all cases share: named inputs with ranges, checked before anything is computed.


HALVING = {
    **dict.fromkeys(
        ("size_scale", "size", "size_mm", "body_size_mm", "upper_size_mm", "lower_size_mm", "cell_mm"), 0.5
    ),
    **dict.fromkeys(("patch_cells", "cells_along", "cells_across"), 2),
}
"""Inputs that say how fine a mesh or grid is, and the factors on them that halve its sizes."""
OF_REPORT = ("units", "report_title", "project", "author", "date")
"""Inputs that change nothing of what is computed."""

MAX_LISTED, MAX_SIMILAR = 20, 5  # inputs that a message lists; of more only the similar ones
MIN_LETTERS_OF_PART = 3  # of a word that is looked for inside of others
MAX_REPORTED = 5  # errors in one message; of the others only the number is given
MAX_NUMBER = 1e30  # no length, force or modulus is larger in its unit

PLAIN_TYPES = {float: "a number {}", int: "a whole number {}", bool: "true or false", str: "a name"}
"""What inputs of one value are called, with their bounds."""
_BOUNDS = ((at.Gt, "gt", "above"), (at.Ge, "ge", "from"), (at.Lt, "lt", "below"), (at.Le, "le", "up to"))


Pair = Annotated[tuple[float, float], Strict(False)]  # two numbers in a list, as files have them
Box = Annotated[tuple[float, float, float, float], Strict(False)]

# inputs with the same limits
Positive = Annotated[float, at.Gt(0.0)]
NotNegative = Annotated[float, at.Ge(0.0)]
Fraction = Annotated[float, at.Gt(0.0), at.Le(1.0)]
SolidModulus = Annotated[float, at.Ge(1000.0)]  # of wheels and rails, MPa; plastics have 2000, steel 210 in GPa
PoissonRatio = Annotated[float, at.Gt(-1.0), at.Lt(0.5)]
ElementSize = Annotated[float, at.Ge(1e-6)]
ElementOrder = Annotated[int, at.Ge(1), at.Le(2)]
LengthUnit = Literal["mm", "cm", "m", "in", "ft"]


InputRow: TypeAlias = tuple[str, str, str, str]
"""Key, default, what is allowed, and meaning of an input."""


class GivenText(str):
    """A value of the command line or of a CSV table: the input's type decides whether it is a number, true, or text."""


@cache
def _texts_below(module: str) -> dict[str, dict[str, str]]:
    """Texts below the inputs of the classes of a module, by the classes' names; none where there is no source."""
    try:
        source = inspect.getsource(sys.modules[module])
    except (OSError, TypeError):
        return {}
    texts: dict[str, dict[str, str]] = {}
    for node in ast.parse(source).body:
        if isinstance(node, ast.ClassDef):
            texts[node.name] = {}
            for line in pairwise(node.body):
                match line:
                    case ast.AnnAssign(target=ast.Name(key)), ast.Expr(ast.Constant(str(text))):
                        texts[node.name][key] = text
    return texts


class Table(BaseModel):
    """A group of inputs inside a case: a table of a case file. A number is a number, not a text nor a truth value.

    Build one with `from_values`, which raises `InputError`.
    """

    model_config = ConfigDict(defer_build=True, extra="forbid", frozen=True, allow_inf_nan=False, strict=True)

    @classmethod
    def described_fields(cls) -> dict[str, FieldInfo]:
        """Return the inputs with their descriptions, in one line what stands below them in the source.

        They are read when they are first shown: pydantic's ``use_attribute_docstrings`` takes longer for all cases than
        a short run.
        """
        below = ChainMap(*(_texts_below(kind.__module__).get(kind.__name__, {}) for kind in cls.__mro__))
        for key, field in cls.model_fields.items():
            text = field.description or below.get(key)
            field.description = " ".join(text.split()) if text else None
        return cls.model_fields

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

        def refuse_huge(key: Key, value: Any) -> None:
            if isinstance(value, int | float | GivenText) and _is_huge(value):
                raise InputError(
                    f"{where(key)}{key_text(key)} = {short(value)}", f"numbers up to {MAX_NUMBER:g}", "correct it"
                )

        mapped(values, refuse_huge)
        try:
            return cls.model_validate(values)
        except ValidationError as reason:
            raise _input_error(cls, reason, values, where) from None

    @model_validator(mode="before")
    @classmethod
    def _typed(cls, values: Any) -> Any:
        """Read what is `GivenText`, take tuples and NumPy's numbers as Python's, and US units as metric ones."""
        if not isinstance(values, Mapping):
            return values
        metric: dict[str, Any] = {}
        for key, value in values.items():
            name, unit = cls.input_named(key)
            if name not in cls.model_fields or (unit and (name in values or name in metric)):  # unknown, or given twice
                metric[key] = value
                continue
            read = _typed(value, cls.model_fields[name].annotation)
            metric[name] = unit.to_metric(read) if unit else read
        return metric

    @classmethod
    def called(cls) -> str:
        """Return what messages call it."""
        return "the table"

    @classmethod
    def input_named(cls, key: str) -> tuple[str, UsUnit | None]:
        """Name of the input that a key means, and the US unit that the key has; the key itself if there is none."""
        return (key, None) if key in cls.model_fields else metric_key(key, cls.model_fields)

    @classmethod
    def tables_of_inputs(cls, units: Units = "metric", path: str = "") -> list[tuple[str, list[InputRow]]]:
        """Key, default, what is allowed, and meaning of every input; those inside tables apart, by the table's path.

        - `path`: that of this table in the case, with a point at the end.
        """
        rows, inner = [], []
        for key, field in cls.described_fields().items():
            unit = us_key(key) if units == "us" else None
            default = "needed" if field.is_required() else _default_text(field, unit)
            kind = table_in(field.annotation)
            if kind is not None:
                several = "[]" if any(get_origin(kind) is list for kind in alternatives(field.annotation)) else ""
                inner += kind.tables_of_inputs(units, f"{path}{key}{several}.")
                default = default if field.is_required() else "none"
            rows.append((unit.name if unit else key, default, allowed(field, unit), field.description or ""))
        return [(path.rstrip("."), rows), *inner]

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
    """Inputs of a computation; units are in the names, and keys that are left out have defaults."""

    name: ClassVar[str]
    title: ClassVar[str]
    units: Units = "metric"
    """units of numbers in results; an input has the unit at the end of its key"""
    report_title: str | None = Field(None, max_length=200)
    """title of the report (default: that of the case)"""
    project: str | None = Field(None, max_length=200)
    """project, for the report"""
    author: str | None = Field(None, max_length=200)
    """author, for the report"""
    date: str | None = Field(None, max_length=60)
    """date, for the report (default: today)"""

    essential: ClassVar[tuple[str, ...]] = ()  # keys that are set in a new case file; the others are there as comments
    example: ClassVar[Mapping[str, Any]] = {}  # values of a new case file where they are not the defaults

    @classmethod
    def called(cls) -> str:
        """See `Table.called`."""
        return cls.name


def example_of(name: str) -> dict[str, Any]:
    """Return the `Case.example` of a case, from its file in the folder ``examples``."""
    return toml_data((Path(__file__).parent / "examples" / f"{name}.toml").read_text(encoding="utf-8"), "")


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

    def run_on(self, bodies: Any, progress: Progress = lambda _: None) -> RunResult:
        """Compute the case on bodies that are `prepared` for one that differs in `position_keys` only."""
        raise NotImplementedError

    def halved_sizes(self) -> dict[str, float]:
        """Return the inputs `HALVING` with values for half of the sizes; an `InputError` if none has a value."""
        given = {key: getattr(self, key) for key in HALVING if key in type(self).model_fields}
        if "size_scale" in given:  # the other sizes are multiplied by it
            given = {key: value for key, value in given.items() if not key.endswith("size_mm")}
        finer = {key: type(value)(value * HALVING[key]) for key, value in given.items() if value is not None}
        if not finer:
            raise InputError(
                f"the case {self.name} without {' and '.join(given) or 'one size of all its elements'}",
                f"a case with a value of one of: {', '.join(HALVING)}",
                "give the size" if given else "run it twice, with its sizes and with smaller ones",
            )
        return finer

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
        return run.summary.get("warnings") or run.summary.get("notices") or ()

    @abstractmethod
    def run(self, progress: Progress = lambda _: None) -> RunResult:
        """Compute the case.

        Raises
        ------
        InputError
            If the inputs make no problem that can be solved.
        MissingLibraryError
            If the mesh generator lacks a shared library of the system.

        """


class PresetCase(RunnableCase):
    """A case with a few inputs that stands for a general case."""

    @abstractmethod
    def general(self) -> RunnableCase:
        """Return the same as a general case; an `InputError` if the inputs do not go together."""

    def check(self) -> None:
        """See `RunnableCase.check`."""
        self.general().check()

    def run(self, progress: Progress = lambda _: None) -> Any:
        """See `RunnableCase.run`."""
        return replace(cast("Any", self.general().run(progress)), case=self)


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
    "kinetic_friction": "Friction that falls with slip and temperature",
    "curve": "Creep curve and cells",
}
"""Captions of the groups of inputs, by the key that begins the group."""


def grouped(rows: list[InputRow]) -> dict[str, list[InputRow]]:
    """Return the inputs of a table in their groups, by the caption."""
    groups: dict[str, list[InputRow]] = {}
    caption = ""
    for row in rows:
        caption = next((text for key, text in GROUPS.items() if row[0] == key or same_quantity(key, row[0])), caption)
        groups.setdefault(caption, []).append(row)
    return groups


def allowed(field: FieldInfo, unit: UsUnit | None = None) -> str:
    """Say in words what a field accepts, or its key in a US unit."""
    bounds = [
        f"{word} {(unit.of if unit else float)(getattr(limit, attribute)):g}"
        for kind, attribute, word in _BOUNDS
        for limit in (*field.metadata, *_metadata(field.annotation))
        if isinstance(limit, kind)
    ]
    return " or ".join(_words(field.annotation, " ".join(bounds)))


def _metadata(annotation: Any) -> list[Any]:
    """What the members of a union are annotated with, such as their limits."""
    if get_origin(annotation) is Annotated:
        return list(annotation.__metadata__)
    return [constraint for member in get_args(annotation) for constraint in _metadata(member)]


def _words(annotation: Any, bounds: str = "") -> list[str]:
    """What the alternatives of a type are called."""
    words = []
    for kind in alternatives(annotation):
        origin, members = get_origin(kind), get_args(kind)
        if origin is Literal:
            words += [str(value) for value in members]
        elif kind in PLAIN_TYPES:
            words.append(PLAIN_TYPES[kind].format(bounds).strip())
        elif origin is tuple:
            words.append(f"[{', '.join(' or '.join(_words(member, bounds)) for member in members)}]")
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
        return tuple(kind for member in get_args(annotation) for kind in alternatives(member))
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
    names = similar(word, known)
    return f"did you mean {names[0]}?" if names else "choose one of these"


def similar(word: str, known: Iterable[str]) -> list[str]:
    """Known words that contain a word or are spelled like it, the most similar first."""
    known = [*known]
    containing = [name for name in known if len(word) >= MIN_LETTERS_OF_PART and word.lower() in name.lower()]
    return list(dict.fromkeys([*containing, *difflib.get_close_matches(word, known, n=MAX_SIMILAR, cutoff=0.6)]))


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


def _is_huge(value: float | GivenText) -> bool:
    """Whether squares and products of a number, also as text, may leave the range of floats."""
    try:
        return MAX_NUMBER < abs(float(value)) < math.inf
    except ValueError:  # a name
        return False
    except OverflowError:  # an integer of hundreds of digits
        return True


def _typed(value: Any, annotation: Any) -> Any:
    """A value as the types of an input want it, where that is no guess."""
    kinds = alternatives(annotation)
    if isinstance(value, GivenText):
        return _read(value, kinds)
    if is_number(value) and not isinstance(value, int | float):
        return value.item() if hasattr(value, "item") else float(value)
    inner = next((get_args(kind)[-1] for kind in kinds if get_origin(kind) in (dict, list)), Any)
    if isinstance(value, Mapping) and table_in(inner) is None and all(table_in(kind) is None for kind in kinds):
        return {key: _typed(entry, inner) for key, entry in value.items()}
    return list(value) if isinstance(value, tuple) else value


def _read(text: GivenText, kinds: tuple[Any, ...]) -> Any:
    """Value of a text as TOML has it where an input is a number, true or false, or a list; else the text."""
    if text[:1] in ("[", "{") or not {int, float, bool, Any}.isdisjoint(kinds):
        with suppress(InputError):
            return toml_data(f"value = {text}", "")["value"]
        with suppress(ValueError):
            return float(text)
    return str(text)


def _default_text(field: FieldInfo, unit: UsUnit | None) -> str:
    default = field.get_default(call_default_factory=True)
    return f"{unit.of(default):.6g}" if unit and is_number(default) else _text(default)


def merged(values: Mapping[str, Any], over: Mapping[str, Any]) -> dict[str, Any]:
    """Return inputs with others over them, which also replace the same quantities in the other units."""
    kept = {key: value for key, value in values.items() if not any(same_quantity(key, new) for new in over)}
    return {**kept, **over}


def _advice(key: str, field: FieldInfo, unit: UsUnit | None) -> str:
    meaning = field.description or ""
    if field.is_required():
        return f"give {key}: {meaning}".removesuffix(": ")
    return f"leave {key} out for the default {_default_text(field, unit)} ({meaning})".removesuffix(" ()")


def _input_error(
    case: type[Table], reason: ValidationError, values: Mapping[str, Any], where: Callable[[Key], str]
) -> InputError:
    """Say in the words of this program what pydantic refuses: what was given, what is allowed and what to do."""
    faults: dict[Key, tuple[str, str, str]] = {}
    for error in reason.errors(include_url=False, include_context=False):
        key, table, field, given = _located(case, values, error["loc"])
        if key in faults:  # refused by each of several types
            continue
        last = next((item for item in reversed(key) if isinstance(item, str)), "")
        unit = table.input_named(last)[1]
        if field is not None:
            if error["type"] == "missing":
                unit = us_key(last) if values.get("units") == "us" else None
                last = unit.name if unit else last
                text = f"{where(key[:-1])}no {key_text((*key[:-1], last))}"
            else:
                text = f"{where(key)}{key_text(key)} = {short(error['input'] if given is None else given)}"
            faults[key] = text, f"{last} is {allowed(field, unit)}", _advice(last, field, unit)
        elif unit is not None:
            text = f"{where(key)}{key_text(key)}, and the same quantity in another unit"
            faults[key] = text, "one of them", f"leave {last} or the other one out"
        else:
            inside = key_text(key[:-1])
            text = f"{where(key)}there is no input called {short(last)}{f' in {inside}' if inside else ''}"
            names, advice = _known_inputs(case, table, last, in_us=values.get("units") == "us")
            faults[key] = text, f"the inputs of {inside or case.called()}: {names}", advice
    given_texts, allow, advices = zip(*[*faults.values()][:MAX_REPORTED], strict=True)
    more = [f"and {len(faults) - MAX_REPORTED} more"] if len(faults) > MAX_REPORTED else []
    return InputError(
        "; ".join([*given_texts, *more]), "; ".join(dict.fromkeys(allow)), "; ".join(dict.fromkeys(advices))
    )


def _known_inputs(case: type[Table], table: type[Table], unknown: str, *, in_us: bool) -> tuple[str, str]:
    """Names of the inputs of a table, in a system of units, and advice that names the one most like an unknown one.

    Of many only those that are similar, and the command that lists all.
    """
    known = sorted(table.model_fields, key=OF_REPORT.__contains__)  # the last ones of the list
    us = {name: unit.name for name in known if (unit := us_key(name))}
    shown = [us.get(name, name) for name in known] if in_us else known
    names = similar(unknown, shown if in_us else [*known, *us.values()])
    if len(shown) > MAX_LISTED:
        shown = [*names[:MAX_SIMILAR], f"`flangeway cases {case.called()}` lists all {len(shown)}"]
    return ", ".join(shown), closest(unknown, names)


def _located(case: type[Table], values: Any, location: Key) -> tuple[Key, type[Table], FieldInfo | None, Any]:
    """Path of a fault as it was written, the table it is in, the field, None for unknown keys, and what was given."""
    path: list[str | int] = []
    table, inner, field, is_name = case, table_in(case), None, False
    for item in location:
        if not (isinstance(item, int) or is_name):
            if inner is None or item.startswith(("list[", "dict[")):  # the name of one of several types
                break
            table, field = inner, inner.described_fields().get(item)
            if field is not None:
                inner = table_in(field.annotation)
                is_name = any(get_origin(kind) is dict for kind in alternatives(field.annotation))
            if isinstance(values, Mapping) and item not in values:  # it may be written in US units
                item = next((name for name in values if same_quantity(item, str(name))), item)  # noqa: PLW2901
        else:
            is_name = False
        path.append(item)
        try:
            values = values[item]
        except (KeyError, IndexError, TypeError):
            values = None
    return tuple(path), table, field, values


# --- A case on its mesh and on the mesh with half of its sizes: how much each number changes.


@dataclass(frozen=True)
class Convergence:
    """Results with the sizes of a case and with half of them.

    - `case`: the case.
    - `sizes`: the inputs that were halved, or doubled if they are numbers of cells, with both values.
    - `runs`: both runs, that of the case first.
    """

    case: RunnableCase
    sizes: dict[str, tuple[float, float]]
    runs: tuple[RunResult, RunResult]

    @property
    def converged(self) -> bool:
        """Whether both runs converged."""
        return all(run.status.converged for run in self.runs)

    @property
    def numbers(self) -> dict[str, tuple[float, float]]:
        """Numbers of a row of a campaign by their keys, of both runs; those that only one of them has are left out."""
        coarse, fine = (self.case.row(run) for run in self.runs)
        return {
            key: (value, fine[key])
            for key, value in coarse.items()
            if type(value) is float and type(fine.get(key)) is float
        }

    def to_json(self) -> dict[str, Any]:
        """Return what ``converge.json`` holds: of each number both values and the change, metric."""
        names = ("value", "with_half_the_sizes")
        return {
            "sizes": {key: dict(zip(names, both, strict=True)) for key, both in self.sizes.items()},
            "numbers": {
                key: {**dict(zip(names, (a, b), strict=True)), "change": b - a} for key, (a, b) in self.numbers.items()
            },
            "status": [{"converged": run.status.converged, "message": run.status.message} for run in self.runs],
            "case": self.runs[0].summary["case"],
            "versions": self.runs[0].summary["versions"],
        }


def run_halved(case: RunnableCase, progress: Progress = lambda _: None) -> Convergence:
    """Run a case with its own sizes and with half of them, of all inputs in `HALVING`.

    It is an `InputError` if the inputs make no problem that can be solved, or half of a size is not allowed.
    """
    finer = case.halved_sizes()
    halved = case.from_values({**case.model_dump(exclude_unset=True), **finer})
    halved.check()

    def run(of: RunnableCase, sizes: str) -> RunResult:
        return of.run(lambda sentence: progress(f"{sizes}: {sentence}"))

    runs = run(case, "given sizes"), run(halved, "half of the sizes")
    return Convergence(case, {key: (getattr(case, key), value) for key, value in finer.items()}, runs)
