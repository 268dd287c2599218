"""Recordings past one machine, on an engine that is there: Dask distributed; see the README for Spark and Ray.

A recording is a task. Its result is three small Parquet files, named by a hash of the recording's address and by one of
all that the result depends on: the recording's bytes, the configuration's, the other options and the compiled library;
each appears whole or not at all, the one of ``recordings`` last. So a task that an engine runs twice writes the same files
twice, a lost worker loses only what it was flying, and a run that is started again flies only what is not there. A result
takes the place of the same recording's former one.
"""

from __future__ import annotations

import contextlib
import functools
import hashlib
import io
import json
import tempfile
import uuid
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import meerkat_mwd
from meerkat_mwd import _native

if TYPE_CHECKING:
    import pandas as pd
    from distributed import Client

__all__ = ["TABLES", "fly", "read", "run"]

#: Names of the tables: a row a recording, a window, a survey.
TABLES = ("recordings", "windows", "stations")

#: Columns that are no numbers.
_TEXT = {
    "path", "hash", "error", "effects", "trace_path", "trace_serial", "trace_date", "identification_motion",
    "identification_motion_from", "identification_note", "diagnosis_verdict", "reason", "optimizer", "window_note", "kind", "toolface", "grade",
}  # fmt: skip
_FLAG = {"ok", "accepted", "rotating"}


def _flat(value: Any, name: str, row: dict[str, Any]) -> None:
    """Numbers and texts of a JSON value, named by their path with ``_`` between; lists of objects are tables."""
    if isinstance(value, dict):
        for key, member in value.items():
            _flat(member, f"{name}_{key}" if name else key, row)
    elif isinstance(value, list):
        if not any(isinstance(member, (dict, list, bool)) for member in value):
            for index, member in enumerate(value):
                row[f"{name}_{index}"] = member
    else:
        row[name] = value


def fly(url: str, content: bytes, **options: Any) -> dict[str, list[dict[str, Any]]]:
    """Rows of the three tables for a recording's bytes; what cannot be flown is a row with its reason.

    Needs no engine: call it in Spark's ``mapInPandas`` or in a Ray task. Options as in :func:`meerkat_mwd.replay`.
    """
    own = {"path": url}
    ending = "".join(Path(url.split("?")[0]).suffixes[-2:]) or ".csv"
    try:
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / f"trace{ending}"
            file.write_bytes(content)
            try:
                flight = meerkat_mwd.replay(file, **options)
            except ValueError as error:
                raise ValueError(str(error).replace(f"{file}", "").lstrip(",: ")) from None
            result, surveys = flight.json, flight.surveys()
    except ValueError as error:
        return {"recordings": [{**own, "ok": False, "error": str(error)}], "windows": [], "stations": []}
    windows = result["identification"].pop("windows")
    row: dict[str, Any] = {**own, "ok": True, "error": None, "windows": len(windows), "stations": len(surveys)}
    row["windows_accepted"] = sum(window["accepted"] for window in windows)
    row["effects"] = ",".join(effect["name"] for effect in result["diagnosis"]["effects"])
    # What is the same for all, or no single value.
    for name in ("schema", "version", "seed", "configuration", "surveys"):
        result.pop(name)
    for name in ("path", "notes", "wrong"):
        result["trace"].pop(name)
    _flat(result, "", row)
    flat_windows = []
    for index, window in enumerate(windows):
        flat: dict[str, Any] = {**own, "window": index}
        _flat(window, "", flat)
        flat_windows.append(flat)
    stations = [{**own, **station} for station in json.loads(surveys.to_json(orient="records"))]
    return {"recordings": [row], "windows": flat_windows, "stations": stations}


