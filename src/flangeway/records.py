"""Records: frozen inputs with units, ranges and meanings at their fields, as trees that are TOML, Python and JSON.

A record is a class below `Record` with a field for each input and a sentence on it below the field:

    class Curve(Record):
        radius_m: float
        '''radius of the curve, positive to the left'''

The same class checks the tables of case files, the arguments of scripts and the values of the command line, and makes
reference pages, files to begin with and the JSON schema. Kinds of one thing are classes with a field ``kind``, a
`typing.Literal`; the field that takes them has their union as its type. A kind is also named by its text alone:
``support = "fixed"`` means ``support = { kind = "fixed" }``. Kinds without that field differ in the inputs that they
need: a load is a pressure where ``pressure_MPa`` is written.

What inputs exclude or need each other is declared by `Record.exclusive`, `Record.needed` and `Record.needs`.
"""

import ast
import difflib
import inspect
import math
import sys
from collections import ChainMap
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from functools import cache
from itertools import pairwise
from types import UnionType
from typing import (
    TYPE_CHECKING,
    Annotated,
    Any,
    ClassVar,
    Literal,
    NamedTuple,
    Self,
    TypeAlias,
    Union,
    get_args,
    get_origin,
)

import annotated_types as at
from pydantic import BaseModel, ConfigDict, Strict, ValidationError, model_validator
from pydantic.fields import FieldInfo
from pydantic_core import core_schema

from flangeway.checks import is_number
from flangeway.errors import InputError, short
from flangeway.system.disk_cache import content_key
from flangeway.system.file_content import toml_data
from flangeway.types import Key
from flangeway.units import Units, UsUnit, metric_key, same_quantity, us_key

# --- Types of inputs.


PLAIN_TYPES = {float: "a number {}", int: "a whole number {}", bool: "true or false", str: "a name"}
"""What inputs of one value are called, with their bounds."""
_BOUNDS = ((at.Gt, "gt", "above"), (at.Ge, "ge", "from"), (at.Lt, "lt", "below"), (at.Le, "le", "up to"))

Pair = Annotated[tuple[float, float], Strict(False)]  # two numbers in a list, as files have them
Box = Annotated[tuple[float, float, float, float], Strict(False)]

Positive = Annotated[float, at.Gt(0.0)]
NotNegative = Annotated[float, at.Ge(0.0)]
Fraction = Annotated[float, at.Gt(0.0), at.Le(1.0)]
SolidModulus = Annotated[float, at.Ge(1000.0)]  # of wheels and rails, MPa; plastics have 2000, steel 210 in GPa
PoissonRatio = Annotated[float, at.Gt(-1.0), at.Lt(0.5)]
ElementSize = Annotated[float, at.Ge(1e-6)]
ElementOrder = Annotated[int, at.Ge(1), at.Le(2)]
LengthUnit = Literal["mm", "cm", "m", "in", "ft"]

MAX_LISTED, MAX_SIMILAR = 20, 5  # inputs that a message lists; of more only the similar ones
MIN_LETTERS_OF_PART = 3  # of a word that is looked for inside of others
MAX_REPORTED = 5  # errors in one message; of the others only the number is given
MAX_NUMBER = 1e30  # no length, force or modulus is larger in its unit
TAG = "kind"
"""Field that says which of several kinds a table is."""

InputRow: TypeAlias = tuple[str, str, str, str]
"""Key, default, what is allowed, and meaning of an input."""


class GivenText(str):
    """A value of the command line or of a CSV table: the input's type decides whether it is a number, true, or text."""


# --- Records.


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
                        texts[node.name][key] = " ".join(text.split())
    return texts


if TYPE_CHECKING:  # checkers see the arguments of the fields
    _Base = BaseModel
else:

    class _Checked(type(BaseModel)):
        """Type of records: what is wrong with the arguments of one is an `InputError`."""

        def __call__(cls, **values: Any) -> Any:
            return cls.from_values(values)

    class _Base(BaseModel, metaclass=_Checked):
        pass


