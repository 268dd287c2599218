"""A thousand simulated recordings through `mwd batch`: one processor against two, kill -9 and resume, and who reads it.

    cargo build --profile desk -p host-tests
    MWD_PROGRAM=target/desk/mwd python bindings/python/tests/thousand.py

Needs Linux, DuckDB and pandas. ``--recordings`` takes fewer, ``--keep FOLDER`` keeps the recordings for another time.
Ends with 1 if something does not hold.

What is judged does not depend on what else the machine does. The speed of one processor is that of its own time. Two
processors are as much faster than one as their run takes less processor time, times the threads that have work at the
same time: those that run and, on a machine that does more, those that the kernel keeps waiting for a processor
(``/proc/PID/task/*/schedstat``). A machine that does nothing else shows the same by the clock, which is printed beside
it.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import re
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import duckdb
import pandas as pd

ROOT = Path(__file__).resolve().parents[3]
PROGRAM = Path(os.environ.get("MWD_PROGRAM", ROOT / "target/desk/mwd"))
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


@dataclass
class Run:
    """Cost of a run, seconds, and what it printed."""

    clock: float
    processor: float
    #: Of all its threads, running or waiting for a processor.
    ready: float
    told: str

    @property
    def threads(self) -> float:
        """Threads that have work at the same time, on the mean."""
        return self.ready / self.clock


def batch(recordings: Path, results: Path, jobs: int) -> Run:
    """Flies the recordings and watches the program's threads."""
    command = [PROGRAM, "batch", recordings, "-o", results, "--jobs", str(jobs)]
    began = time.perf_counter()
    child = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    ready: dict[str, int] = {}
    while not (ended := os.wait4(child.pid, os.WNOHANG))[0]:
        for thread in Path(f"/proc/{child.pid}/task").glob("*/schedstat"):
            # A thread may end meanwhile; what it had run until then is kept.
            with contextlib.suppress(OSError, ValueError):
                ran_ns, waited_ns, _ = map(int, thread.read_text().split())
                ready[thread.parent.name] = ran_ns + waited_ns
        time.sleep(0.01)
    clock, (_, status, usage) = time.perf_counter() - began, ended
    child.returncode = os.waitstatus_to_exitcode(status)
    assert child.returncode == 0 and child.stdout is not None, command
    return Run(clock, usage.ru_utime + usage.ru_stime, 1e-9 * sum(ready.values()), child.stdout.read())


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
    told = batch(recordings, results, jobs).told
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
    # A figure stands in a file, too, as soon as it is known.
    sys.stdout.reconfigure(line_buffering=True)
    with tempfile.TemporaryDirectory() as temporary:
        recordings = arguments.keep or Path(temporary) / "recordings"
        simulated(recordings, count, arguments.seconds)
        results = {name: Path(temporary) / f"{name}.parquet" for name in ["one", "two", "killed"]}
        runs = {}
        for name, jobs in [("one", 1), ("two", 2)]:
            run = runs[name] = batch(recordings, results[name], jobs)
            print(f"--jobs {jobs}: {run.processor:.1f} s of processor time, {count * arguments.seconds / run.processor:.0f} times real "
                  f"time a processor; {run.threads:.2f} threads with work over {run.clock:.1f} s; {run.told.splitlines()[0]}")
        one, two = runs["one"], runs["two"]
        ratio = one.processor / two.processor * two.threads / one.threads
        print(f"two processors are {ratio:.2f} times as fast as one; by the clock of this machine {one.clock / two.clock:.2f} times")
        held.append(("1.9 times", ratio >= LEAST_RATIO))
        held.append(("2,500 times real time", count * arguments.seconds / one.processor >= LEAST_TIMES_REAL_TIME))
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
