"""A thousand simulated recordings through `mwd batch`: one processor against two, kill -9 and resume, and who reads it.

    cargo build --release -p host-tests
    MWD_PROGRAM=target/release/mwd python bindings/python/tests/thousand.py

Needs DuckDB and pandas, and a machine that does nothing else: the figures are its. ``--recordings`` takes fewer,
``--keep FOLDER`` keeps the recordings for another time. Ends with 1 if something does not hold.
"""

from __future__ import annotations

import argparse
import os
import re
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import duckdb
import pandas as pd

ROOT = Path(__file__).resolve().parents[3]
PROGRAM = Path(os.environ.get("MWD_PROGRAM", ROOT / "target/release/mwd"))
#: What two processors and one have to reach.
LEAST_RATIO, LEAST_TIMES_REAL_TIME = 1.9, 2500.0


def simulated(folder: Path, count: int, seconds: float) -> None:
    """Recordings that are not there yet."""
    folder.mkdir(parents=True, exist_ok=True)
    scenario = folder / "scenario.toml"
    text = (ROOT / "host-tests/scenarios/drilling_45deg.toml").read_text()
    scenario.write_text(re.sub(r"(?m)^duration_s = .*$", f"duration_s = {seconds}", text))

    def one(seed: int) -> None:
        file = folder / f"{seed:04}.csv.gz"
        if not file.exists():
            subprocess.run([PROGRAM, "simulate", scenario, "-o", file, "--seed", str(seed), "--quiet"], check=True)

    with ThreadPoolExecutor(os.cpu_count()) as pool:
        list(pool.map(one, range(1, count + 1)))


def batch(recordings: Path, results: Path, jobs: int) -> tuple[float, str]:
    """Seconds that a run takes, and what it prints."""
    began = time.perf_counter()
    command = [PROGRAM, "batch", recordings, "-o", results, "--jobs", str(jobs)]
    told = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    return time.perf_counter() - began, told


def parts(results: Path) -> dict[str, int]:
    """Results that are kept, with the times of their files."""
    folder = results.with_name(results.name + ".parts")
    return {file.name: file.stat().st_mtime_ns for file in folder.glob("*.json")}


def killed_and_resumed(recordings: Path, results: Path, count: int, jobs: int) -> str:
    """Kills a run in its middle, starts it again and returns what that prints."""
    child = subprocess.Popen([PROGRAM, "batch", recordings, "-o", results, "--jobs", str(jobs)], stdout=subprocess.DEVNULL)
    while len(parts(results)) < count // 2:
        assert child.poll() is None, "it ended before it could be killed"
        time.sleep(0.001)
    child.kill()
    child.wait()
    before = parts(results)
    _, told = batch(recordings, results, jobs)
    after = parts(results)
    assert not (before.items() - after.items()), "what was there is written again"
    assert told.startswith(f"{count} recordings: {count - len(before)} flown now, {len(before)} from before; 0 bad"), told
    return f"killed at {len(before)} of {count}; {told.splitlines()[0]}"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--recordings", type=int, default=1000)
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--keep", type=Path)
    arguments = parser.parse_args()
    count, held = arguments.recordings, []
    with tempfile.TemporaryDirectory() as temporary:
        recordings = arguments.keep or Path(temporary) / "recordings"
        simulated(recordings, count, arguments.seconds)
        results = {name: Path(temporary) / f"{name}.parquet" for name in ["one", "two", "killed"]}
        took = {}
        for name, jobs in [("one", 1), ("two", 2)]:
            took[name], told = batch(recordings, results[name], jobs)
            print(f"--jobs {jobs}: {took[name]:.1f} s, {count * arguments.seconds / took[name] / jobs:.0f} times real time "
                  f"a processor; {told.splitlines()[0]}")
        ratio = took["one"] / took["two"]
        print(f"two processors are {ratio:.2f} times as fast as one")
        held.append(("1.9 times", ratio >= LEAST_RATIO))
        held.append(("2,500 times real time", count * arguments.seconds / took["one"] >= LEAST_TIMES_REAL_TIME))
        print(killed_and_resumed(recordings, results["killed"], count, 2))
        for ending in ["", ".windows", ".stations"]:
            files = {name: path.with_suffix(f"{ending}.parquet") for name, path in results.items()}
            texts = {file.read_bytes() for file in files.values()}
            held.append((f"the same bytes of {ending or 'recordings'} by one, two and a killed run", len(texts) == 1))
            table = pd.read_parquet(files["killed"])
            query = f"select count(*), count(distinct path) from '{files['killed']}'"
            rows, paths = duckdb.sql(query).fetchall()[0]
            print(f"{files['killed'].name}: {len(table)} rows by pandas, {rows} of {paths} recordings by DuckDB")
            held.append((f"pandas and DuckDB agree on {ending or 'recordings'}", len(table) == rows))
            if not ending:
                held.append(("every recording, none twice", rows == paths == count and bool(table["ok"].all())))
    for what, is_so in held:
        print(f"{'holds' if is_so else 'DOES NOT HOLD'}: {what}")
    return 0 if all(is_so for _, is_so in held) else 1


if __name__ == "__main__":
    sys.exit(main())
