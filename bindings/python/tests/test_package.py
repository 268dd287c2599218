"""The package against the program, against arrays, and against VQF's frame."""

import json
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


def test_a_dataframe_keeps_all_columns_of_its_file():
    import pandas as pd

    count = np.arange(200)
    table = pd.DataFrame({"t_s": 0.01 * count, "gx": 0.1, "gy": 0.0, "gz": 0.0, "ax": 0.0, "ay": 0.0, "az": -9.8})
    table = table.assign(qw=1.0, qx=0.0, qy=0.0, qz=0.0, rest=count < 50, movement=1, sample_flags=0, label="a", depth=3.0)
    table.loc[7, "qw"] = np.nan
    table.loc[9, "sample_flags"] = 1
    trace = mwd.trace(table)
    reference = trace.arrays()["reference"]
    assert reference.shape == (200, 4) and np.isnan(reference[7]).all() and (reference[8] == [1, 0, 0, 0]).all()
    assert trace.notes == ["ignored columns: 'label', 'depth'"]
    flown = mwd.replay(trace).json
    assert flown["reference"] is not None and flown["trace"]["missing"]["reference"] == 1
    for lacking in ["mx", "my", "mz"]:
        with pytest.raises(ValueError, match="column m[xyz]: the column is missing"):
            mwd.trace(table.assign(**{lacking: 20.0}))
    with pytest.raises(ValueError, match="column gx: the column is missing"):
        mwd.trace(table.drop(columns="gx"))
    # One time that jumps ahead costs its own row alone, as in a file.
    table.loc[100, "t_s"] = 9e6
    assert mwd.trace(table).dropped == (0, 1)


def test_late_and_repeated_rows_are_dropped_and_counted_as_in_a_file(tmp_path):
    import pandas as pd

    trace, _, _ = mwd.simulate(SCENARIO, seed=3)
    trace.write(tmp_path / "whole.csv")
    table = pd.read_csv(tmp_path / "whole.csv", comment="#").iloc[:6000]
    rows = [*range(2000), 1999, *range(2000, 3000), 2990, *range(3000, 6000)]
    troubled = table.iloc[rows]
    troubled.to_csv(tmp_path / "troubled.csv", index=False)
    of_frame = mwd.trace(troubled)
    of_file = mwd.read(tmp_path / "troubled.csv")
    assert of_frame.dropped == of_file.dropped == (1, 1) and len(of_frame) == 6000
    assert of_frame.notes == ["2 rows dropped: 1 repeat a time, 1 are out of order; the first is row 2000"]
    of_arrays = mwd.trace(*(troubled[names].to_numpy() for names in ["t_s", ["gx", "gy", "gz"], ["ax", "ay", "az"], ["mx", "my", "mz"]]))
    assert of_arrays.dropped == (1, 1)
    ahead = table["t_s"].to_numpy(copy=True)
    ahead[2000] += 9000.0
    arrays = [table[names].to_numpy() for names in [["gx", "gy", "gz"], ["ax", "ay", "az"]]]
    of_ahead = mwd.trace(ahead, *arrays)
    assert of_ahead.dropped == (0, 1) and len(of_ahead) == len(table) - 1
    with pytest.raises(ValueError, match="row 2000: time 90.* is far ahead"):
        mwd.trace(ahead, *arrays, strict=True)
    flown = mwd.replay(troubled)
    assert np.array_equal(flown.attitude()["q"], mwd.replay(table).attitude()["q"], equal_nan=True)
    assert flown.json["trace"]["dropped"] == {"repeated": 1, "late": 1}
    run("replay", tmp_path / "troubled.csv", "--json", tmp_path / "j.json")
    assert json.loads((tmp_path / "j.json").read_text())["trace"]["dropped"] == flown.json["trace"]["dropped"]
    for strict in [
        lambda: mwd.trace(troubled, strict=True),
        lambda: mwd.replay(troubled, strict=True),
        lambda: mwd.replay(of_frame, strict=True),
    ]:
        with pytest.raises(ValueError, match="row 2000"):
            strict()
    with pytest.raises(ValueError, match="line 2002, column t_s: time repeats"):
        mwd.read(tmp_path / "troubled.csv", strict=True)
    assert mwd.replay(table, strict=True).json["trace"]["dropped"] == {"repeated": 0, "late": 0}


