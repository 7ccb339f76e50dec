"""A campaign over a damage file: each combination of the values that vary is a strategy."""

from dataclasses import replace
from typing import Any

from pydantic import Field

from flangeway.campaign.campaign import CAMPAIGN_FILE, RANGE_KEYS, grid, values_of
from flangeway.cases.damage_file import DamageFile, DamageInputs
from flangeway.errors import InputError
from flangeway.records import Record, flattened
from flangeway.system.file_content import TomlFile


class DamageCampaignTables(Record):
    """Tables of the file."""

    damage: str
    """a damage file"""
    vary: dict[str, Any] = Field({})
    """lists or ranges of values of keys of the damage file"""

    @classmethod
    def called(cls) -> str:
        """See `Record.called`."""
        return "a campaign with damage; other keys belong into the damage file, or under [vary]"


class DamageCampaign(TomlFile):
    """The file: ``damage``, the name of a damage file, and ``[vary]`` with lists or ranges of its keys."""

    kind = CAMPAIGN_FILE

    def strategies(self) -> dict[str, DamageInputs]:
        """Return the inputs of the damage file as it is, and of all combinations; an `InputError` as of both."""
        tables = DamageCampaignTables.from_values(self.data, self.place)
        given = flattened(tables.vary, RANGE_KEYS)
        varied = {key: values_of(key, values, self.place(("vary", *key.split(".")))) for key, values in given.items()}
        if not varied:
            raise InputError(f"{self.file}: nothing varies", "[vary.inputs] and the like with lists", "add one")
        file = DamageFile.read(self.file.parent / tables.damage)
        strategies = {_name(row): _nested(row) for row in grid(varied, f"{self.file}: ")}
        return replace(file, data={**file.data, "strategies": strategies}).strategies()


def _name(row: dict[str, Any]) -> str:
    """Values with the last parts of their keys: ``friction 0.2, end 4000``."""
    return ", ".join(f"{key.rpartition('.')[2]} {value}" for key, value in row.items())


def _nested(row: dict[str, Any]) -> dict[str, Any]:
    """Tables by keys with points between their parts."""
    nested: dict[str, Any] = {}
    for key, value in row.items():
        *tables, last = key.split(".")
        inner = nested
        for table in tables:
            inner = inner.setdefault(table, {})
        inner[last] = value
    return nested