class Record(_Base):
    """A group of inputs: a table of a case file. A number is a number, not a text nor a truth value.

    Raises
    ------
    InputError
        If a key is unknown, a value is not allowed, or inputs exclude each other; the message says what is allowed.
    """

    model_config = ConfigDict(defer_build=True, extra="forbid", frozen=True, allow_inf_nan=False, strict=True)

    exclusive: ClassVar[tuple[tuple[str, ...], ...]] = ()  # groups of inputs of which one at most is written
    needed: ClassVar[tuple[tuple[str, ...], ...]] = ()  # groups of inputs of which one at least is written
    needs: ClassVar[tuple[tuple[str, str], ...]] = ()  # inputs before those without which they have no effect

    @classmethod
    def described_fields(cls) -> dict[str, FieldInfo]:
        """Return the inputs with their descriptions, the texts below them in the source.

        They are read when they are first shown: pydantic's ``use_attribute_docstrings`` takes longer for all cases than
        a short run.
        """
        below = ChainMap(*(_texts_below(kind.__module__).get(kind.__name__, {}) for kind in cls.__mro__))
        for key, field in cls.model_fields.items():
            field.description = field.description or below.get(key)
        return cls.model_fields

    @classmethod
    def from_values(cls, values: Mapping[str, Any], where: Callable[[Key], str] = lambda _: "") -> Self:
        """Return the record with some inputs, the others by default.

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
        for key, value in leaves(values):
            if isinstance(value, int | float | GivenText) and _is_huge(value):
                raise InputError(
                    f"{where(key)}{key_text(key)} = {short(value)}", f"numbers up to {MAX_NUMBER:g}", "correct it"
                )
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
            if name not in cls.model_fields or (unit and (name in values or name in metric)):  # unknown, or twice
                metric[key] = value
                continue
            read = _typed(value, cls.model_fields[name])
            metric[name] = unit.to_metric(read) if unit else read
        return metric

    @model_validator(mode="after")
    def _agree(self) -> Self:
        """Refuse inputs that exclude each other, or lack each other."""
        written = {key for key in self.model_fields_set if getattr(self, key) is not None}
        for group in self.exclusive:
            if len(both := [key for key in group if key in written]) > 1:
                raise refused_by_check(" and ".join(both), "one of them", "leave one of them out")
        for group in self.needed:
            if written.isdisjoint(group):
                raise refused_by_check(f"none of {', '.join(group)}", "one of them", f"add one, such as {group[0]}")
        for key, other in self.needs:
            if other not in written and getattr(self, key) != default_of(type(self).model_fields[key]):
                raise refused_by_check(f"{key} without {other}", "both, or none", f"give {other}, or leave {key} out")
        return self

    def __repr_args__(self) -> Iterable[tuple[str | None, Any]]:
        """Inputs that the text of a record has: those that are not the defaults."""
        return [(key, getattr(self, key)) for key in self.changed]

    @property
    def written(self) -> dict[str, Any]:
        """Inputs that were given, as they are, and the kind of one of several."""
        given = {*self.model_fields_set, TAG}
        return {key: getattr(self, key) for key in type(self).model_fields if key in given}

    @property
    def changed(self) -> dict[str, Any]:
        """Inputs that are not the defaults, in tables and lists of plain values: what a case file needs."""
        changed = {}
        for key, field in type(self).model_fields.items():
            value, default = getattr(self, key), default_of(field)
            if value != default or type(value) is not type(default):
                changed[key] = _plain(value, type(default))
        return changed

    def replaced(self, **changes: Any) -> Self:
        """Return it with some inputs changed; of a record inside, those that are not named stay.

        A change is a value, or a mapping of changes of the record that is there.
        """
        inner = {
            key: getattr(self, key).replaced(**value)
            for key, value in changes.items()
            if isinstance(value, Mapping) and isinstance(getattr(self, key), Record)
        }
        return type(self).from_values({**self.written, **changes, **inner})

    @classmethod
    def called(cls) -> str:
        """Return what messages call it."""
        return "the table"

    @classmethod
    def input_named(cls, key: str) -> tuple[str, UsUnit | None]:
        """Name of the input that a key means, and the US unit that the key has; the key itself if there is none."""
        return (key, None) if key in cls.model_fields else metric_key(key, cls.model_fields)

    @classmethod
    def tables_of_inputs(cls, units: Units = "metric") -> list[tuple[str, list[InputRow]]]:
        """Key, default, what is allowed, and meaning of every input; those inside tables apart, by the table's path."""
        return _tables_of_inputs([cls], units, "")


