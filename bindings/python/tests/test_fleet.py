"""Dask distributed with a worker that is killed, and a run that goes on.

``MWD_FLEET_RECORDINGS=1000 pytest tests/test_fleet.py`` does it with a thousand recordings, in some minutes.
"""

import gzip
import os
import signal
import threading
import time

import numpy as np
import pandas as pd
import pytest

import meerkat_mwd as mwd
from meerkat_mwd import fleet

from test_package import SCENARIO, run

import dask.distributed as dask

BAD = "t_s,gx,gy,gz,ax,ay,az\n0,0,0,0,0,0,9.8\n0.01,0,oops,0,0,0,9.8\n"

#: Sound recordings; two more are not.
COUNT = int(os.environ.get("MWD_FLEET_RECORDINGS", "10"))


@pytest.fixture(scope="module")
def recordings(tmp_path_factory):
    folder = tmp_path_factory.mktemp("recordings")
    scenario = folder / "scenario.toml"
    lines = SCENARIO.read_text().splitlines()
    scenario.write_text("\n".join("duration_s = 60.0" if line.startswith("duration_s") else line for line in lines))
    for seed in range(1, COUNT + 1):
        mwd.simulate(scenario, seed)[0].write(folder / f"{seed:02}.csv.gz")
    # One that knows its probe and its day.
    named = folder / "01.csv.gz"
    named.write_bytes(gzip.compress(b"# serial = S7\n# date = 2026-03-31\n" + gzip.decompress(named.read_bytes()), 1))
    (folder / "bad.csv").write_text(BAD)
    return [*map(str, sorted(folder.glob("*.csv*"))), str(folder / "gone.csv")]


def test_a_killed_worker_costs_nothing_but_its_recording(recordings, tmp_path):
    results = str(tmp_path / "results")
    done = tmp_path / "results" / "recordings"
    with dask.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster, dask.Client(cluster) as client:
        victim = cluster.workers[0].pid
        killed = threading.Event()

        def kill():
            while not done.exists() or len(list(done.glob("*.parquet"))) < max(2, COUNT // 3):
                time.sleep(0.01)
            os.kill(victim, signal.SIGKILL)
            killed.set()

        thread = threading.Thread(target=kill)
        thread.start()
        first = fleet.run(recordings, client, results)
        thread.join()
        assert killed.is_set() and first["flown"] >= COUNT - 2
        # The file that is not there may come: it is looked for again.
        assert fleet.run(recordings, client, results) == {"flown": 1, "kept": len(recordings) - 1}
    table = fleet.read(results)
    assert sorted(table["path"]) == sorted(recordings), "every row, none twice"
    assert table["path"].is_unique and len(table) == COUNT + 2
    bad = table.set_index("path").loc[[path for path in recordings if "bad" in path or "gone" in path]]
    assert not bad["ok"].any() and bad["error"].str.contains("line 3, column gy|cannot be read").all()
    one = mwd.replay(recordings[0]).json
    row = table.set_index("path").loc[recordings[0]]
    assert row["identification_final_P_4"] == one["identification"]["final"]["P"][4]
    assert (row["trace_serial"], row["trace_date"]) == ("S7", "2026-03-31")
    windows = fleet.read(results, "windows")
    assert len(windows[windows["path"] == recordings[0]]) == len(one["identification"]["windows"])
    assert set(fleet.read(results, "stations").columns) >= {"path", "hash", "inclination_deg", "grade"}


def test_the_tables_are_those_of_batch(recordings, tmp_path):
    # One that rests: its row says in words what is missing.
    still, noise = tmp_path / "still.csv", np.random.default_rng(1).normal(size=(9_000, 3))
    mwd.trace(np.arange(9_000) * 0.01, 1e-3 * noise, [0.1, 0.2, 9.8] + 0.01 * noise, [20.0, 1.0, 45.0] + 0.1 * noise).write(still)
    some = [recordings[0], recordings[1], str(still), *(path for path in recordings if "bad" in path)]
    results = str(tmp_path / "results")
    assert all(fleet._one(path, results, {"seed": 3}) for path in some)
    run("batch", *some, "-o", tmp_path / "all.parquet", "--seed", 3)
    for name, file in fleet.TABLES.items():
        theirs = pd.read_parquet(tmp_path / file)
        ours = fleet.read(results, name)
        assert len(ours) > 2 and set(ours["hash"]).isdisjoint(theirs["hash"]), "another program"
        by = [column for column in ["path", "kind", "window", "t_start_s"] if column in ours]
        both = [table.drop(columns="hash").sort_values(by).reset_index(drop=True) for table in (ours, theirs)]
        pd.testing.assert_frame_equal(*both, check_exact=True)
    assert isinstance(fleet.read(results).set_index("path").loc[str(still), "diagnosis_missing"], str)
    # The same rows without an engine.
    rows = fleet.fly(recordings[0], open(recordings[0], "rb").read(), seed=3)
    assert [len(rows[name]) for name in fleet.TABLES] == [(fleet.read(results, name)["path"] == recordings[0]).sum() for name in fleet.TABLES]


def test_a_worker_whose_disk_fails_is_no_fault_of_the_recording(tmp_path, monkeypatch):
    recording, results = tmp_path / "run.csv", str(tmp_path / "results")
    mwd.simulate(SCENARIO, seed=1)[0].write(recording)
    # Rows over a megabyte go to a temporary file, whose folder is gone.
    monkeypatch.setenv("TMPDIR", str(tmp_path / "none"))
    assert fleet._one(str(recording), results, {})
    assert "temporary file" in fleet.read(results)["error"][0]
    monkeypatch.undo()
    assert fleet._one(str(recording), results, {})
    assert fleet.read(results)["ok"].tolist() == [True]


def test_a_result_is_known_by_bytes_and_takes_the_place_of_the_former_one(tmp_path, monkeypatch):
    # A bad recording is flown at once, and kept as any other.
    recording, config, elsewhere = tmp_path / "bad.csv", tmp_path / "config.toml", tmp_path / "same.toml"
    results = str(tmp_path / "results")
    recording.write_text(BAD)
    config.write_text("seed = 1\n")
    elsewhere.write_text("seed = 1\n")

    def flown(**options):
        was_flown = fleet._one(str(recording), results, options)
        assert len(fleet.read(results)) == 1, "one row a recording, whatever changed"
        return was_flown

    assert flown() and not flown()
    assert flown(config=str(config)) and not flown(config=str(config)), "a configuration"
    assert not flown(config=elsewhere), "the same one under another name"
    config.write_text("seed = 2\n")
    assert flown(config=str(config)) and not flown(config=str(config)), "other bytes of the same name"
    assert flown(seed=2) and not flown(seed=2)
    monkeypatch.setattr(fleet, "_library", lambda: b"another build")
    assert flown(seed=2) and not flown(seed=2)
    # One that could not be read is tried again, and its row goes when it comes.
    recording.rename(tmp_path / "away")
    assert flown() and flown()
    assert "cannot be read" in fleet.read(results)["error"][0]
    (tmp_path / "away").rename(recording)
    assert flown() and "line 3" in fleet.read(results)["error"][0]
    with pytest.raises(FileNotFoundError):
        flown(config=str(tmp_path / "none.toml"))


def test_the_librarys_hash_is_of_its_file():
    first = fleet._library()
    assert len(first) == 16 and first != bytes(16) and fleet._native.__file__ is not None
