"""A campaign over a damage file: each combination of the values that vary is a strategy."""

from dataclasses import replace
from typing import Any

from flangeway.campaign.campaign import CAMPAIGN_FILE
from flangeway.campaign.varying import flattened, grid, values_of
from flangeway.cases.damage.damage_file import DamageFile, DamageInputs
from flangeway.errors import InputError
from flangeway.system.toml_file import TomlFile

KEYS = ("damage", "vary")


class DamageCampaign(TomlFile):
    """The file: ``damage``, the name of a damage file, and ``[vary]`` with lists or ranges of its keys."""

    kind = CAMPAIGN_FILE

    def strategies(self) -> dict[str, DamageInputs]:
        """Return the inputs of the damage file as it is, and of all combinations; an `InputError` as of both."""
        for key in self.data:
            if key not in KEYS:
                raise InputError(
                    f"{self.place((key,))}{key} in a campaign with damage",
                    f"the keys {', '.join(KEYS)}",
                    f"write {key} into the damage file, or vary it",
                )
        given = flattened(self.data.get("vary", {}))
        varied = {key: values_of(key, values, self.place(("vary", *key.split(".")))) for key, values in given.items()}
        if not varied:
            raise InputError(f"{self.file}: nothing varies", "[vary.inputs] and the like with lists", "add one")
        file = DamageFile.read(self.file.parent / str(self.data["damage"]))
        strategies = {_name(row): _nested(row) for row in grid(varied, f"{self.file}: ")}
        return replace(file, data={**file.data, "strategies": strategies}).strategies()


def _name(row: dict[str, Any]) -> str:
    """Values with the last parts of their keys: ``friction 0.2, end 4000``."""
    return ", ".join(f"{key.rpartition('.')[2]} {value}" for key, value in row.items())


def _nested(row: dict[str, Any]) -> dict[str, Any]:
    """Tables by keys with points between their parts."""
    found: dict[str, Any] = {}
    for key, value in row.items():
        *tables, last = key.split(".")
        inner = found
        for table in tables:
            inner = inner.setdefault(table, {})
        inner[last] = value
    return found