class ByInstance:
    """An object that records take as it is: scripts have it, files name it in another way."""

    @classmethod
    def __get_pydantic_core_schema__(cls, _source: Any, _handler: Any) -> core_schema.CoreSchema:
        """Only an instance is accepted; written out, it is the key of its content."""

        def key(value: Any) -> str:
            return content_key(cls.__name__, value) or repr(value)

        written = core_schema.plain_serializer_function_ser_schema(key)
        return core_schema.is_instance_schema(cls, serialization=written)


# --- What fields accept: alternatives of their types, kinds of records, and both in words.


def alternatives(annotation: Any) -> tuple[Any, ...]:
    """Types of a union, or the one type that there is."""
    if get_origin(annotation) is Annotated:
        return alternatives(get_args(annotation)[0])
    if get_origin(annotation) in (Union, UnionType):
        return tuple(kind for member in get_args(annotation) for kind in alternatives(member))
    return (annotation,)


def records_in(annotation: Any) -> list[type[Record]]:
    """Types of the tables of an input, alone, in a list or by name; empty for plain values."""
    kinds = []
    for kind in alternatives(annotation):
        if isinstance(kind, type) and issubclass(kind, Record):
            kinds.append(kind)
        elif get_origin(kind) in (list, dict, tuple):
            kinds += records_in(get_args(kind)[-1 if get_origin(kind) is dict else 0])
    return kinds


def tables_in(annotation: Any) -> list[list[type[Record]]]:
    """Types of the tables of an input, each kind with a name by itself; those without have one table together."""
    kinds = records_in(annotation)
    unnamed = [kind for kind in kinds if kind_of(kind) is None]
    return [*([unnamed] if unnamed else []), *([kind] for kind in kinds if kind not in unnamed)]


def fields_of(kinds: Sequence[type[Record]]) -> dict[str, FieldInfo]:
    """Described fields of kinds that have one table together."""
    return {key: field for kind in kinds for key, field in kind.described_fields().items()}


def distinguishing(kind: type[Record], kinds: Iterable[type[Record]]) -> list[str]:
    """Needed inputs of a kind that others do not need."""
    needed = [{key for key, field in one.model_fields.items() if field.is_required()} for one in kinds]
    return [
        key for key, field in kind.model_fields.items() if field.is_required() and any(key not in one for one in needed)
    ]


def _tables_of_inputs(kinds: Sequence[type[Record]], units: Units, path: str) -> list[tuple[str, list[InputRow]]]:
    """See `Record.tables_of_inputs`; `path`: that of this table in the case, with a point at the end."""
    rows, inner = [], []
    optional = {key for kind in kinds for key in distinguishing(kind, kinds)}
    for key, field in fields_of(kinds).items():
        unit = us_key(key) if units == "us" else None
        is_needed = field.is_required() and key not in optional
        default = "needed" if is_needed else default_text(field, unit)
        tables = tables_in(field.annotation)
        several = "[]" if any(get_origin(kind) is list for kind in alternatives(field.annotation)) else ""
        for table in tables:
            tag = kind_of(table[0]) if len(tables) > 1 else None
            inner += _tables_of_inputs(table, units, f"{path}{key}{several}.{f'{tag}: ' if tag else ''}")
        words = allowed(field, unit)
        if len(tables) == 1 and are_tables(field.annotation):
            words = f"a table, [{path}{key}{several}]"
            default = default if is_needed else "none"
        rows.append((unit.name if unit else key, default, words, field.description or ""))
    return [(path.rstrip("."), rows), *inner]


