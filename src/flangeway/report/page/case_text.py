"""The inputs of a case as the text of a case file, and as tables of the page."""

from collections.abc import Iterator, Mapping
from typing import Any

from flangeway.cases.case import Case, RunnableCase, table_in
from flangeway.cases.case_file import FORMAT
from flangeway.cases.case_template import toml_value, write_case_file
from flangeway.report.page.page_tables import Table

LONGEST = 60
"""Letters of a value on the page; longer ones are cut there, the case file has them whole."""


def case_text(case: RunnableCase) -> str:
    """Return a case file that computes a case again: every input that is set, with all digits, defaults too.

    Names of files stand as they were given; in a case file they are read from its own folder. Inputs in tables stand
    there if they are not the defaults.
    """
    if has_tables(case):
        return write_case_file(case)
    lines = [f"flangeway = {FORMAT}", f"case = {toml_value(case.name)}"]
    for key in type(case).model_fields:
        value = getattr(case, key)
        if value is not None:
            lines.append(f"{key} = {toml_value(value)}")
    return "\n".join(lines) + "\n"


def inputs_tables(case: Case) -> list[Table]:
    """Inputs for the page: plain ones with their meanings, and those inside tables that are set, table by table."""
    plain = [
        (key, _plain(getattr(case, key)), field.description or "")
        for key, field in type(case).model_fields.items()
        if table_in(field.annotation) is None
    ]
    found = [Table("Every key bears its unit", ("", "value", "meaning"), tuple(plain), of_words=True)]
    for key, value in case.model_dump(exclude_defaults=True).items():
        if table_in(type(case).model_fields[key].annotation) is None:
            continue
        items = value if isinstance(value, list) else [value]
        for number, item in enumerate(items, 1):
            caption = f"{key}[{number}]" if isinstance(value, list) else key
            found.append(Table(caption, ("", "value"), tuple(_rows(item)), of_words=True))
    return found


def has_tables(case: Case) -> bool:
    """Whether a case has inputs inside of tables, which no command has room for."""
    return any(table_in(field.annotation) is not None for field in type(case).model_fields.values())


def _rows(item: Mapping[str, Any], path: str = "") -> Iterator[tuple[str, str]]:
    """Keys and values of a table, those of tables inside behind a point."""
    for key, value in item.items():
        if isinstance(value, Mapping):
            yield from _rows(value, f"{path}{key}.")
        else:
            yield f"{path}{key}", _plain(value)


def _plain(value: object) -> str:
    if value is None:
        return "–"
    if isinstance(value, list | tuple | Mapping):
        text = toml_value(value)
        return text if len(text) <= LONGEST else f"{text[: LONGEST - 4]} ..."
    return f"{value:.10g}" if isinstance(value, float) else str(value)
