"""The cases by name, and in TOML files: ``case = "wheelset-curve"`` and the inputs of that case as keys."""

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from flangeway.cases.bodies.cook import CookCase
from flangeway.cases.bodies.presets import ContactPatchCase, HertzCase
from flangeway.cases.bodies.two_bodies import TwoBodiesCase
from flangeway.cases.case import RunnableCase, Table, closest, key_text, merged
from flangeway.cases.nested import mapped
from flangeway.cases.rolling.rolling_patch_case import RollingPatchCase
from flangeway.cases.section.section_run import TorsionCase
from flangeway.cases.spatial.spatial_case import SpatialCase
from flangeway.cases.spatial.spatial_presets import CraneWheelCase, CrossedCylindersCase, RollerCase
from flangeway.cases.wheelset.spatial_wheelset_case import SpatialWheelsetCase
from flangeway.cases.wheelset.wheelset_case import WheelsetCurveCase, WheelsetTangentCase
from flangeway.errors import InputError, located, short
from flangeway.system.file_content import is_file
from flangeway.system.toml_file import TomlFile, TomlKind
from flangeway.system.versions import versions
from flangeway.types import Key

CASES: dict[str, type[RunnableCase]] = {
    case.name: case
    for case in (
        *(SpatialWheelsetCase, WheelsetTangentCase, WheelsetCurveCase),
        *(HertzCase, ContactPatchCase, CookCase, TorsionCase, TwoBodiesCase),
        *(CraneWheelCase, RollerCase, CrossedCylindersCase, SpatialCase, RollingPatchCase),
    )
}
"""Types of the cases by name."""

CASE_FILES = {file.stem: file for file in sorted((Path(__file__).parent / "files").glob("*.toml"))}
"""Case files that are distributed with the program, by name; cases of bodies with all their tables."""

FORMAT = 1  # number of the format that this version writes; files of lower numbers are read, higher ones refused
ENDING = ".toml"

FILE_KEYS = ("rail", "wheel", "left_rail", "left_wheel", "section", "file", "pressure_file", "friction_file")
"""Inputs that may name a file; paths in a case file are relative to its folder."""
PROFILE_ENDINGS = (".ban", ".whl", ".prr", ".prw", ".csv", ".dxf", ".mpt")
MESH_ENDINGS = (".msh", ".inp", ".vtu", ".vtk", ".xdmf", ".med", ".bdf", ".nas")
FILE_ENDINGS = (ENDING, ".txt", ".dat", *PROFILE_ENDINGS, *MESH_ENDINGS)


def find_case(name: str) -> type[RunnableCase]:
    """Return the type of the case with a name.

    Raises
    ------
    InputError
        If there is none; the message lists those there are and names the nearest.

    """
    if name in CASE_FILES:
        return _text_of(name).case()[0]
    if name not in CASES:
        names = [*CASES, *CASE_FILES]
        raise InputError(f"there is no case called {name!r}", f"one of: {', '.join(names)}", closest(name, names))
    return CASES[name]


def file_title(name: str) -> str:
    """Title of a case file that is distributed with the program: its first line."""
    return CASE_FILES[name].read_text(encoding="utf-8").partition("\n")[0].removeprefix("# ")


def is_case_file(name: str | Path) -> bool:
    """Whether a name means a case file, one that is distributed with the program too, not a case."""
    path = Path(name)
    return str(name) in CASE_FILES or path.suffix.lower() in (ENDING, *PROFILE_ENDINGS, *MESH_ENDINGS) or is_file(path)


def load_case(name_or_file: str | Path, **settings: Any) -> RunnableCase:
    """Return the case of a name with its defaults, or that of a case file.

    Parameters
    ----------
    name_or_file
        Name of a case, or a TOML file.
    settings
        Inputs that go before those of the file.

    Raises
    ------
    InputError
        If there is no such case or file, or an input is wrong; of files the message names file, line and key.

    """
    return read_case(name_or_file, settings)