def are_tables(annotation: Any) -> bool:
    """Whether an input is a table, or several: no plain value stands for one."""
    kinds = [kind for kind in alternatives(annotation) if kind is not type(None)]
    return bool(records_in(annotation)) and all(records_in(kind) for kind in kinds)


def kind_of(record: type[Record]) -> str | None:
    """Value of the field ``kind`` of a record's type; None of one without kinds."""
    field = record.model_fields.get(TAG)
    return str(get_args(field.annotation)[0]) if field is not None and get_origin(field.annotation) is Literal else None


def default_of(field: FieldInfo) -> Any:
    """Value of an input that is not written; None of one that is needed."""
    return None if field.is_required() else field.get_default(call_default_factory=True)


def allowed(field: FieldInfo, unit: UsUnit | None = None) -> str:
    """Say in words what a field accepts, or its key in a US unit."""
    bounds = [
        f"{word} {(unit.of if unit else float)(getattr(limit, attribute)):g}"
        for kind, attribute, word in _BOUNDS
        for limit in (*field.metadata, *_metadata(field.annotation))
        if isinstance(limit, kind)
    ]
    return " or ".join(dict.fromkeys(_words(field.annotation, " ".join(dict.fromkeys(bounds)))))


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
            items = [" or ".join(_words(member, bounds)) for member in members if member is not ...]
            words.append(f"a list of {items[0]}" if members[-1] is ... else f"[{', '.join(items)}]")
        elif members == (str,):
            words.append("a list of names")
        elif origin in (list, dict):
            inner = " or ".join(_words(members[-1], bounds)).replace("a table with", "tables with")
            words.append(f"{'a list' if origin is list else 'a table'}{f' of {inner}' if inner else ''}")
        elif records_in(kind):
            words += [tag] if (tag := kind_of(kind)) else [f"a table with the keys {', '.join(kind.model_fields)}"]
    return words


# --- Values as they are written.


def leaves(values: Any, key: Key = ()) -> Iterator[tuple[Key, Any]]:
    """Yield the values in tables and lists that are neither, with their paths."""
    items: Iterable[tuple[str | int, Any]] = ()
    if isinstance(values, Mapping):
        items = values.items()
    elif isinstance(values, list | tuple):
        items = enumerate(values)
    else:
        yield key, values
    for name, value in items:
        yield from leaves(value, (*key, name))


def _plain(value: Any, default: type[Any]) -> Any:
    """An input as tables, lists and values; a record has its kind where this is not that of the default."""
    if isinstance(value, Record):
        tag = kind_of(type(value))
        return value.changed if tag is None or type(value) is default else {TAG: tag, **value.changed}
    if isinstance(value, Mapping):
        return {name: _plain(entry, type(None)) for name, entry in value.items()}
    return [_plain(entry, type(None)) for entry in value] if isinstance(value, list | tuple) else value


class InputEntry(NamedTuple):
    """An input of a record: its path, its field, its value, and whether it is the one that is there without it."""

    path: tuple[str, ...]
    field: FieldInfo
    value: Any
    is_default: bool

    @property
    def name(self) -> str:
        """The path with points between its parts."""
        return ".".join(self.path)


def entries_of(record: Record, above: tuple[str, ...] = (), *, is_kind_by_default: bool = True) -> Iterator[InputEntry]:
    """Yield the inputs of a record and of the records in it, one by one; lists of records are one input."""
    for key, field in type(record).described_fields().items():
        value, default, path = getattr(record, key), default_of(field), (*above, key)
        if isinstance(value, Record):
            yield from entries_of(value, path, is_kind_by_default=type(value) is type(default))
        else:
            yield InputEntry(path, field, value, value == default and (key != TAG or is_kind_by_default))


def _is_huge(value: float | GivenText) -> bool:
    """Whether squares and products of a number, also as text, may leave the range of floats."""
    try:
        return MAX_NUMBER < abs(float(value)) < math.inf
    except ValueError:  # a name
        return False
    except OverflowError:  # an integer of hundreds of digits
        return True


