"""Identity of cases by the content of their inputs, and of the bodies that several cases share."""

import hashlib
import json
from collections.abc import Collection
from pathlib import Path
from typing import Any

from flangeway.cases.case import OF_REPORT, RunnableCase
from flangeway.cases.case_file import FILE_KEYS
from flangeway.cases.nested import mapped
from flangeway.railway.profiles.formats.slice_files import files_of
from flangeway.system.file_content import is_file
from flangeway.types import Key

MAX_PREPARED = 3
"""Bodies that a process keeps prepared; those of a wheelset take some hundred megabytes."""


def case_content(case: RunnableCase, without: Collection[str] = ()) -> dict[str, Any]:
    """Return the inputs of a case, files by their content: their folder does not matter.

    - `without`: inputs to leave out besides those of the report.
    """
    values = case.model_dump(mode="json", exclude={*OF_REPORT, *without})

    def by_content(key: Key, value: Any) -> Any:
        return _file_hash(value) if key[-1] in FILE_KEYS and isinstance(value, str) else value

    return {"case": case.name, **mapped(values, by_content)}


def bodies_key(case: RunnableCase) -> str:
    """Return a hash of the inputs that shape the bodies: cases that share it share their `prepared` bodies."""
    return hash_of(case_content(case, case.position_keys))


def hash_of(value: Any) -> str:
    """Return a hash of tables, lists, numbers and texts."""
    text = json.dumps(value, sort_keys=True, ensure_ascii=False)
    return hashlib.sha256(text.encode()).hexdigest()


def _file_hash(name: str) -> str:
    path = Path(name)
    if not is_file(path):
        return name
    content = [file.read_bytes() for file in files_of(path) if is_file(file)]
    return f"sha256 {hashlib.sha256(b''.join(content)).hexdigest()}"
