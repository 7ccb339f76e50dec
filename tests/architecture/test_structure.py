"""The structure of the package: the number of files in a folder, one name for one thing, and no record twice."""

import ast
from collections import Counter

from tests.architecture.conftest import MODULES, PACKAGE, TREES

MAX_FILES = 20
"""Modules in one folder, ``__init__.py`` not counted."""
SHARED_FIELDS, MAX_ALIKE = 5, 16
"""Fields of one name that make two dataclasses the same record, and pairs of such records that are left (goal: 0)."""


def test_a_folder_has_at_most_20_modules() -> None:
    """A reader can overlook each folder."""
    counts = Counter(str(path.parent.relative_to(PACKAGE)) for path in MODULES.values() if path.stem != "__init__")
    assert {folder: count for folder, count in counts.items() if count > MAX_FILES} == {}


def test_base_names_of_modules_are_unique() -> None:
    """Two modules of one name would be two things that a reader has to distinguish."""
    counts = Counter(path.stem for path in MODULES.values() if path.stem != "__init__")
    assert [name for name, count in counts.items() if count > 1] == []


def test_public_class_names_are_unique() -> None:
    """A public class is the only one of its name."""
    counts = Counter(
        node.name
        for tree in TREES.values()
        for node in ast.walk(tree)
        if isinstance(node, ast.ClassDef) and not node.name.startswith("_")
    )
    assert [name for name, count in counts.items() if count > 1] == []


def test_no_further_dataclasses_share_five_fields() -> None:
    """Two records with five fields of the same name would be one thing written twice."""
    fields = {
        f"{module}.{node.name}": {
            item.target.id
            for item in node.body
            if isinstance(item, ast.AnnAssign) and isinstance(item.target, ast.Name)
        }
        for module, tree in TREES.items()
        for node in ast.walk(tree)
        if isinstance(node, ast.ClassDef) and any("dataclass" in ast.unparse(each) for each in node.decorator_list)
    }
    names = sorted(fields)
    shared = {
        (first, second): sorted(fields[first] & fields[second])
        for number, first in enumerate(names)
        for second in names[:number]
        if len(fields[first] & fields[second]) >= SHARED_FIELDS
    }
    assert len(shared) <= MAX_ALIKE, shared