def _typed(value: Any, field: FieldInfo) -> Any:
    """A value as the types of an input want it, where that is no guess."""
    kinds = alternatives(field.annotation)
    value = _read(value, kinds) if isinstance(value, GivenText) else value
    if is_number(value) and not isinstance(value, int | float):
        return value.item() if hasattr(value, "item") else float(value)
    records = {kind_of(kind): kind for kind in records_in(field.annotation)}
    if isinstance(value, str) and value in records:
        return {TAG: value}
    inner = next((get_args(kind)[-1] for kind in kinds if get_origin(kind) in (dict, list)), Any)
    if isinstance(value, Mapping) and len(records) > 1 and TAG not in value:
        default = default_of(field)  # its kind; where there is none, the first kind that has all of these inputs
        having = [one for one in records.values() if all(one.input_named(key)[0] in one.model_fields for key in value)]
        fitting = [type(default)] if isinstance(default, Record) else having
        return {TAG: kind_of(fitting[0]), **value} if fitting else value
    if isinstance(value, Mapping) and not records and inner is not Any:
        return {key: _typed(entry, FieldInfo.from_annotation(inner)) for key, entry in value.items()}
    return list(value) if isinstance(value, tuple) else value


def _read(text: GivenText, kinds: tuple[Any, ...]) -> Any:
    """Value of a text as TOML has it where an input is a number, true or false, or a list; else the text."""
    if text[:1] in ("[", "{") or not {int, float, bool, Any}.isdisjoint(kinds):
        with suppress(InputError):
            return toml_data(f"value = {text}", "")["value"]
        with suppress(ValueError):
            return float(text)
    return str(text)


def _text(value: object) -> str:
    if value is None or isinstance(value, bool):
        return "none" if value is None else str(value).lower()
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_text, value))}]"
    return f"{value:.10g}" if isinstance(value, float) else str(value)


def default_text(field: FieldInfo, unit: UsUnit | None = None) -> str:
    """Text of the value of an input that is not written, or of its key in a US unit."""
    default = default_of(field)
    if isinstance(default, Record):
        return kind_of(type(default)) or "a table with its defaults"
    return f"{unit.of(default):.6g}" if unit and is_number(default) else _text(default)


def merged(values: Mapping[str, Any], over: Mapping[str, Any]) -> dict[str, Any]:
    """Return inputs with others over them, which also replace the same quantities in the other units."""
    kept = {key: value for key, value in values.items() if not any(same_quantity(key, new) for new in over)}
    return {**kept, **over}


# --- Paths of inputs, and settings by their endings.


@cache
def paths_of(record: type[Record]) -> tuple[tuple[str, ...], ...]:
    """Paths of all inputs of a record and of the records in it, those of lists and names left out."""
    paths = list[tuple[str, ...]]()
    for key, field in record.model_fields.items():
        several = any(get_origin(kind) in (list, dict) for kind in alternatives(field.annotation))
        kinds = [] if several else records_in(field.annotation)
        paths += [(key,), *((key, *path) for kind in kinds for path in paths_of(kind))]
    return tuple(dict.fromkeys(paths))


@cache
def _paths_by_name(record: type[Record]) -> dict[str, list[tuple[str, ...]]]:
    """Paths by their last names, also as these are in US units, those of fewer tables first."""
    by_name: dict[str, list[tuple[str, ...]]] = {}
    for path in sorted(paths_of(record), key=len):
        unit = us_key(path[-1])
        for last in (path[-1], *([unit.name] if unit else [])):
            by_name.setdefault(last, []).append((*path[:-1], last))
    return by_name