def _parquet(rows: list[dict[str, Any]]) -> bytes:
    """Rows as Parquet. A column has one type in all files, whatever is missing in one."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    names = list(dict.fromkeys(name for row in rows for name in row))

    def column(name: str) -> pa.Array:
        kind = pa.string() if name in _TEXT else pa.bool_() if name in _FLAG else pa.float64()
        values = [row.get(name) for row in rows]
        if name in _FLAG:
            values = [None if value is None else bool(value) for value in values]
        elif name not in _TEXT:
            values = [None if value is None else float(value) for value in values]
        return pa.array(values, kind)

    sink = io.BytesIO()
    pq.write_table(pa.table({name: column(name) for name in names}), sink)
    return sink.getvalue()


@functools.cache
def _library() -> bytes:
    """Hash of the compiled library: another build may fly otherwise."""
    hashed = hashlib.blake2b(meerkat_mwd.__version__.encode(), digest_size=16)
    if _native.__file__ is not None:
        hashed.update(Path(_native.__file__).read_bytes())
    return hashed.digest()


def _key(url: str, content: bytes, options: dict[str, Any]) -> str:
    """Hash of all that a recording's result depends on. A configuration counts by its bytes, wherever it is."""
    others = {name: value for name, value in options.items() if name != "config"}
    config = options.get("config")
    hashed = hashlib.blake2b(_library(), digest_size=16)
    parts = [repr([url, sorted(others.items())]).encode(), b"" if config is None else Path(config).read_bytes(), content]
    for part in parts:
        # With its length, so that no two lists of parts are one text.
        hashed.update(len(part).to_bytes(8, "little") + part)
    return hashed.hexdigest()


def _one(url: str, results: str, options: dict[str, Any]) -> bool:
    """Flies a recording unless its result is there; whether it was flown."""
    import fsspec

    try:
        with fsspec.open(url, "rb") as file:
            content, unread = file.read(), None
    except OSError as error:
        content, unread = b"", f"cannot be read: {error}"
    own = hashlib.blake2b(url.encode(), digest_size=8).hexdigest()
    # What could not be read has no content to be known by: it is tried again each time.
    key = _key(url, content, options) if unread is None else "unread"
    storage, root = fsspec.core.url_to_fs(results)

    def former(table: str) -> list[str]:
        return [file for file in storage.glob(f"{root}/{table}/{own}.*.parquet") if not file.endswith(f"/{own}.{key}.parquet")]

    is_kept = unread is None and storage.exists(f"{root}/recordings/{own}.{key}.parquet")
    if not is_kept:
        if unread is None:
            rows = fly(url, content, **options)
        else:
            rows = {"recordings": [{"path": url, "ok": False, "error": unread}], "windows": [], "stations": []}
        for name in reversed(TABLES):
            if rows[name]:
                data = _parquet([{**row, "hash": key} for row in rows[name]])
                unfinished = f"{root}/{name}/.{own}.{key}.{uuid.uuid4().hex}"
                storage.makedirs(f"{root}/{name}", exist_ok=True)
                with storage.open(unfinished, "wb") as file:
                    file.write(data)
                storage.mv(unfinished, f"{root}/{name}/{own}.{key}.parquet")
    # Also of a result that is kept: the worker that wrote it may have been lost before it came to this.
    for table in TABLES:
        for file in former(table):
            # The same task may run elsewhere and be quicker.
            with contextlib.suppress(FileNotFoundError):
                storage.rm(file)
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
        options: As in :func:`meerkat_mwd.replay`. The configuration that ``config`` names must be there on the workers;
            a run ends with the error where it is not.

    Returns:
        Numbers of recordings: ``flown`` now, and ``kept`` from before.
    """
    from distributed import as_completed

    urls = list(dict.fromkeys(urls))
    futures = [client.submit(_one, url, results, options, retries=retries, pure=False) for url in urls]
    flown = 0
    for future in as_completed(futures):
        flown += future.result()
    return {"flown": flown, "kept": len(urls) - flown}


def read(results: str, table: str = "recordings") -> pd.DataFrame:
    """One of the tables (:data:`TABLES`) of a run, from all its files."""
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