def test_sample_by_sample_is_the_replay():
    trace, _, _ = mwd.simulate(SCENARIO, seed=5)
    arrays = {name: values[:12_000] for name, values in trace.arrays().items()}
    flight = mwd.replay(mwd.trace(*(arrays[name] for name in ["t_s", "gyr", "acc", "mag", "temperature"])))
    whole = flight.attitude()
    probe = mwd.Probe(100.0, "[identification]\nmotion = 'hand'")
    assert probe.take_report() is None and probe.take_diagnosis() is None
    last = None
    for row in range(12_000):
        mag = arrays["mag"][row]
        last = probe.push(arrays["t_s"][row], arrays["gyr"][row], arrays["acc"][row], None if np.isnan(mag[0]) else mag,
                          float(arrays["temperature"][row])) or last
    assert np.array_equal(np.float32(last["q"]), whole["q"][-1])
    # Windows that closed while samples came; a flight's last one closes at its end.
    reports = list(iter(probe.take_report, None))
    windows = flight.json["identification"]["windows"]
    assert 1 <= len(reports) <= len(windows) and reports == windows[: len(reports)]
    diagnoses = list(iter(probe.take_diagnosis, None))
    assert len(diagnoses) == len(reports) and probe.take_diagnosis() is None
    assert [diagnosis["t_end_s"] for diagnosis in diagnoses] == [report["t_end_s"] for report in reports]
    assert {"verdict", "effects", "nis", "remainder"} <= set(diagnoses[0])
    if len(reports) == len(windows):
        found = flight.json["diagnosis"]
        assert [effect["name"] for effect in diagnoses[-1]["effects"]] == [effect["name"] for effect in found["effects"]]


def test_a_magnet_is_told_when_it_comes_and_when_it_leaves():
    probe, told = mwd.Probe(100.0), []
    turn, rate = np.eye(3), lambda t: np.array([1.5 * np.sin(1.3 * t), np.sin(1.1 * t + 1.7), 1.2 * np.sin(0.8 * t)])
    for row in range(6_000):
        t = 0.01 * row
        w = rate(t) * (t > 5)
        k = np.array([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]]) * 0.01
        turn = turn @ (np.eye(3) + k + k @ k / 2)
        magnet = np.array([6.0, -4.0, 9.0]) * (20 <= t < 40)
        probe.push(t, w, turn.T @ [0, 0, -9.8], turn.T @ [20, 0, 45] + magnet)
        told.extend(iter(probe.take_hard_iron_interval, None))
    came, left = told
    assert came["to_s"] is None and abs(left["from_s"] - 20) < 0.3 and abs(left["to_s"] - 40) < 0.3
    assert np.allclose(left["offset_ut"], [6, -4, 9], atol=1) and left["field_use"] == "Corrected"


def test_a_probe_that_is_frozen_closes_its_last_window_before_that():
    trace, _, _ = mwd.simulate(SCENARIO, seed=5)
    arrays = {name: values[:8_000] for name, values in trace.arrays().items()}
    probe = mwd.Probe(100.0)
    at_s = arrays["t_s"][0] + 40.0
    probe.freeze(at_s)
    for t_s, gyr, acc, mag in zip(*(arrays[name] for name in ["t_s", "gyr", "acc", "mag"])):
        probe.push(t_s, gyr, acc, None if np.isnan(mag[0]) else mag)
    reports = list(iter(probe.take_report, None))
    assert [round(report["t_end_s"] - at_s, 3) for report in reports] == [-1.0]


def test_wrong_input_says_what_is_wrong(tmp_path):
    good = np.zeros((10, 3))
    with pytest.raises(ValueError, match=r"gyr must have the shape \(10, 3\)"):
        mwd.trace(np.arange(10) * 0.01, np.zeros((9, 3)), good)
    with pytest.raises(ValueError, match="row 5: time 0.01 s is not after.*1 rows dropped"):
        mwd.trace([0, 0.005, 0.01, 0.015, 0.02, 0.01, 0.03, 0.04, 0.05, 0.06], good, good)
    with pytest.raises(ValueError, match="nobody is no key"):
        mwd.trace(np.arange(10) * 0.01, good, good, nobody=1)
    table = {"t_s": np.arange(10) * 0.01, **{name: np.ones(10) for name in "gx gy gz ax ay az".split()}}
    with pytest.raises(TypeError, match="mx my mz"):
        mwd.trace(table, mag=good)
    with pytest.raises(ValueError, match="cannot be opened"):
        mwd.read(tmp_path / "none.csv")
    with pytest.raises(ValueError, match="hold_out"):
        mwd.replay(MAGNET, hold_out=2.0)


def test_infinity_is_no_missing_value():
    import pandas as pd

    t_s, good, there = np.arange(10) * 0.01, np.ones((10, 3)), np.ones(10)
    for kind in [np.inf, -np.inf, 1e300]:
        spoilt = good.copy()
        spoilt[3, 1] = kind
        for name, arrays in [("gyr", (spoilt, good)), ("acc", (good, spoilt)), ("mag", (good, good, spoilt))]:
            with pytest.raises(ValueError, match=rf"row 3, column {name}\[1\]: not a finite number"):
                mwd.trace(t_s, *arrays)
        with pytest.raises(ValueError, match="row 3, column temperature: not a finite number"):
            mwd.trace(t_s, good, good, temperature=np.where(t_s == t_s[3], kind, 20.0))
        table = pd.DataFrame({"t_s": t_s, **{name: there for name in "gx gy gz ax ay az".split()}})
        table.loc[3, "gy"] = kind
        with pytest.raises(ValueError, match="row 3, column gy: .* is not a finite number"):
            mwd.trace(table)
    spoilt = good.copy()
    spoilt[3, 1] = np.nan
    assert np.isnan(mwd.trace(t_s, spoilt, good).arrays()["gyr"][3]).all()