def path_by_ending(record: type[Record], name: str) -> list[str]:
    """Return the path of an input by its ending, ``radius_m`` of ``load.curve.radius_m``; what begins at the top as is.

    Where several paths end so, it is that of the fewest tables: ``rail`` is ``track.rail``, not ``track.left.rail``.

    Raises
    ------
    InputError
        If no path ends so, or several with as few tables do; the message names them.
    """
    parts = name.split(".")
    if record.input_named(parts[0])[0] in record.model_fields:
        return parts
    by_name = _paths_by_name(record)
    ending = [path for path in by_name.get(parts[-1], ()) if [*path[-len(parts) :]] == parts]
    fewest = [path for path in ending if len(path) == len(ending[0])]
    if len(fewest) == 1:
        return [*fewest[0]]
    if fewest:
        choices = ", ".join(".".join(path) for path in fewest)
        raise InputError(f"{name}, the end of several inputs", choices, "write more of the path")
    known = [".".join(path) for last in similar(parts[-1], by_name) for path in by_name[last]][:MAX_SIMILAR]
    everything = f"`flangeway cases {record.called()}` lists all {len(paths_of(record))}"
    raise InputError(
        f"there is no input called {short(name)}",
        f"the inputs of {record.called()}: {', '.join([*known, everything])}",
        f"did you mean {known[0]}?" if known else "choose one of these",
    )


def flattened(values: Mapping[str, Any], leaves_too: Collection[str] = (), above: str = "") -> dict[str, Any]:
    """Return inputs inside tables by their paths, ``bodies.disc.size_mm``.

    - `leaves_too`: keys of tables that are values themselves, such as ``from`` of ranges.
    """
    by_path: dict[str, Any] = {}
    for key, value in values.items():
        if isinstance(value, Mapping) and value and not set(value) & {*leaves_too}:
            by_path |= flattened(value, leaves_too, f"{above}{key}.")
        else:
            by_path[f"{above}{key}"] = value
    return by_path


def with_settings(record: type[Record], values: Mapping[str, Any], settings: Mapping[str, Any]) -> dict[str, Any]:
    """Return inputs with settings over them.

    - `values`: tables and lists of inputs.
    - `settings`: values by paths or their endings, see `path_by_ending`; items of lists by their numbers from 1, or
      their ``name``: ``bodies.disc.size_mm``.
    """
    changed, spelled = dict(values), dict[str, list[str]]()
    for name, value in settings.items():
        path = path_by_ending(record, name)
        for other, before in spelled.items():
            if before == path or (before[:-1] == path[:-1] and same_quantity(before[-1], path[-1])):
                raise InputError(f"{name} and {other} for the same input", "one of them", f"leave {name} out")
        spelled[name] = path
        _set(changed, record, path, value, name)
    return changed


def _set(table: Any, record: type[Record] | None, path: list[str], value: Any, name: str, above: str = "") -> None:
    """Replace a value below a table or a list; `above` is the path to it, for the message."""
    item, *inner = path
    known: dict[str, Any] = table if isinstance(table, dict) else {}
    if isinstance(table, list):
        known = {str(number): entry for number, entry in enumerate(table, 1)}
        known |= {str(entry["name"]): entry for entry in table if isinstance(entry, dict) and "name" in entry}
    if isinstance(table, dict) and not inner:
        changed = merged(table, {item: value})
        table.clear()
        table.update(changed)
        return
    field = None if record is None else record.model_fields.get(item)
    kinds = [] if field is None else records_in(field.annotation)
    if isinstance(table, dict) and kinds and not isinstance(table.get(item), list):
        there, default = table.get(item), default_of(field) if field is not None else None
        there = default if there is None and isinstance(default, Record) else there
        if isinstance(there, Record):
            there = there.written
        elif isinstance(there, str):  # a kind by its name, or what a table needs alone
            needed = next((key for kind in kinds for key, one in kind.model_fields.items() if one.is_required()), TAG)
            there = {TAG if there in map(kind_of, kinds) else needed: there}
        known[item] = dict(there) if isinstance(there, Mapping) else {}
    if item not in known or not inner:
        names = [*known] if record is None or isinstance(table, list) else [*record.model_fields]
        advice = "name tables by their keys, and items of lists by their numbers from 1 or their names"
        raise InputError(
            f"--set {name}", f"at {above or 'the top'} one of: {', '.join(names) or 'nothing'}",
            closest(item, names) if similar(item, names) else advice,
        )  # fmt: skip
    kind = next((kind for kind in kinds if inner[0] in kind.model_fields), None)
    if isinstance(table, list):
        kind = record
    _set(known[item], kind, inner, value, name, f"{above}.{item}".removeprefix("."))