def read_case(name_or_file: str | Path, settings: Mapping[str, Any] | None = None) -> RunnableCase:
    """Return a case as `load_case` does.

    - `name_or_file`: name of a case, or a TOML file.
    - `settings`: inputs that go before those of the file. Those inside tables are named by points, items of a list by
      their numbers from 1 or by their ``name``: ``bodies.disc.size_mm``.
    """
    given = dict(settings or {})
    if not is_case_file(name_or_file):
        return _by_name(str(name_or_file), given)
    text = _text_of(name_or_file)
    case, values = text.case()
    inputs = _set(_with_tables(case, resolved(text, values, text.file.parent), given), given)
    replaced = {key.partition(".")[0] for key in given}

    def where(key: Key) -> str:
        return "" if key and key[0] in replaced else text.place(key)

    return case.from_values(inputs, where)


def _by_name(name: str, settings: Mapping[str, Any]) -> RunnableCase:
    case = find_case(name)
    values = _set(_with_tables(case, {}, settings), settings)
    missing = [key for key in case.example if case.model_fields[key].is_required() and key not in values]
    if missing:
        raise InputError(
            f"the case {case.name} without {' and '.join(missing)}",
            f"a case file with {' and '.join(missing)}",
            f"`flangeway init {case.name}` writes one to begin with, `flangeway run {case.name}.toml` computes it",
        )
    return case.from_values(values)


def _text_of(name: str | Path) -> "CaseText":
    """Text of a case file, or of a bundled one by its name; meshes, outlines and profiles are inputs and refused."""
    file = CASE_FILES.get(str(name), Path(name))
    _refuse_other_file(file)
    return CaseText.read(file)


def _refuse_other_file(file: Path) -> None:
    """Refuse meshes, outlines and profiles, which are inputs of a case and no case themselves."""
    ending = file.suffix.lower()
    if ending in MESH_ENDINGS or ending in PROFILE_ENDINGS:
        what, case, key = ("a mesh or a deck", "two-bodies", "file")
        if ending in PROFILE_ENDINGS:
            what, case, key = ("an outline or a profile", "wheelset-tangent", "rail, wheel or file")
        raise InputError(
            f"{file}, which is {what}, not a case",
            "the name of a case, or a case file (.toml), which gives materials, supports, loads and contacts",
            f'name it in a case file: `flangeway init {case}` writes one, {key} = "{file.name}" names it there',
        )


def check_case(case: RunnableCase, file: str | Path | None = None) -> None:
    """Raise `InputError` for what is wrong beyond single values; the message names the file, if one is given."""
    with case.errors_as_written(lambda given: "" if file is None else _text_of(file).place(_key_in(given))):
        case.check()


def _key_in(message: str) -> Key:
    """Key that a message starts with, as `key_text` writes it."""
    path = re.match(r"\w+(?:\[\d+\]|\.\w+)*", message)
    key: list[str | int] = []
    for name, number in re.findall(r"(\w+)(?:\[(\d+)\])?", path[0] if path else ""):
        key += [name] if not number else [name, int(number) - 1]
    return tuple(key)


OF_COMMANDS = {"vary": "campaign", "table": "campaign", "evolution": "damage"}
"""Keys of TOML files that are no cases, and the commands that take them."""


class CaseText(TomlFile):
    """A case file."""

    kind = TomlKind(
        name="case file",
        instead=", or the name of a case",
        get_one="correct the name; `flangeway init NAME` writes a case file",
        lines='lines such as gauge_mm = 1435.0 or rail = "60E1"',
        too_large="give meshes in files of their own",
    )

    def case(self) -> tuple[type[RunnableCase], dict[str, Any]]:
        """Type of the case, and its inputs; an `InputError` if it is a file of another command."""
        for key, command in OF_COMMANDS.items():
            if key in self.data:
                raise InputError(
                    f"{self.place((key,))}{key}, which a file of `flangeway {command}` has",
                    "a case file, whose inputs are the inputs of one case",
                    f"`flangeway {command} {self.file}` computes it",
                )
        name, values = self.name_and_values()
        with located(self.place(("case",))):
            return find_case(name if isinstance(name, str) else short(name)), values

    def name_and_values(self) -> tuple[Any, dict[str, Any]]:
        """Value of the key ``case`` (``model = "spatial"`` is the case of this name), and the inputs."""
        values = dict(self.data)
        self._refuse_other_format(values.pop("flangeway", FORMAT))
        if "case" not in values and values.get("model") == "spatial":
            values["case"] = values.pop("model")
        if "case" not in values:
            raise InputError(
                f"{self.file}: no key case",
                'a line such as case = "wheelset-tangent" at the top',
                "add it; `flangeway cases` lists the names"
                + (", `flangeway section` reads outlines" if "outer" in values or "parts" in values else ""),
            )
        return values.pop("case"), values

    def _refuse_other_format(self, number: Any) -> None:
        place = self.place(("flangeway",))
        if isinstance(number, bool) or not isinstance(number, int) or number < 1:
            raise InputError(
                f"{place}flangeway = {short(number)}", f"the number of the file's format, {FORMAT}", "leave it out"
            )
        if number > FORMAT:
            raise InputError(
                f"{place}flangeway = {short(number)}, a newer format than this version reads",
                f"up to {FORMAT} in flangeway {versions()['flangeway']}",
                "install a newer flangeway, or write the file anew with `flangeway init`",
            )


