"""Readers of files meet random damage, and files that say or pack far more than they are."""

import json
import subprocess
import sys
import time
from pathlib import Path

import pytest

from flangeway.errors import MAX_LETTERS_OF_PART, InputError, OutOfMemoryError
from flangeway.system.file_content import toml_data
from flangeway.system.operating_system import system_module

HERE = Path(__file__).parent


@pytest.mark.skipif(system_module("resource") is None, reason="no limit of the address space")
def test_damaged_files_and_bombs_are_read_or_refused_in_time():
    """Each of 150 files is read or refused within 4 s of the processor, 1.5 GB, and a message of 4,000 letters."""
    done = subprocess.run(
        [sys.executable, HERE / "damaged_files.py", "5", "1"], capture_output=True, text=True, check=True, timeout=300
    )
    found = json.loads(done.stdout)
    assert found["read"] > 150
    assert found["faults"] == {}


MANY = 100_000


@pytest.mark.parametrize(
    "text",
    [
        "a." * MANY + "a = 1",
        "[" + "a." * MANY + "a]",
        '"a".' * MANY + "a = 1",
        "a . " * MANY + "a = 1",
        "x = { " + "a." * MANY + "a = 1 }",
        "x = " + "[" * MANY,
        "x = " + "{ a = " * MANY,
    ],
)
def test_depth_in_toml_is_bounded_before_it_is_read(text):
    """Names with 100,000 points, and as deep lists and tables, are refused in a second."""
    start = time.process_time()
    with pytest.raises(InputError, match="too deep"):
        toml_data(text, "lines")
    assert time.process_time() - start < 5.0


@pytest.mark.parametrize("text", ['x = "' + "a.b " * MANY + '"', "x = 1." + "1" * MANY, "a.b.c.d.e = 1", "'a.b'.c = 1"])
def test_points_in_texts_and_numbers_are_no_depth(text):
    """Sentences, numbers and names of few parts are read."""
    assert toml_data(text, "lines")


@pytest.mark.parametrize("value", ["a" * MANY, "a b " * MANY, "a\n" * MANY, "'" * MANY, "'" + "a b" * MANY + "' after"])
def test_messages_are_cut(value):
    """Whatever a user wrote, a message has a readable length, and says at its end what to do."""
    for message in (str(InputError(f"key = {value}, wrong", value, value)), str(OutOfMemoryError(value))):
        assert len(message) <= 3 * MAX_LETTERS_OF_PART + 100
    word = "a" * MANY
    error = InputError(f"the file '{word}' with x = 3", "a name", "correct it")
    assert len(error.given) < 400
    assert error.given.endswith("with x = 3")


def test_short_messages_are_whole():
    """A list of a hundred keys, and a name of 250 letters, are not cut."""
    keys = ", ".join(f"some_key_{number}_mm" for number in range(100))
    error = InputError("b" * 250, keys, "choose one")
    assert (error.given, error.allowed) == ("b" * 250, keys)