# --- Messages.


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


def _advice(key: str, field: FieldInfo, unit: UsUnit | None) -> str:
    meaning = field.description or ""
    if field.is_required():
        return f"give {key}: {meaning}".removesuffix(": ")
    return f"leave {key} out for the default {default_text(field, unit)} ({meaning})".removesuffix(" ()")


def _input_error(
    record: type[Record], reason: ValidationError, values: Mapping[str, Any], where: Callable[[Key], str]
) -> InputError:
    """Say in the words of this program what pydantic refuses: what was given, what is allowed and what to do."""
    faults: dict[Key, tuple[str, str, str]] = {}
    for error in reason.errors(include_url=False):
        if (located := _located(record, values, error["loc"])) is None:  # it is another one of several kinds
            continue
        key, kinds, field, given = located
        table = kinds[0]
        if key in faults or _is_of_another_type(error, field, given):  # refused by each of several types
            continue
        if len(faults) >= MAX_REPORTED:  # of the others only the number is given
            faults[key] = "", "", ""
            continue
        last = next((item for item in reversed(key) if isinstance(item, str)), "")
        unit = table.input_named(last)[1]
        if error["type"] == "value_error":  # of what excludes each other, or of a check of the record
            faults[key] = _of_check(error, where(key), key)
        elif field is not None:
            text = f"{where(key)}{key_text(key)} = {short(error['input'] if given is None else given)}"
            if error["type"] == "missing":
                text = f"{where(key[:-1])}no {key_text(key)}"
            advice = "correct it" if isinstance(key[-1], int) else _advice(key_text(key), field, unit)
            faults[key] = text, f"{last} is {allowed(field, unit)}", advice
            if error["type"] in ("union_tag_invalid", "union_tag_not_found") and isinstance(given, Mapping):
                text = f"{where((*key, TAG))}{key_text((*key, TAG))} = {short(given.get(TAG, ''))}"
                faults[key] = text, f"{TAG} is {allowed(field, unit)}", f"give {last}.{TAG}"
            if error["type"] == "missing" and kind_of(table) is None and last in distinguishing(table, kinds):
                choices = dict.fromkeys(choice for kind in kinds for choice in distinguishing(kind, kinds))
                text = f"{where(key[:-1])}{key_text(key[:-1])} without {', '.join(choices)}"
                faults[key] = text, "one of them", "add one of them"
        elif unit is not None:
            text = f"{where(key)}{key_text(key)}, and the same quantity in another unit"
            faults[key] = text, "one of them", f"leave {last} or the other one out"
        else:
            faults[key] = _of_unknown(record, kinds, key, where(key))
    given_texts, allow, advices = zip(*[*faults.values()][:MAX_REPORTED], strict=True)
    more = [f"and {len(faults) - MAX_REPORTED} more"] if len(faults) > MAX_REPORTED else []
    return InputError(
        "; ".join([*given_texts, *more]), "; ".join(dict.fromkeys(allow)), "; ".join(dict.fromkeys(advices))
    )


def _is_of_another_type(error: Any, field: FieldInfo | None, given: Any) -> bool:
    """Whether a plain type refuses a table where a table's type is allowed as well."""
    if field is None or not records_in(field.annotation) or not isinstance(given, Mapping):
        return False
    of_record = ("model_type", "union_tag_invalid", "union_tag_not_found", "model_attributes_type")
    return error["type"] not in ("missing", "value_error", *of_record)


def _of_check(error: Any, place: str, key: Key) -> tuple[str, str, str]:
    reason = error["ctx"]["error"]
    above = f"{key_text(key)}: " if key else ""
    return f"{place}{above}{reason.given}", reason.allowed, reason.advice


class _RefusedError(InputError, ValueError):
    """An `InputError` that pydantic takes for one of its own inside of the checks of a record."""


def refused_by_check(given: str, allow: str, advice: str) -> InputError:
    """Error that a check of a record raises; the reader puts file and line before it."""
    return _RefusedError(given, allow, advice)


