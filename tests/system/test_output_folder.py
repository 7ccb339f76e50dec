"""Folders of results are filled at once or not at all."""

import pytest

from flangeway.errors import InputError
from flangeway.system.output_folder import refuse_unwritable, write_together


def everything(folder):
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*"))


def test_files_are_written_in_a_new_folder(tmp_path):
    """Files go to a folder that is made for them, and nothing else stays there."""
    out = tmp_path / "a" / "b"
    refuse_unwritable(out)
    assert everything(tmp_path) == []
    files = write_together(out, {"x": lambda p: p.write_text("1"), "y": lambda p: p.write_text("2")})
    assert [file.read_text() for file in files] == ["1", "2"]
    assert everything(tmp_path) == ["a", "a/b", "a/b/x", "a/b/y"]


@pytest.mark.parametrize("failure", [RuntimeError, KeyboardInterrupt])
def test_a_failure_leaves_nothing_behind(tmp_path, failure):
    """If one writer fails, or the user stops it, no file is new or changed and no temporary folder stays."""

    def broken(path):
        path.write_text("half")
        raise failure

    (tmp_path / "old").mkdir()
    (tmp_path / "old" / "x").write_text("before")
    for out in (tmp_path / "old", tmp_path / "new"):
        with pytest.raises(failure):
            write_together(out, {"x": lambda p: p.write_text("after"), "y": broken})
    assert everything(tmp_path) == ["old", "old/x"]
    assert (tmp_path / "old" / "x").read_text() == "before"


def test_files_of_a_former_run_are_replaced_and_others_kept(tmp_path):
    """A second run replaces the files of its names and leaves the others alone."""
    (tmp_path / "x").write_text("before")
    (tmp_path / "notes").write_text("mine")
    write_together(tmp_path, {"x": lambda p: p.write_text("after")})
    assert (tmp_path / "x").read_text() == "after"
    assert (tmp_path / "notes").read_text() == "mine"


def test_a_file_in_the_way_is_refused(tmp_path):
    """A file where the folder should be, or above it, is refused before and while writing."""
    (tmp_path / "file").write_text("")
    for out in (tmp_path / "file", tmp_path / "file" / "below"):
        with pytest.raises(InputError, match="not a folder"):
            refuse_unwritable(out)
        with pytest.raises(InputError, match="cannot be written"):
            write_together(out, {"x": lambda p: p.write_text("1")})
    assert everything(tmp_path) == ["file"]


@pytest.mark.parametrize("name", ["summary.json", "report.html", "body.vtu", "campaign.sqlite"])
def test_a_folder_with_the_name_of_a_file_is_refused(tmp_path, name):
    """A folder called like a file of the results is refused before anything is computed; others may be there."""
    (tmp_path / "steps").mkdir()
    refuse_unwritable(tmp_path)
    (tmp_path / name).mkdir()
    with pytest.raises(InputError, match=f"{name}, which is a folder"):
        refuse_unwritable(tmp_path)


def test_a_system_that_does_not_allow_to_write_is_refused(tmp_path, monkeypatch):
    """If the system does not allow a file in the folder, the message says so."""

    def denied(*_, **__):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr("tempfile.mkdtemp", denied)
    with pytest.raises(InputError, match="Permission denied"):
        refuse_unwritable(tmp_path)
