"""Dask distributed with a worker that is killed, and a run that goes on."""

import gzip
import os
import signal
import threading
import time

import pytest

import meerkat_mwd as mwd
from meerkat_mwd import fleet

from test_package import SCENARIO

import dask.distributed as dask


@pytest.fixture(scope="module")
def recordings(tmp_path_factory):
    folder = tmp_path_factory.mktemp("recordings")
    scenario = folder / "scenario.toml"
    lines = SCENARIO.read_text().splitlines()
    scenario.write_text("\n".join("duration_s = 60.0" if line.startswith("duration_s") else line for line in lines))
    for seed in range(1, 11):
        mwd.simulate(scenario, seed)[0].write(folder / f"{seed:02}.csv.gz")
    # One that knows its probe and its day.
    named = folder / "01.csv.gz"
    named.write_bytes(gzip.compress(b"# serial = S7\n# date = 2026-03-31\n" + gzip.decompress(named.read_bytes()), 1))
    (folder / "bad.csv").write_text("t_s,gx,gy,gz,ax,ay,az\n0,0,0,0,0,0,9.8\n0.01,0,oops,0,0,0,9.8\n")
    return [*map(str, sorted(folder.glob("*.csv*"))), str(folder / "gone.csv")]


def test_a_killed_worker_costs_nothing_but_its_recording(recordings, tmp_path):
    results = str(tmp_path / "results")
    done = tmp_path / "results" / "recordings"
    with dask.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster, dask.Client(cluster) as client:
        victim = cluster.workers[0].pid
        killed = threading.Event()

        def kill():
            while not done.exists() or len(list(done.glob("*.parquet"))) < 2:
                time.sleep(0.01)
            os.kill(victim, signal.SIGKILL)
            killed.set()

        thread = threading.Thread(target=kill)
        thread.start()
        first = fleet.run(recordings, client, results)
        thread.join()
        assert killed.is_set() and first["flown"] >= 8
        # The file that is not there may come: it is looked for again.
        assert fleet.run(recordings, client, results) == {"flown": 1, "kept": len(recordings) - 1}
    table = fleet.read(results)
    assert sorted(table["path"]) == sorted(recordings), "every row, none twice"
    assert not list(done.glob(".*")) or len(table) == len(recordings)
    bad = table.set_index("path").loc[[path for path in recordings if "bad" in path or "gone" in path]]
    assert not bad["ok"].any() and bad["error"].str.contains("line 3, column gy|cannot be read").all()
    one = mwd.replay(recordings[0]).json
    row = table.set_index("path").loc[recordings[0]]
    assert row["identification_final_P_4"] == one["identification"]["final"]["P"][4]
    assert (row["trace_serial"], row["trace_date"]) == ("S7", "2026-03-31")
    windows = fleet.read(results, "windows")
    assert len(windows[windows["path"] == recordings[0]]) == len(one["identification"]["windows"])
    assert set(fleet.read(results, "stations").columns) >= {"path", "hash", "inclination_deg", "grade"}
