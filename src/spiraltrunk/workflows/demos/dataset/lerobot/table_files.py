"""Parquet files of a data set, each up to a size."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any, final

from spiraltrunk.workflows.demos.dataset.lerobot.features import CHUNK, DATA_MB

if TYPE_CHECKING:
    import pyarrow as pa


@final
class TableFiles:
    """Writes tables of one schema, each as a row group; a context, which completes the last file."""

    def __init__(self, folder: Path, path: str, schema: pa.Schema) -> None:
        self._folder, self._path, self._schema = folder, path, schema
        self._number = -1
        self._file = folder
        self._writer: Any = None

    def __enter__(self) -> TableFiles:
        return self

    def __exit__(self, *_: object) -> None:
        self._close()

    @property
    def place(self) -> tuple[int, int]:
        """Chunk and file that the next table goes to."""
        if self._writer is None or self._file.stat().st_size >= 0.9 * DATA_MB * 2**20:
            self._open()
        chunk, file = divmod(self._number, CHUNK)
        return chunk, file

    def add(self, columns: dict[str, Any]) -> None:
        """Append rows to the file of `place`.

        Raises:
            OSError: where it cannot be written.
        """
        import pyarrow as pa

        self._writer.write_table(pa.table(columns, schema=self._schema))

    def _open(self) -> None:
        import pyarrow.parquet as pq

        self._close()
        self._number += 1
        chunk, file = divmod(self._number, CHUNK)
        self._file = self._folder / self._path.format(chunk_index=chunk, file_index=file)
        self._file.parent.mkdir(parents=True, exist_ok=True)
        self._writer = pq.ParquetWriter(self._file, self._schema, compression="snappy")

    def _close(self) -> None:
        if self._writer is not None:
            self._writer.close()
            self._writer = None
