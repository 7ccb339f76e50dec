"""Values that are kept: arrays on disk by the content that they were computed from, and the last ones in memory."""

import contextlib
import hashlib
import os
import tempfile
import warnings
from collections import OrderedDict
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from flangeway.system.memory_limits import size_of_variable
from flangeway.system.operating_system import cache_parent
from flangeway.system.output_folder import version_of

# --- Arrays kept on disk by the content that they were computed from.
#
# ``FLANGEWAY_CACHE`` names the folder, or is ``off``; left out it is ``flangeway`` in `cache_parent`.
# ``FLANGEWAY_CACHE_MB`` limits its size (2000 by default): what was used longest ago is removed. A file is an archive
# of NumPy with a hash of its key and arrays, which reading verifies. It is written under another name and then renamed,
# so that no process sees half of it; one that is damaged, or not what was stored under its key, is noticed, removed and
# made anew. Nothing is ever wrong for lack of a cache: where the disk refuses, all is computed.


Arrays = Mapping[str, NDArray[Any]]

FORMAT = 4  # rises when what is stored, or how it is computed, changes within one version of the package

SUFFIX = ".arrays"
HASH = "hash"
"""Name of the hash among the arrays of a file."""
DEFAULT_MB = 2000.0
PARTIAL = ".partial"


class CacheWarning(UserWarning):
    """A cached file is damaged, or the cache cannot be used."""


@dataclass(frozen=True)
class Cache:
    """A folder of cached arrays, made when the first ones are stored; above `limit_bytes` the oldest are removed."""

    folder: Path
    limit_bytes: int

    @classmethod
    def of_user(cls) -> "Cache | None":
        """Cache that the environment names; None if it is off, an `InputError` if its limit is not positive."""
        where = os.environ.get("FLANGEWAY_CACHE", "")
        if where.lower() == "off":
            return None
        limit = os.environ.get("FLANGEWAY_CACHE_MB", str(DEFAULT_MB))
        megabytes = size_of_variable("FLANGEWAY_CACHE_MB", limit, "megabytes", "FLANGEWAY_CACHE=off")
        folder = Path(where).expanduser() if where else cache_parent() / "flangeway"
        return cls(folder, int(1e6 * megabytes))

    def get(self, key: str, make: Callable[[], Arrays]) -> Arrays:
        """Arrays of a key; made and stored if there are none."""
        stored = self.load(key)
        if stored is None:
            stored = make()
            self.store(key, stored)
        return stored

    def load(self, key: str) -> Arrays | None:
        """Arrays of a key; None if there are none. A damaged file is removed with a `CacheWarning`."""
        path = self._path(key)
        try:
            with path.open("rb") as file, np.load(file, allow_pickle=False) as stored:
                arrays = {name: stored[name] for name in stored.files}
            if arrays.pop(HASH).tobytes() != _hash(key, arrays):
                raise ValueError("other numbers than were stored")
        except FileNotFoundError:
            return None
        except OSError as error:
            _warn(f"cannot read {path}: {error}")
            return None
        except Exception:  # NumPy and zipfile have many errors for what is no archive, or a damaged one
            _warn(f"{path} is damaged; it is computed anew")
            with contextlib.suppress(OSError):
                path.unlink()
            return None
        with contextlib.suppress(OSError):
            os.utime(path)
        return arrays

    def store(self, key: str, arrays: Arrays) -> None:
        """Store arrays under a key; another process may do the same at the same time."""
        stored = {name: np.asarray(values) for name, values in arrays.items()}
        if sum(values.nbytes for values in stored.values()) > self.limit_bytes:
            return
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            handle, name = tempfile.mkstemp(dir=self.folder, suffix=PARTIAL)
            try:
                with os.fdopen(handle, "wb") as file:
                    hashed = {HASH: np.frombuffer(_hash(key, stored), dtype=np.uint8)}
                    np.savez(file, allow_pickle=False, **stored, **hashed)
                Path(name).replace(self._path(key))
            except BaseException:
                Path(name).unlink(missing_ok=True)
                raise
            self._shrink()
        except OSError as error:
            _warn(f"cannot write to {self.folder}: {error}")

    def _path(self, key: str) -> Path:
        return self.folder / f"{key}{SUFFIX}"

    def _shrink(self) -> None:
        """Remove what was used longest ago, and what a process that was killed left half written."""
        files = []
        for path in self.folder.iterdir():
            if path.suffix not in (SUFFIX, PARTIAL):
                continue
            with contextlib.suppress(FileNotFoundError):  # another process removes as well
                status = path.stat()
                files.append((status.st_mtime, status.st_size, path))
        total = sum(size for _, size, _ in files)
        for _, size, path in sorted(files):
            if total <= self.limit_bytes:
                break
            with contextlib.suppress(OSError):
                path.unlink()
            total -= size


def cached(cache: Cache | None, make: Callable[[], Arrays], kind: str, *parts: object) -> Arrays:
    """Arrays that some content determines, see `content_key`; made anew without a cache or where it has no key."""
    key = None if cache is None else content_key(kind, *parts)
    return make() if cache is None or key is None else cache.get(key, make)


def content_key(kind: str, *parts: object) -> str | None:
    """Key of what some content determines, with the package's version; None where the content has no key.

    The parts are arrays, text, numbers, tuples, mappings, records of such, and objects whose ``repr`` shows all.
    """
    digest = hashlib.sha256(f"{kind} {FORMAT} {version_of('flangeway')}".encode())
    if not all(_add(digest, part) for part in parts):
        return None
    return f"{kind}-{digest.hexdigest()}"


def _hash(key: str, arrays: Arrays) -> bytes:
    digest = hashlib.sha256()
    _add(digest, (key, *sorted(arrays), *(arrays[name] for name in sorted(arrays))))
    return digest.digest()


def _add(digest: "hashlib._Hash", part: object) -> bool:
    if isinstance(part, np.ndarray):
        digest.update(f"<{part.dtype.str}{part.shape}>".encode())
        digest.update(np.ascontiguousarray(part).tobytes())
        return part.dtype.kind != "O"
    if isinstance(part, Mapping):
        digest.update(f"<{len(part)} items>".encode())
        return all(_add(digest, entry) for item in part.items() for entry in item)
    if isinstance(part, tuple | list):
        digest.update(f"<{len(part)} parts>".encode())
        return all(_add(digest, entry) for entry in part)
    names = getattr(part, "__dataclass_fields__", None) or getattr(type(part), "model_fields", None)
    if names and not isinstance(part, type):
        return _add(digest, (type(part).__name__, *(getattr(part, name) for name in names)))
    text = repr(part)
    digest.update(f"<{len(text)}>{text}".encode())
    return " at 0x" not in text and "..." not in text


def _warn(message: str) -> None:
    warnings.warn(f"cache: {message}", CacheWarning, stacklevel=4)


# --- Values that are costly to compute, of which the last ones are kept.


T = TypeVar("T")


class LatestValues(Generic[T]):
    """The values that were used last, by key.

    - `capacity`: number of values that are kept.
    """

    def __init__(self, capacity: int) -> None:
        self._capacity, self._values = capacity, OrderedDict[str, T]()

    def get(self, key: str, compute: Callable[[], T]) -> T:
        """Return the value of a key, computed if it is not kept."""
        if key not in self._values:
            self._values[key] = compute()
            while len(self._values) > self._capacity:
                self._values.popitem(last=False)
        self._values.move_to_end(key)
        return self._values[key]
