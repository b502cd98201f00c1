"""Machine code of the kernels on disc: where it is kept, and what happens where it cannot be."""

from __future__ import annotations

import functools
import logging
import os
import stat
import tempfile
from pathlib import Path
from typing import Any, final

from numba.core.caching import CompileResultCacheImpl, FunctionCache, UserProvidedCacheLocator


@functools.cache
def _log_once(message: str) -> None:
    """Log a message once per process."""
    logging.getLogger("spiraltrunk").info(message)


@final
class _TemporaryFolder(UserProvidedCacheLocator):
    """Folder of the user below the system's temporary one.

    Cached code is executed when it is read, so the folder must belong to this user and be closed to all others.
    """

    def __init__(self, function: Any, file: str) -> None:
        self._py_file, self._lineno = file, function.__code__.co_firstlineno
        self._folder = Path(tempfile.gettempdir()) / f"spiraltrunk-kernels-{os.getuid()}"
        self._cache_path = str(self._folder / self.get_suitable_cache_subpath(file))  # type: ignore[no-untyped-call]

    def ensure_cache_path(self) -> None:
        """Make the folder.

        Raises:
            OSError: it cannot be written, or somebody else could write it.
        """
        self._folder.mkdir(mode=0o700, exist_ok=True)
        found = self._folder.lstat()
        if not stat.S_ISDIR(found.st_mode) or found.st_uid != os.getuid() or stat.S_IMODE(found.st_mode) & 0o077:
            raise PermissionError(f"{self._folder} is open to other users")
        super().ensure_cache_path()  # type: ignore[no-untyped-call]
        _log_once(f"compiled models are kept in {self._folder}: neither the package nor the home folder can be written")

    @classmethod
    def from_function(cls, function: Any, file: str) -> _TemporaryFolder | None:
        """The locator of a function in a file, or None where the folder cannot be used."""
        locator = cls(function, file)
        try:
            locator.ensure_cache_path()
        except OSError:
            return None
        return locator


@final
class _Storage(CompileResultCacheImpl):
    """Numba's storage, which tries the package's folder and the user's, then the temporary one."""

    def __init__(self, function: Any) -> None:
        self._locator_classes = [*self._locator_classes, _TemporaryFolder]
        super().__init__(function)  # type: ignore[no-untyped-call]


@final
class KernelCache(FunctionCache):
    """Numba's cache of one kernel, which is left out where it cannot be read or written.

    Args:
        function: the kernel as Python.
        stamp: digest of all the source that is compiled into it; code of another stamp is not used.

    Raises:
        RuntimeError: there is no folder to keep machine code in.
    """

    _impl_class = _Storage

    def __init__(self, function: Any, stamp: str) -> None:
        super().__init__(function)  # type: ignore[no-untyped-call]
        file = self._cache_file
        file._source_stamp = stamp
        # Numba writes the index before the code: killed between the two, it would run code of the former stamp.
        file._data_name_pattern = file._data_name_pattern.replace(".{number", f".{stamp[:12]}.{{number")

    def _load_overload(self, signature: Any, target: Any) -> Any:
        try:
            return super()._load_overload(signature, target)  # type: ignore[no-untyped-call]
        except Exception as error:  # A damaged pickle raises anything.
            _log_once(f"compiled models in {self.cache_path} cannot be read ({error!r}): they are compiled again")
            return None

    def _save_overload(self, signature: Any, compiled: Any) -> None:
        try:
            try:
                super()._save_overload(signature, compiled)  # type: ignore[no-untyped-call]
            except Exception:  # As above: the index is read before it is written. One of moved modules never can be.
                Path(self._cache_file._index_path).unlink()
                super()._save_overload(signature, compiled)  # type: ignore[no-untyped-call]
        except Exception as error:
            _log_once(f"compiled models cannot be kept in {self.cache_path} ({error}): the next process compiles again")
            self.disable()  # type: ignore[no-untyped-call]


def keep(kernel: Any, stamp: str) -> None:
    """Keep a kernel's machine code on disc, or say that every process compiles it where there is no folder to write."""
    try:
        kernel._cache = KernelCache(kernel.py_func, stamp)
    except RuntimeError:
        _log_once(
            "every process compiles the models (up to 15 s a model), since no folder can be written to keep them: "
            "set NUMBA_CACHE_DIR to one that can"
        )
