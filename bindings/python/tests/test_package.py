"""The package against the program, against arrays, and against VQF's frame."""

import os
import subprocess
import threading
import time
from pathlib import Path

import numpy as np
import pytest

import meerkat_mwd as mwd

ROOT = Path(__file__).resolve().parents[3]
PROGRAM = Path(os.environ.get("MWD_PROGRAM", ROOT / "target/debug/mwd"))
MAGNET = ROOT / "host-tests/traces/broad_35_attached_magnet_63s.csv.gz"
SCENARIO = ROOT / "host-tests/scenarios/drilling_45deg.toml"


def run(*arguments):
    done = subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.fixture(scope="session")
def flight():
    return mwd.replay(MAGNET, hold_out=0.5)


def test_a_flight_has_the_bytes_of_the_program(flight, tmp_path):
    files = {name: tmp_path / name for name in ["a.csv", "r.csv", "s.csv", "j.json"]}
    run("replay", MAGNET, "--hold-out", 0.5, "--attitude", files["a.csv"], "--rates", files["r.csv"],
        "--surveys", files["s.csv"], "--json", files["j.json"])
    flight.write_attitude(tmp_path / "a2.csv")
    flight.write_rates(tmp_path / "r2.csv")
    assert (tmp_path / "a2.csv").read_bytes() == files["a.csv"].read_bytes()
    assert (tmp_path / "r2.csv").read_bytes() == files["r.csv"].read_bytes()
    assert flight.surveys_csv == files["s.csv"].read_text()
    assert flight.json_text == files["j.json"].read_text()


def test_arrays_are_the_flight(flight):
    attitude = flight.attitude()
    count = flight.json["trace"]["samples"]
    assert attitude["q"].shape == (count, 4) and attitude["t_s"].shape == (count,)
    there = np.isfinite(attitude["q"][:, 0])
    assert there.mean() > 0.9
    assert np.allclose(np.linalg.norm(attitude["q"][there], axis=1), 1, atol=1e-3)
    assert flight.rates()["rate"].shape == (count, 3) and flight.p.shape == (3, 3)
    frame = flight.attitude_frame()
    assert list(frame.columns[:5]) == ["t_s", "qw", "qx", "qy", "qz"] and len(frame) == count
    assert len(flight.windows()) == len(flight.json["identification"]["windows"])


def test_a_dataframe_flies_as_its_file(tmp_path):
    import pandas as pd

    trace, p, b = mwd.simulate(SCENARIO, seed=3)
    file = tmp_path / "trace.csv"
    run("simulate", SCENARIO, "-o", file, "--seed", 3)
    trace.write(tmp_path / "own.csv")
    assert (tmp_path / "own.csv").read_bytes() == file.read_bytes()
    assert p.shape == (3, 3) and b.shape == (3,) and not np.allclose(p, np.eye(3))
    table = pd.read_csv(file, comment="#").iloc[:6000]
    keys = dict(line[2:].strip().split(" = ", 1) for line in file.read_text().splitlines() if line.startswith("#"))
    of_frame = mwd.replay(mwd.trace(table, **keys)).attitude()["q"]
    head = [line for line in file.read_text().splitlines()]
    first = next(i for i, line in enumerate(head) if not line.startswith("#"))
    (tmp_path / "cut.csv").write_text("\n".join(head[: first + 6001]) + "\n")
    assert np.array_equal(of_frame, mwd.replay(tmp_path / "cut.csv").attitude()["q"], equal_nan=True)


def test_sample_by_sample_is_the_replay():
    trace, _, _ = mwd.simulate(SCENARIO, seed=5)
    arrays = {name: values[:3000] for name, values in trace.arrays().items()}
    whole = mwd.replay(mwd.trace(arrays["t_s"], arrays["gyr"], arrays["acc"], arrays["mag"], arrays["temperature"])).attitude()
    probe = mwd.Probe(100.0, "[identification]\nmotion = 'hand'")
    last = None
    for row in range(3000):
        mag = arrays["mag"][row]
        last = probe.push(arrays["t_s"][row], arrays["gyr"][row], arrays["acc"][row], None if np.isnan(mag[0]) else mag,
                          float(arrays["temperature"][row])) or last
    assert np.array_equal(np.float32(last["q"]), whole["q"][-1])


def test_wrong_input_says_what_is_wrong(tmp_path):
    good = np.zeros((10, 3))
    with pytest.raises(ValueError, match=r"gyr must have the shape \(10, 3\)"):
        mwd.trace(np.arange(10) * 0.01, np.zeros((9, 3)), good)
    with pytest.raises(ValueError, match="row 5: time 0.01 s is not after"):
        mwd.trace([0, 0.005, 0.01, 0.015, 0.02, 0.01, 0.03, 0.04, 0.05, 0.06], good, good)
    with pytest.raises(ValueError, match="nobody is no key"):
        mwd.trace(np.arange(10) * 0.01, good, good, nobody=1)
    with pytest.raises(ValueError, match="cannot be opened"):
        mwd.read(tmp_path / "none.csv")
    with pytest.raises(ValueError, match="hold_out"):
        mwd.replay(MAGNET, hold_out=2.0)


