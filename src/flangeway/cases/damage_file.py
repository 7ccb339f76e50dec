"""A file of what a collective does to profiles: ``flangeway damage FILE``."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Annotated, Any, Literal

import annotated_types as at
from pydantic import ConfigDict, Field

from flangeway.cases.case_file import resolved
from flangeway.cases.wheelset.wheelset_case import Wheelset
from flangeway.errors import InputError, located
from flangeway.railway.damage.collective import COLLECTIVES, Collective, RunningState, parts_of
from flangeway.railway.damage.evolution import Evolution, EvolutionSettings
from flangeway.railway.damage.wear_laws import ArchardLaw, EnergyLaw, UsfdLaw
from flangeway.railway.track.wheelset_problem import ROLES
from flangeway.records import TAG, Record, flattened, merged, path_by_ending, require_known, with_settings
from flangeway.system.file_content import TomlFile, TomlKind
from flangeway.types import Key
from flangeway.units import metric_key

AnyLaw = Annotated[ArchardLaw | UsfdLaw | EnergyLaw, Field(discriminator=TAG)]
STRATEGY_NAME = re.compile(r"[\w-][\w ,.-]*")
"""Names of strategies are those of folders as well."""


class StateTable(Record):
    """A state of the collective; all other keys are inputs of the case ``wheelset`` that it has beside those of all.

    An input ``[first, last]`` runs over this range, see `flangeway.railway.damage.collective.parts_of`.
    """

    model_config = ConfigDict(extra="allow")

    share: float
    """fraction of the distance; all shares sum to 1"""
    name: str | None = None
    """name of the state (default: its number)"""
    parts: Annotated[int, at.Ge(1), at.Le(1000)] = 1
    """equal parts of its ranges, each computed in its middle"""


class WearTables(Record):
    """Tables of the wear laws, with their constants."""

    wheel: AnyLaw | None = None
    """wear law of the wheels; without it they keep their profile"""
    rail: AnyLaw | None = None
    """wear law of the rails; without it they keep their profile"""


class DamageTables(Record):
    """Tables of the file."""

    collective: str | None = None
    """bundled collective, instead of states"""
    sides: Literal["mean", "separate"] = "mean"
    """whether left and right profiles wear alike, as in curves of both hands, or each for itself"""
    inputs: dict[str, Any] = Field({})
    """inputs of the case wheelset that all states share"""
    states: Annotated[list[StateTable], at.MinLen(1)] | None = None
    """states of the collective"""
    evolution: EvolutionSettings
    """how far the profiles wear, by which steps, and at which limits it ends"""
    wear: WearTables = Field(WearTables())
    """wear laws of wheels and rails"""
    strategies: dict[str, dict[str, Any]] = Field({})
    """what other strategies change, by their names: tables and keys of this file"""

    exclusive = needed = (("collective", "states"),)


@dataclass(frozen=True, eq=False)
class DamageInputs:
    """What a file of this kind gives.

    - `name`: of the file.
    - `evolution`: ready to run.
    - `collective`: name of the bundled collective, which is assumed; empty: states of the file.
    - `inputs`: shared by all states.
    - `changes`: what a strategy changes, key by key.
    """

    name: str
    evolution: Evolution
    collective: str
    inputs: Mapping[str, Any]
    changes: Sequence[str] = ()


@dataclass(frozen=True)
class DamageFile(TomlFile):
    """The file: ``[inputs]`` of the case ``wheelset``, states, ``[evolution]``, ``[wear.wheel]``.

    - `strategy`: name of the strategy whose changes are in the data; empty: the file as it is.
    - `changed_inputs`: inputs of the strategy, which all states have in the place of their own.
    """

    strategy: str = ""
    changed_inputs: Mapping[str, Any] = field(default_factory=dict)

    kind = TomlKind(
        name="damage file",
        instead="",
        get_one="correct the name",
        lines='lines such as collective = "mixed-line", tables such as [wear.wheel]',
        too_large="give fewer states",
    )

    def strategies(self) -> dict[str, DamageInputs]:
        """Return the inputs of the file as it is, by its name, and those of its strategies."""
        name = self.file.stem
        strategies = {name: self.damage()}
        for other, changes in self.data.get("strategies", {}).items():
            if not STRATEGY_NAME.fullmatch(other) or other == name:
                raise InputError(
                    f"{self.place(('strategies', other))}the strategy {other!r}",
                    f"letters, digits, spaces and - _ , . and not {name}, which is the file as it is",
                    "give it another name: it is that of its folder",
                )
            data = _merged(self.data, {key: value for key, value in changes.items() if key != "inputs"})
            data.pop("strategies")
            file = replace(self, data=data, strategy=other, changed_inputs=changes.get("inputs", {}))
            lines = [f"{path} = {value}" for path, value in flattened(changes).items() if value != {}]
            strategies[other] = replace(file.damage(), name=other, changes=lines)
        return strategies

    def place(self, key: Key) -> str:
        """File and line of a key; in a strategy those of its change."""
        return super().place(("strategies", self.strategy, *key) if self.strategy else key)

    def damage(self) -> DamageInputs:
        """Check all of it; an `InputError` names file, line, key, what is allowed and what to do."""
        tables, name = DamageTables.from_values(self.data, self.place), self.data.get("collective", "")
        inputs = self._paths(tables.inputs, "inputs")
        if name:
            with located(self.place(("collective",))):
                require_known("collective", name, COLLECTIVES)
        # a bundled state gives its own track, speed and friction; inputs of the file the rest
        for bundled in COLLECTIVES.get(name, ()):
            for key in flattened(tables.inputs):
                if metric_key(".".join(path_by_ending(Wheelset, key)), bundled)[0] not in bundled:
                    continue
                place = self.place(("inputs", *key.split(".")))
                raise InputError(
                    f"{place}{key} with a bundled collective, whose states have their own",
                    "other inputs, or [[states]] in the place of collective",
                    f"remove {key}, or write the states into the file",
                )
        given = COLLECTIVES.get(name) or [
            self._paths(state.model_extra or {}, "states", number - 1)
            | {"name": state.name or f"state {number}", "share": state.share, "parts": state.parts}
            for number, state in enumerate(tables.states or (), 1)
        ]
        states = []
        for number, state in enumerate(given):
            with located(self.place(("states", number) if tables.states else ("collective",))):
                parts = parts_of(state)
            states += [self._state(merged(inputs, part), number if tables.states else None) for part in parts]
        laws = {role: law.evaluated for role in ROLES if (law := getattr(tables.wear, role)) is not None}
        with located(f"{self.file}: "):
            collective = Collective(states, tables.sides == "separate")
            evolution = Evolution(collective, laws, tables.evolution)
        return DamageInputs(self.file.stem, evolution, name, inputs)

    def _state(self, values: dict[str, Any], number: int | None) -> RunningState:
        """A state by its name, its share and its inputs; that of a number in the file."""
        name, share = values.pop("name"), values.pop("share")
        location = self.place(("inputs",) if number is None or self.changed_inputs else ("states", number))
        with located(f"{location}{name}: "):
            inputs = merged(values, self._paths(self.changed_inputs, "inputs"))
            case = Wheelset.from_values(with_settings(Wheelset, {}, inputs))
            if case.contact.kind == "plane":
                raise InputError("contact.kind = plane", "spatial: wear needs cells along the rail", "leave it out")
            return RunningState(name, share, case)

    def _paths(self, inputs: Mapping[str, Any], *above: str | int) -> dict[str, Any]:
        """Inputs of a wheelset by their whole paths, in whatever tables and by whatever endings they are written."""
        written = flattened(self._resolved(inputs, *above))
        with located(self.place(above)):
            return {".".join(path_by_ending(Wheelset, name)): value for name, value in written.items()}

    def _resolved(self, inputs: Mapping[str, Any], *above: str | int) -> dict[str, Any]:
        """Inputs with the names of files that are relative to this one independent of the current folder."""
        return resolved(self, inputs, self.file.parent.resolve(), above)


def _merged(tables: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """Return tables with changes inside of them; a wear law with its name takes the place of the other law."""
    inner = {
        key: _merged(tables.get(key, {}), value) if isinstance(value, Mapping) and TAG not in value else value
        for key, value in changes.items()
    }
    return merged(tables, inner)
