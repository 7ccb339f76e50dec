"""A file of what a collective does to profiles: ``flangeway damage FILE``."""

from collections.abc import Mapping
from dataclasses import MISSING, dataclass, fields
from typing import Any

from flangeway.cases.case import closest
from flangeway.cases.case_file import FILE_KEYS
from flangeway.cases.wheelset.spatial_wheelset_case import SpatialWheelsetCase
from flangeway.errors import InputError, short
from flangeway.railway.damage.collective import COLLECTIVES, Collective, RunningState
from flangeway.railway.damage.evolution import Evolution, EvolutionSettings
from flangeway.railway.damage.wear_laws import ArchardLaw, EnergyLaw, PerPatch, UsfdLaw, WearLaw
from flangeway.railway.track.discretisation import ROLES, Role
from flangeway.system.file_content import is_file
from flangeway.system.toml_file import TomlFile, TomlKind
from flangeway.types import Key

LAWS: dict[str, type[Any]] = {"archard": ArchardLaw, "usfd": UsfdLaw, "energy": EnergyLaw}
KEYS = ("collective", "sides", "inputs", "states", "evolution", "wear", "limits")
SIDES_ALLOWED = ("mean", "separate")


@dataclass(frozen=True, eq=False)
class DamageInputs:
    """What a file of this kind gives.

    - `name`: of the file.
    - `evolution`: ready to run.
    - `collective`: name of the bundled collective, which is assumed; empty: states of the file.
    - `inputs`: shared by all states.
    """

    name: str
    evolution: Evolution
    collective: str
    inputs: Mapping[str, Any]


class DamageFile(TomlFile):
    """The file: ``[inputs]`` of the case ``wheelset``, states, ``[evolution]``, ``[wear.wheel]``, ``[limits]``."""

    kind = TomlKind(
        name="damage file",
        instead="",
        get_one="correct the name",
        lines='lines such as collective = "mixed-line", tables such as [wear.wheel]',
        too_large="give fewer states",
    )

    def damage(self) -> DamageInputs:
        """Check all of it; an `InputError` names file, line, key, what is allowed and what to do."""
        self._refuse_unknown((), self.data, KEYS)
        inputs = {
            key: self._resolved(value) if key in FILE_KEYS else value for key, value in self._table("inputs").items()
        }
        name = self.data.get("collective", "")
        states = self.data.get("states", [])
        if bool(name) == bool(states) or not isinstance(states, list):
            raise InputError(
                f"{self.file}: {'both a' if name else 'no'} collective and states",
                f"collective, one of {', '.join(COLLECTIVES)}, or [[states]] with share and inputs",
                "give one of both",
            )
        if name and name not in COLLECTIVES:
            raise InputError(f"{self.place(('collective',))}{short(name)}", ", ".join(COLLECTIVES), "choose one")
        sides = self.data.get("sides", "mean")
        if sides not in SIDES_ALLOWED:
            raise InputError(f"{self.place(('sides',))}{short(sides)}", ", ".join(SIDES_ALLOWED), "choose one")
        running = [self._state(number, inputs, dict(given)) for number, given in enumerate(states)]
        # a bundled state gives its own track, speed and friction; inputs of the file the rest
        running += [
            self._bundled(number, inputs, each.values, each.share)
            for number, each in enumerate(COLLECTIVES.get(name, ()))
        ]
        try:
            collective = Collective(running, sides == "separate")
            settings = EvolutionSettings(**self._known("evolution", EvolutionSettings), limits=self._table("limits"))
            evolution = Evolution(collective, self._laws(), settings)
        except InputError as reason:
            raise InputError(f"{self.file}: {reason.given}", reason.allowed, reason.advice) from reason
        return DamageInputs(self.file.stem, evolution, name, inputs)

    def _state(self, number: int, inputs: Mapping[str, Any], given: dict[str, Any]) -> RunningState:
        key: Key = ("states", number)
        share, name = given.pop("share", None), str(given.pop("name", f"state {number + 1}"))
        if isinstance(share, bool) or not isinstance(share, int | float):
            raise InputError(f"{self.place(key)}share = {short(share)}", "a number; all shares sum to 1", "give share")
        return self._running(name, float(share), {**inputs, **given}, key)

    def _bundled(self, number: int, inputs: Mapping[str, Any], values: Mapping[str, Any], share: float) -> RunningState:
        both = sorted(inputs.keys() & values.keys())
        if both:
            raise InputError(
                f"{self.place(('inputs', both[0]))}{both[0]} with a bundled collective, whose states have their own",
                "other inputs, or [[states]] in the place of collective",
                f"remove {both[0]}, or write the states into the file",
            )
        name = COLLECTIVES[self.data["collective"]][number].name
        return self._running(name, share, {**inputs, **values}, ("inputs",))

    def _running(self, name: str, share: float, values: Mapping[str, Any], key: Key) -> RunningState:
        where = self.place(key)
        try:
            case = SpatialWheelsetCase.from_values(values)
            return RunningState(name, share, case.problem(), case.spatial_model())
        except InputError as reason:
            raise InputError(f"{where}{name}: {reason.given}", reason.allowed, reason.advice) from reason

    def _laws(self) -> dict[Role, WearLaw]:
        wear = self._table("wear")
        self._refuse_unknown(("wear",), wear, ROLES)
        laws: dict[Role, WearLaw] = {}
        for role in ROLES:
            if role not in wear:
                continue
            given = dict(wear[role]) if isinstance(wear[role], dict) else {}
            law, per_patch = given.pop("law", None), given.pop("per_patch", False)
            if law not in LAWS:
                raise InputError(f"{self.place(('wear', role))}law = {short(law)}", ", ".join(LAWS), "name a law")
            kind = LAWS[law]
            self._refuse_unknown(("wear", role), given, tuple(each.name for each in fields(kind)))
            missing = [each.name for each in fields(kind) if each.default is MISSING and each.name not in given]
            if missing:
                raise InputError(
                    f"{self.place(('wear', role))}law = {law} without {' and '.join(missing)}",
                    f"the keys {', '.join(each.name for each in fields(kind))}",
                    f"give {missing[0]}",
                )
            laws[role] = PerPatch(kind(**given)) if per_patch else kind(**given)
        return laws

    def _known(self, table: str, kind: type[Any]) -> dict[str, Any]:
        given = self._table(table)
        self._refuse_unknown((table,), given, tuple(each.name for each in fields(kind) if each.name != "limits"))
        for key, value in given.items():
            if isinstance(value, bool) or not isinstance(value, int | float):
                raise InputError(f"{self.place((table, key))}{key} = {short(value)}", "a number", "correct it")
        if "end" not in given:
            raise InputError(
                f"{self.file}: no end under [{table}]", "a distance in km, or axles", f"add end to [{table}]"
            )
        return {key: float(value) for key, value in given.items()}

    def _table(self, name: str) -> dict[str, Any]:
        found = self.data.get(name, {})
        if not isinstance(found, dict):
            raise InputError(f"{self.place((name,))}{name} = {short(found)}", f"a table [{name}]", "correct it")
        return found

    def _refuse_unknown(self, table: Key, given: Mapping[str, Any], allowed: tuple[str, ...]) -> None:
        for key in given:
            if key not in allowed:
                raise InputError(f"{self.place((*table, key))}{key}", ", ".join(allowed), closest(key, list(allowed)))

    def _resolved(self, value: Any) -> Any:
        """Make the name of a file relative to this one independent of the current folder."""
        path = self.file.parent / str(value)
        return str(path.resolve()) if is_file(path) else value