def _of_unknown(record: type[Record], kinds: list[type[Record]], key: Key, place: str) -> tuple[str, str, str]:
    """Unknown inputs: the kinds that have it, or names of those that are similar; of a small table all."""
    table, *others = kinds
    inside, last = key_text(key[:-1]), str(key[-1])
    having = [str(kind_of(kind)) for kind in others if last in kind.model_fields]
    if having and kind_of(table) is None:
        sibling = next(kind for kind in others if last in kind.model_fields)
        own = " or ".join(key for key in table.model_fields if key not in sibling.model_fields)
        return f"{place}{inside}: {last} does not go with {own}", "one of them", "leave one of them out"
    if having:
        advice = f"leave {last} out, or give {inside}.{TAG} = {having[0]}"
        return f"{place}{key_text(key)}: only {' and '.join(having)} have one", f"{last} of {', '.join(having)}", advice
    text = f"{place}there is no input called {short(last)}{f' in {inside}' if inside else ''}"
    elsewhere: list[Key] = [(*key[:-1], *path) for path in _paths_by_name(table).get(last, ())]
    elsewhere = elsewhere or [*_paths_by_name(record).get(last, ())]
    known = [*table.model_fields]
    us_names = [unit.name for name in known if (unit := us_key(name))]
    names = similar(last, [*known, *us_names])
    advice = f"did you mean {key_text(elsewhere[0])}?" if elsewhere else closest(last, names or known)
    if len(known) > MAX_LISTED:
        known = [*names[:MAX_SIMILAR], f"`flangeway cases {record.called()}` lists all {len(known)}"]
    return text, f"the inputs of {inside or record.called()}: {', '.join(known)}", advice


def _nearest_kind(kinds: list[type[Record]], values: Any) -> type[Record]:
    """Kind that has most of the written inputs and lacks least of what it needs."""
    given = values if isinstance(values, Mapping) else {}

    def fit(kind: type[Record]) -> tuple[int, int]:
        names = {kind.input_named(str(key))[0] for key in given}
        return len(names & kind.model_fields.keys()), -len({*distinguishing(kind, kinds)} - names)

    return max(kinds, key=fit)


def _located(
    record: type[Record], values: Any, location: Key
) -> tuple[Key, list[type[Record]], FieldInfo | None, Any] | None:
    """Path of a fault as it was written, the table that it is in, the field, None for unknown keys, and what was given.

    Behind the table are the other kinds that could be in its place. None of a kind that is not the one which was meant.
    """
    path: list[str | int] = []
    tables, inner, field, is_name = [record], [record], None, False
    for item in location:
        if isinstance(item, int) or is_name:
            is_name = False
        else:
            name = item.removesuffix("]").rpartition(", ")[2]  # also of function-after[_agree(), WheelFile]
            tagged = [kind for kind in inner if name in (kind_of(kind), kind.__name__)]
            if path and field is not None and (tagged or item.startswith(_LABELS) or item in _TYPES):
                unnamed = [kind for kind in inner if kind_of(kind) is None]
                if tagged and kind_of(tagged[0]) is None and tagged[0] is not _nearest_kind(unnamed, values):
                    return None
                inner = [*tagged, *(kind for kind in inner if kind not in tagged)]
                continue  # the name of one of several types
            if not inner:
                break
            tables = inner
            field = tables[0].described_fields().get(item)
            if field is not None:
                inner = records_in(field.annotation)
                is_name = any(get_origin(kind) is dict for kind in alternatives(field.annotation))
            if isinstance(values, Mapping) and item not in values:  # it may be written in US units
                item = next((name for name in values if same_quantity(item, str(name))), item)  # noqa: PLW2901
        path.append(item)
        try:
            values = values[item]
        except (KeyError, IndexError, TypeError):
            values = None
    return tuple(path), tables, field, values


_LABELS = ("list[", "dict[", "is-instance[")
_TYPES = ("float", "int", "str", "bool", "tuple", "constrained-str", "constrained-float", "constrained-int")
"""What pydantic calls plain types in the places of errors."""