def resolved(file: TomlFile, values: Mapping[str, Any], folder: Path, above: Key = ()) -> dict[str, Any]:
    """Inputs of a file with the names of other files made independent of the current folder.

    Parameters
    ----------
    file, values
        The file, and inputs in it; those inside tables may be named by points.
    folder
        Its folder, to which names of files are relative.
    above
        Key of the table that the inputs are in.

    Raises
    ------
    InputError
        If a name with the ending of a file, or with a folder, names none.

    """

    def path(key: Key, name: Any) -> Any:
        last = next(str(item) for item in reversed(key) if not isinstance(item, int))
        if last.rpartition(".")[2] not in FILE_KEYS or not isinstance(name, str):
            return name
        if is_file(folder / name):
            return str(folder / name)
        if Path(name).suffix.lower() in FILE_ENDINGS or "/" in name:
            parts = [part for item in key for part in (item.split(".") if isinstance(item, str) else (item,))]
            raise InputError(
                f"{file.place((*above, *parts))}{key_text(key)} = {short(name)}: there is no such file",
                f"a file, its path relative to the case file's folder {folder.resolve()}",
                "correct the path, or copy the file there",
            )
        return name

    return {name: mapped(value, path, (name,)) for name, value in values.items()}


def _with_tables(case: type[RunnableCase], values: dict[str, Any], settings: Mapping[str, Any]) -> dict[str, Any]:
    """Values with the default of each table that settings name."""
    named = {name.partition(".")[0] for name in settings if "." in name}
    defaults = {
        key: case.model_fields[key].get_default(call_default_factory=True) for key in named & {*case.model_fields}
    }
    tables = {
        key: default.model_dump(exclude_unset=True) for key, default in defaults.items() if isinstance(default, Table)
    }
    return tables | values


def _set(values: dict[str, Any], settings: Mapping[str, Any]) -> dict[str, Any]:
    """Return the values with some replaced, those inside tables named by points."""
    changed = merged(values, {name: value for name, value in settings.items() if "." not in name})
    for name, value in settings.items():
        if "." in name:
            _set_inside(changed, name.split("."), value, name)
    return changed


def _set_inside(values: dict[str, Any], path: list[str], value: Any, name: str) -> None:
    place: Any = values
    for number, item in enumerate(path):
        known: dict[str, Any] = {}
        if isinstance(place, list):
            known = {str(n): n - 1 for n in range(1, len(place) + 1)}
            known |= {
                str(entry["name"]): n for n, entry in enumerate(place) if isinstance(entry, dict) and "name" in entry
            }
        elif isinstance(place, dict):
            known = {key: key for key in place}
        last = number == len(path) - 1
        if isinstance(place, dict) and last:
            new = merged(place, {item: value})
            place.clear()
            place.update(new)
            return
        if item not in known or last:
            raise InputError(
                f"--set {name}", f"at {'.'.join(path[:number]) or 'the top'} one of: {', '.join(known) or 'nothing'}",
                "name tables by their keys, and items of lists by their numbers from 1 or their names",
            )  # fmt: skip
        place = place[known[item]]
