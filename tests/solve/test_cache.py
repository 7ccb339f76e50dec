"""Arrays that are kept on disk: damage, two writers, version and size."""

import os
import subprocess
import sys
import time
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from flangeway.cases import Wheelset
from flangeway.cases.case_file import case_content, hash_of
from flangeway.elements import Lagrange
from flangeway.errors import InputError
from flangeway.geometry import rectangle
from flangeway.materials import Elastic
from flangeway.mesh import triangulate
from flangeway.problems import Body
from flangeway.railway.profiles import bundled
from flangeway.solve import CondensedBodies, SurfaceNodes
from flangeway.system import disk_cache as cache_module
from flangeway.system.disk_cache import Cache, CacheWarning, content_key


@pytest.fixture
def cache(tmp_path: Path) -> Cache:
    return Cache(tmp_path / "cache", 10**8)


def a_body(young: float = 210e3) -> SurfaceNodes:
    mesh = triangulate(rectangle(10.0, 10.0), size=2.0)
    body = Body("block", mesh, Lagrange(1), Elastic(young, 0.3), "bottom")
    return SurfaceNodes(body, np.unique(mesh.edge_set("top")).astype(np.int32))


def test_what_is_stored_is_loaded(cache: Cache) -> None:
    """Arrays come back equal in value, shape and type; a key that was never stored has none."""
    arrays = {"a": np.arange(6.0).reshape(2, 3), "b": np.array(["x", "yz"]), "c": np.zeros((0, 2), dtype=np.int32)}
    cache.store("some", arrays)
    found = cache.load("some")
    assert found is not None
    assert set(found) == set(arrays)
    for name, value in arrays.items():
        assert found[name].dtype == value.dtype
        np.testing.assert_array_equal(found[name], value)
    assert cache.load("other") is None


