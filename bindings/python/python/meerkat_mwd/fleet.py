"""Recordings past one machine, on an engine that is there: Dask distributed; see the README for Spark and Ray.

A recording is a task. Its result is the three tables of ``cargo mwd batch``, of this recording alone: small Parquet
files, named by a hash of the recording's address and by the one that ``batch`` has for all that the result depends on:
the recording's bytes, the configuration's, the other options and the compiled library. Each appears whole or not at
all, the one of ``recordings`` last. So a task that an engine runs twice writes the same files twice, a lost worker
loses only what it was flying, and a run that is started again flies only what is not there. A result takes the place of
the same recording's former one.
"""

from __future__ import annotations

import contextlib
import functools
import hashlib
import os
import tempfile
import uuid
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import meerkat_mwd
from meerkat_mwd import _native

if TYPE_CHECKING:
    import pandas as pd
    from distributed import Client

__all__ = ["TABLES", "fly", "read", "run"]

#: Names of the tables, a row a recording, a window, a survey, and their files as ``batch`` names them.
TABLES = {"recordings": "all.parquet", "windows": "all.windows.parquet", "stations": "all.stations.parquet"}


@contextlib.contextmanager
def _file(url: str, content: bytes) -> Iterator[Path]:
    """A recording's bytes as a file, in a folder that has place for its tables."""
    ending = "".join(Path(url.split("?")[0]).suffixes[-2:]) or ".csv"
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / f"trace{ending}"
        file.write_bytes(content)
        yield file


def _options(
    config: str | os.PathLike[str] | None = None,
    hold_out: float | None = None,
    seed: int | None = None,
    no_effects: bool = False,
    force: bool = False,
) -> dict[str, Any]:
    """All options of a flight, by their names."""
    return {"config": config, "hold_out": hold_out, "seed": seed, "no_effects": no_effects, "force": force}


def fly(url: str, content: bytes, **options: Any) -> dict[str, list[dict[str, Any]]]:
    """Rows of the three tables for a recording's bytes; what cannot be flown is a row with its reason.

    Needs no engine: call it in Spark's ``mapInPandas`` or in a Ray task. Options as in :func:`run`.
    """
    import pyarrow.parquet as pq

    given = _options(**options)
    with _file(url, content) as file:
        key = _native.key(str(file), _library(), given)
        _native.tables(url, str(file), key, str(file.with_name(TABLES["recordings"])), given)
        return {name: pq.read_table(file.with_name(table)).to_pylist() for name, table in TABLES.items()}


@functools.cache
def _library() -> bytes:
    """Hash of the compiled library: another build may fly otherwise."""
    hashed = hashlib.blake2b(meerkat_mwd.__version__.encode(), digest_size=16)
    if _native.__file__ is not None:
        hashed.update(Path(_native.__file__).read_bytes())
    return hashed.digest()


def _one(url: str, results: str, options: dict[str, Any]) -> bool:
    """Flies a recording unless its result is there; whether it was flown."""
    import fsspec

    given = _options(**options)
    try:
        with fsspec.open(url, "rb") as opened:
            content, unread = opened.read(), None
    except OSError as error:
        content, unread = b"", f"cannot be read: {error}"
    own = hashlib.blake2b(url.encode(), digest_size=8).hexdigest()
    storage, root = fsspec.core.url_to_fs(results)
    with _file(url, content) as file:
        key = _native.key(str(file), _library(), given)
        # A recording that could not be read has no content to be known by: it is tried again each time.
        is_kept = unread is None and storage.exists(f"{root}/recordings/{own}.{key}.parquet")
        if not is_kept:
            tables = str(file.with_name(TABLES["recordings"]))
            if unread is None:
                key = _native.tables(url, str(file), key, tables, given)
            else:
                key = _native.tables_of_unread(url, unread, tables)
            for name, table in reversed(TABLES.items()):
                unfinished = f"{root}/{name}/.{own}.{key}.{uuid.uuid4().hex}"
                storage.makedirs(f"{root}/{name}", exist_ok=True)
                storage.put_file(str(file.with_name(table)), unfinished)
                storage.mv(unfinished, f"{root}/{name}/{own}.{key}.parquet")
    # Also of a result that is kept: the worker that wrote it may have been lost before it came to this.
    for name in TABLES:
        for former in storage.glob(f"{root}/{name}/{own}.*.parquet"):
            if not former.endswith(f"/{own}.{key}.parquet"):
                # The same task may run elsewhere and be quicker.
                with contextlib.suppress(FileNotFoundError):
                    storage.rm(former)
    return not is_kept


def run(
    urls: Iterable[str], client: Client, results: str, *, retries: int = 5, **options: Any
) -> dict[str, int]:
    """Flies recordings on a Dask cluster and writes their results as three folders of Parquet below ``results``.

    Args:
        urls: Addresses that fsspec opens: paths, ``s3://``, ``gs://``, ``https://``.
        client: The cluster's client. Its workers need this package.
        results: Folder of the results, an address too.
        retries: How often a recording is tried again whose worker or network failed.
        options: ``config``, ``hold_out``, ``seed``, ``no_effects`` and ``force``, as in :func:`meerkat_mwd.replay`. The
            configuration that ``config`` names must be there on the workers; a run ends with the error where it is not.

    Returns:
        Numbers of recordings: ``flown`` now, and ``kept`` from before.
    """
    from distributed import as_completed

    urls, options = list(dict.fromkeys(urls)), _options(**options)
    futures = [client.submit(_one, url, results, options, retries=retries, pure=False) for url in urls]
    flown = 0
    for future in as_completed(futures):
        flown += future.result()
        # A result that was counted need not be computed again when the worker that holds it is lost.
        future.release()
    return {"flown": flown, "kept": len(urls) - flown}


def read(results: str, table: str = "recordings") -> pd.DataFrame:
    """One of the tables (:data:`TABLES`) of a run, from all its files; the columns are those of ``cargo mwd batch``."""
    import fsspec
    import pyarrow as pa
    import pyarrow.parquet as pq

    storage, root = fsspec.core.url_to_fs(results)
    files = sorted(storage.glob(f"{root}/{table}/*.parquet"))
    tables = []
    for file in files:
        with storage.open(file, "rb") as opened:
            tables.append(pq.read_table(opened))
    together: pd.DataFrame = pa.concat_tables(tables, promote_options="default").to_pandas()
    return together