def test_a_batch_without_field_advances_the_filter_that_takes_one():
    trace, _, _ = mwd.simulate(SCENARIO, seed=2)
    arrays = {name: trace.arrays()[name][:6_000] for name in ["true_rate", "acc", "mag"]}
    gap = arrays["mag"].copy()
    gap[2_000:4_000] = np.nan
    whole = mwd.AttitudeFilter(0.01).updateBatch(arrays["true_rate"], arrays["acc"], gap)
    parts = mwd.AttitudeFilter(0.01)
    for rows, has_field in [(slice(0, 2_000), True), (slice(2_000, 4_000), False), (slice(4_000, 6_000), True)]:
        rate, force, field = (arrays[name][rows] for name in ["true_rate", "acc", "mag"])
        found = parts.updateBatch(rate, force, field if has_field else None)
    for name in ["quat6D", "quat9D", "bias"]:
        assert np.array_equal(found[name], whole[name][4_000:], equal_nan=True), name


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
    own = {"quatNED"}
    assert set(found) == own | {"quat6D", "quat9D", "delta", "bias", "biasSigma", "restDetected", "magDistDetected"}
    without = mwd.AttitudeFilter(step).updateBatch(arrays["true_rate"], arrays["acc"])
    assert set(without) == own | {"quat6D", "bias", "biasSigma", "restDetected"}
    assert np.array_equal(without["quat6D"], found["quat6D"], equal_nan=True)
    # The same names, shapes and kinds as VQF's.
    vqf = pytest.importorskip("vqf")
    contiguous = [np.nan_to_num(np.ascontiguousarray(arrays[name], dtype=float)) for name in ["true_rate", "acc", "mag"]]
    theirs = vqf.VQF(step).updateBatch(*contiguous)
    assert set(theirs) == set(found) - own
    assert all(found[name].shape == theirs[name].shape and found[name].dtype.kind == theirs[name].dtype.kind for name in theirs)
    # A bias is found, at rest, within its deviation; a strong magnet is refused.
    still = np.zeros((6_000, 3))
    bias = np.array([0.002, -0.003, 0.001])
    noise = np.random.default_rng(1).normal(size=(6_000, 3))
    field = np.tile([20.0, 1.0, 45.0], (6_000, 1))
    field[4_000:] += [30.0, 30.0, 0.0]
    at_rest = mwd.AttitudeFilter(0.01).updateBatch(bias + 1e-3 * noise, still + [0.1, 0.2, 9.8] + 0.01 * noise, field)
    assert not at_rest["restDetected"][:100].any() and at_rest["restDetected"][-100:].all()
    assert (np.abs(at_rest["bias"][3_900] - bias) < 4 * at_rest["biasSigma"][3_900]).all()
    assert at_rest["biasSigma"][3_900] < 0.2 * at_rest["biasSigma"][0]
    assert at_rest["magDistDetected"][4_100:4_500].mean() > 0.9 and not at_rest["magDistDetected"][1_000:4_000].any()
    # quat9D is quat6D, turned by delta about up, to within what their tilts differ by.
    half = found["delta"][-1] / 2
    w, x, y, z = found["quat6D"][-1]
    turned = [np.cos(half) * w - np.sin(half) * z, np.cos(half) * x - np.sin(half) * y,
              np.cos(half) * y + np.sin(half) * x, np.cos(half) * z + np.sin(half) * w]
    assert abs(np.dot(turned, found["quat9D"][-1])) > np.cos(np.radians(1.5))
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


def test_calibrate_survey_and_diagnose_say_what_the_program_says(tmp_path):
    out = tmp_path / "out.json"
    positions = [ROOT / "host-tests/traces/multipos_mpu9150_imu0.csv.gz"]
    record = tmp_path / "record.toml"
    run("calibrate", *positions, "--json", out, "-o", record)
    calibration = mwd.calibrate(positions)
    assert calibration.account == json.loads(out.read_text())
    assert calibration.toml == record.read_text()

    stations = ROOT / "host-tests/tests/surveys/forty_stations.csv"
    settings = ROOT / "host-tests/tests/surveys/forty_stations.toml"
    with_settings = ["--run", settings] if settings.exists() else []
    run("survey", stations, *with_settings, "--json", out)
    surveyed = mwd.survey(stations.read_text(), settings.read_text() if with_settings else None)
    assert surveyed == json.loads(out.read_text())

    run("diagnose", MAGNET, "--hold-out", 0.5, "--json", out)
    assert mwd.diagnose(MAGNET, hold_out=0.5) == json.loads(out.read_text())["diagnosis"]