@pytest.mark.parametrize("damage", ["a bit", "half", "empty", "other"])
def test_damage_is_noticed_and_made_anew(cache: Cache, damage: str) -> None:
    """A file with one wrong bit, cut in half, empty or of another kind warns, is removed, and is made anew."""
    cache.store("some", {"a": np.arange(1000.0)})
    (path,) = cache.folder.iterdir()
    content = bytearray(path.read_bytes())
    if damage == "a bit":
        content[len(content) // 2] ^= 1
    path.write_bytes(
        {"a bit": bytes(content), "half": bytes(content[: len(content) // 2]), "empty": b"", "other": b"text" * 99}[
            damage
        ]
    )
    made = []

    def make() -> dict[str, np.ndarray]:
        made.append(1)
        return {"a": np.arange(1000.0)}

    with pytest.warns(CacheWarning, match="damaged"):
        np.testing.assert_array_equal(cache.get("some", make)["a"], np.arange(1000.0))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        np.testing.assert_array_equal(cache.get("some", make)["a"], np.arange(1000.0))
    assert len(made) == 1


@pytest.mark.parametrize("change", ["numbers", "shape", "type", "name", "more", "bare", "of another key"])
def test_an_archive_of_other_content_is_made_anew(cache: Cache, change: str) -> None:
    """A whole archive that does not hold what was stored under its key is removed, and made anew."""
    right = {"remainder": np.arange(12.0).reshape(3, 4)}
    cache.store("some", right)
    (path,) = cache.folder.iterdir()
    with np.load(path) as archive:
        stored = dict(archive)
    values = stored["remainder"]
    others: dict[str, dict[str, np.ndarray]] = {
        "numbers": stored | {"remainder": 1.001 * values},
        "shape": stored | {"remainder": values.reshape(4, 3)},
        "type": stored | {"remainder": values.astype(np.float32)},
        "name": {name.replace("remainder", "other"): value for name, value in stored.items()},
        "more": stored | {"more": values},
        "bare": right,
    }
    if change == "of another key":
        cache.store("another", {"remainder": -values})
        path.with_name(path.name.replace("some", "another")).replace(path)
    else:
        with path.open("wb") as file:
            np.savez(file, allow_pickle=False, **others[change])
    with pytest.warns(CacheWarning, match="damaged"):
        found = cache.get("some", lambda: right)
    assert set(found) == {"remainder"}
    np.testing.assert_array_equal(found["remainder"], right["remainder"])
    again = cache.load("some")
    assert again is not None
    np.testing.assert_array_equal(again["remainder"], right["remainder"])


WRITER = """
import sys
from pathlib import Path
import numpy as np
from flangeway.system.disk_cache import Cache
for _ in range(15):
    value = float(sys.argv[2])
    Cache(Path(sys.argv[1]), 10**9).store("shared", {"a": np.full(200_000, value), "b": np.full(200_000, value)})
"""


def test_two_writers_and_a_reader(tmp_path: Path) -> None:
    """While two processes write one key again and again, a reader never sees a damaged or mixed file."""
    writers = [subprocess.Popen([sys.executable, "-c", WRITER, str(tmp_path), value]) for value in ("1", "2")]
    cache, seen = Cache(tmp_path, 10**9), set()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        while any(writer.poll() is None for writer in writers):
            found = cache.load("shared")
            if found is not None:
                assert len(set(found["a"]) | set(found["b"])) == 1
                seen.add(float(found["a"][0]))
            time.sleep(0.001)
        seen.add(float(cache.load("shared")["a"][0]))
    for writer in writers:
        assert writer.wait() == 0
    assert seen <= {1.0, 2.0}
    assert not list(tmp_path.glob("*.partial"))


def test_a_key_changes_with_content_and_version(monkeypatch: pytest.MonkeyPatch) -> None:
    """One changed number, another array type, format or version of the package gives another key."""
    values = np.arange(3.0)
    keys = {content_key("kind", values, 1.0)}
    keys.add(content_key("kind", values + np.array([0.0, 0.0, 1e-15]), 1.0))
    keys.add(content_key("kind", values, 1.0 + 1e-15))
    keys.add(content_key("kind", values.astype(np.float32), 1.0))
    keys.add(content_key("other", values, 1.0))
    keys.add(content_key("kind", values.reshape(1, 3), 1.0))
    monkeypatch.setattr(cache_module, "FORMAT", cache_module.FORMAT + 1)
    keys.add(content_key("kind", values, 1.0))
    monkeypatch.setattr(cache_module, "version_of", lambda _: "another")
    keys.add(content_key("kind", values, 1.0))
    assert len(keys) == 8
    assert None not in keys


def test_a_key_follows_what_records_hold_and_not_their_text() -> None:
    """Profiles whose outlines differ in the last digit have different keys, though their texts are equal."""
    wheel = bundled.wheel("S1002")
    first, *others = wheel.outline.segments
    moved = replace(first, end=(first.end[0], np.nextafter(first.end[1], 1.0)))
    second = replace(others[0], start=moved.end)
    other = replace(wheel, outline=replace(wheel.outline, segments=(moved, second, *others[1:])))
    assert repr(wheel) == repr(other)
    assert content_key("kind", wheel) == content_key("kind", bundled.wheel("S1002"))
    assert content_key("kind", wheel) != content_key("kind", other)
    cases = [Wheelset.from_values({"wheelset": {"wheel": each}}) for each in (wheel, other)]
    assert len({hash_of(case_content(case)) for case in cases}) == 2


def test_content_that_cannot_be_told_has_no_key() -> None:
    """An object that shows only its address is not taken for its content."""
    assert content_key("kind", object()) is None
    assert content_key("kind", {"a": (1, object())}) is None


def test_the_size_is_bounded(tmp_path: Path) -> None:
    """Above the limit, files that were used longest ago are removed, not those just written or read."""
    cache = Cache(tmp_path, 30_000)
    for number in range(3):
        cache.store(str(number), {"a": np.zeros(1000)})  # 8 kB each
        os.utime(tmp_path / f"{number}.arrays", (number, number))
    assert cache.load("0") is not None  # used now
    cache.store("3", {"a": np.zeros(1000)})
    assert [cache.load(str(number)) is not None for number in range(4)] == [True, False, True, True]
    cache.store("large", {"a": np.zeros(10_000)})
    assert cache.load("large") is None


def test_the_environment_names_the_cache(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """FLANGEWAY_CACHE is a folder or off; FLANGEWAY_CACHE_MB is its size, and nonsense is refused."""
    monkeypatch.setenv("FLANGEWAY_CACHE", str(tmp_path))
    monkeypatch.setenv("FLANGEWAY_CACHE_MB", "3")
    assert Cache.of_user() == Cache(tmp_path, 3_000_000)
    monkeypatch.setenv("FLANGEWAY_CACHE_MB", "much")
    with pytest.raises(InputError, match="positive"):
        Cache.of_user()
    monkeypatch.setenv("FLANGEWAY_CACHE", "off")
    assert Cache.of_user() is None
    monkeypatch.delenv("FLANGEWAY_CACHE")
    monkeypatch.delenv("FLANGEWAY_CACHE_MB")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert Cache.of_user() == Cache(tmp_path / "flangeway", 2_000_000_000)


def test_a_disk_that_refuses_warns(tmp_path: Path) -> None:
    """Where the folder cannot be made, storing warns and nothing is lost."""
    (tmp_path / "file").write_text("no folder")
    with pytest.warns(CacheWarning, match="cannot write"):
        Cache(tmp_path / "file" / "below", 10**6).store("some", {"a": np.zeros(3)})


def test_a_flexibility_from_the_cache_is_the_same(cache: Cache, monkeypatch: pytest.MonkeyPatch) -> None:
    """A body condensed before is not factorised; its flexibility, and a field recovered later, are the same."""
    surface = a_body()
    first = CondensedBodies([surface], cache)
    forces = np.random.default_rng(0).normal(size=(len(surface.nodes), 2))
    rotations = np.broadcast_to(np.eye(2), (len(surface.nodes), 2, 2))
    expected = first.fields(rotations, forces)[0]

    def refuse(*_: object) -> None:
        raise AssertionError("factorised again")

    with monkeypatch.context() as patch:
        patch.setattr("flangeway.solve.condensed.factorise", refuse)
        again = CondensedBodies([a_body()], cache)
    np.testing.assert_array_equal(again.flexibility(0), first.flexibility(0))
    np.testing.assert_allclose(again.fields(rotations, forces)[0], expected, rtol=1e-12, atol=1e-18)
    other = CondensedBodies([a_body(200e3)], cache)
    np.testing.assert_allclose(other.flexibility(0), first.flexibility(0) * 210.0 / 200.0, rtol=1e-10)