def test_an_import_is_refused_with_the_fix(tmp_path):
    arrays = mwd.read(MAGNET).arrays()
    columns = [arrays["t_s"] * 1e3, *np.degrees(arrays["gyr"].T)[[1, 0, 2]], *arrays["acc"].T, *arrays["mag"].T]
    source = tmp_path / "log.csv"
    np.savetxt(source, np.stack(columns, axis=1), delimiter=",", header="t_ms,gx,gy,gz,ax,ay,az,mx,my,mz", comments="")
    with pytest.raises(ValueError, match="axes of the gyro are wrong"):
        mwd.import_recording(source)
    map_file = tmp_path / "map.toml"
    map_file.write_text("[gyro]\ncolumns = ['gy', 'gx', 'gz']\n")
    imported = mwd.import_recording(source, map=map_file)
    assert np.allclose(imported.trace.arrays()["gyr"], arrays["gyr"], atol=1e-5, equal_nan=True)


def test_other_threads_run_during_a_flight():
    trace = mwd.read(MAGNET)
    beats, done = [], threading.Event()

    def beat():
        while not done.is_set():
            beats.append(time.perf_counter())
            time.sleep(0.002)

    thread = threading.Thread(target=beat)
    thread.start()
    began = time.perf_counter()
    mwd.replay(trace)
    ended = time.perf_counter()
    done.set()
    thread.join()
    within = [t for t in beats if began < t < ended]
    assert len(within) > 10 * (ended - began), (len(within), ended - began)


def test_update_batch_has_vqfs_frame():
    trace, _, _ = mwd.simulate(SCENARIO, seed=2)
    arrays = trace.arrays()
    step = float(np.median(np.diff(arrays["t_s"])))
    truth = arrays["reference"]
    found = mwd.AttitudeFilter(step).updateBatch(arrays["true_rate"], arrays["acc"], arrays["mag"])
    assert set(found) == {"quatNED", "quat9D"}
    end = slice(-2000, None)
    cosine = np.abs(np.sum(found["quatNED"][end] * truth[end], axis=1))
    assert np.degrees(2 * np.arccos(np.clip(cosine, 0, 1))).mean() < 3
    # East, north, up: the rotation of a body vector has its first two parts exchanged and the third turned.
    body = np.array([0.3, -0.5, 0.8])

    def rotate(q, v):
        w, u = q[:1], q[1:]
        return v + 2 * np.cross(u, np.cross(u, v) + w * v)

    ned, enu = (rotate(found[name][-1].astype(float), body) for name in ["quatNED", "quat9D"])
    assert np.allclose(enu, [ned[1], ned[0], -ned[2]], atol=1e-5)


def test_a_mat_file_of_scipy_is_imported(tmp_path):
    import scipy.io

    arrays = mwd.read(MAGNET).arrays()
    for compressed in [False, True]:
        file = tmp_path / f"log_{compressed}.mat"
        scipy.io.savemat(file, {"imu": {"time": arrays["t_s"], "gyro": arrays["gyr"], "acc": arrays["acc"].T, "mag": arrays["mag"]}},
                         do_compression=compressed)
        imported = mwd.import_recording(file)
        assert np.allclose(imported.trace.arrays()["mag"], arrays["mag"], equal_nan=True), imported.told


def test_tables_of_a_batch_are_read_by_pandas_and_duckdb(tmp_path):
    import duckdb
    import pandas as pd

    for seed in [1, 2]:
        trace, _, _ = mwd.simulate(SCENARIO, seed=seed)
        arrays = {name: values[:7500] for name, values in trace.arrays().items()}
        mwd.trace(arrays["t_s"], arrays["gyr"], arrays["acc"], arrays["mag"]).write(tmp_path / f"{seed}.csv")
    (tmp_path / "bad.csv").write_text("nothing\n")
    results = tmp_path / "all.parquet"
    run("batch", tmp_path, "-o", results)
    table = pd.read_parquet(results)
    assert list(table["ok"]) == [True, True, False] and table["trace_samples"][0] == 7500
    assert "no header row" in table["error"][2]
    first = mwd.replay(tmp_path / "1.csv").json
    assert table["identification_final_P_0"][0] == first["identification"]["final"]["P"][0]
    windows = str(results.with_suffix(".windows.parquet"))
    count = duckdb.sql(f"select count(*), count(reason) from \'{windows}\' where path like \'%1.csv\'").fetchall()[0]
    expected = first["identification"]["windows"]
    assert count == (len(expected), sum(window["reason"] is not None for window in expected))
    stations = duckdb.sql(f"select * from \'{results.with_suffix('.stations.parquet')}\'").df()
    assert stations["inclination_deg"].dtype == float
