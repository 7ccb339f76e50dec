"""Keys without effect, tables that a file lacks, the root as a folder, and pipes as files."""

import os
from pathlib import Path
from typing import Any

import pytest

from flangeway import InputError, load_case
from flangeway.cases.case_file import read_case
from flangeway.system.file_content import file_content
from flangeway.system.output_folder import refuse_unwritable

TWO_BLOCKS: dict[str, Any] = {
    "bodies": [
        {"name": "block", "rectangle": {"width_mm": 2.0, "height_mm": 2.0, "centre_mm": [0.0, 1.0]}, "size_mm": 1.0},
        {"name": "base", "rectangle": {"width_mm": 4.0, "height_mm": 2.0, "centre_mm": [0.0, -1.0]}, "size_mm": 1.0},
    ],
    "supports": [{"body": "block", "edges": "top"}, {"body": "base", "edges": "bottom"}],
    "motions": [{"body": "block", "shift_mm": [0.0, -0.001]}],
}


def contact(**values: object) -> dict[str, Any]:
    sides = {"secondary": "block", "secondary_edges": "bottom", "primary": "base", "primary_edges": "top"}
    return TWO_BLOCKS | {"contacts": [sides | values]}


@pytest.mark.parametrize(
    ("choice", "key", "value"),
    [
        ({"enforcement": "multiplier"}, "penalty_MPa_mm", 1e5),
        ({"enforcement": "penalty"}, "penetration_mm", 1e-3),
        ({"pairing": "segment-to-segment"}, "slack", 0.05),
        ({"pairing": "node-to-segment"}, "weighting", "dual"),
    ],
)
def test_a_key_without_effect_is_refused(choice: dict[str, str], key: str, value: object) -> None:
    """The message names the table's place, the key and the choice that leaves it without effect."""
    case = load_case("two-bodies", **contact(**choice, **{key: value}))
    with pytest.raises(InputError, match=rf"contacts\[1\]\.{key} = .* with (enforcement|pairing) = "):
        case.check()


def test_a_table_that_the_file_lacks(tmp_path: Path) -> None:
    """`--set steps.number=2` makes the table; an unknown key in it is refused as in a file."""
    file = tmp_path / "case.toml"
    blocks = "".join(
        f'[[bodies]]\nname = "{name}"\nsize_mm = 1\nrectangle = {{width_mm = 2.0, height_mm = 2.0, centre_mm = {at}}}\n'
        for name, at in (("block", [0.0, 1.0]), ("base", [0.0, -1.0]))
    )
    file.write_text(f'case = "two-bodies"\n{blocks}', encoding="utf-8")
    assert read_case(file, {"steps.number": 2}).model_dump()["steps"]["number"] == 2
    with pytest.raises(InputError, match="nmber"):
        read_case(file, {"steps.nmber": 2})


def test_the_root_is_no_folder_for_results() -> None:
    """Neither `/` nor a path that leads there is taken."""
    for folder in (Path("/"), Path("/tmp/..")):
        with pytest.raises(InputError, match="root"):
            refuse_unwritable(folder)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="named pipes are of POSIX")
def test_a_pipe_is_refused_at_once(tmp_path: Path) -> None:
    """A named pipe that nobody writes into is neither a case file nor a profile."""
    pipe = tmp_path / "case.toml"
    os.mkfifo(pipe)
    with pytest.raises(InputError, match="pipe"):
        read_case(pipe)
    with pytest.raises(InputError, match="pipe"):
        file_content(pipe, "a profile")
