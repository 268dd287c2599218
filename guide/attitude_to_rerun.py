"""Turns the attitude of a flight into a recording for rerun's viewer (https://rerun.io): a turning tool and all angles over time.

    pip install rerun-sdk
    cargo mwd replay TRACE --attitude attitude.csv
    python guide/attitude_to_rerun.py attitude.csv attitude.rrd
    rerun attitude.rrd
"""

import csv
import math
import sys

import rerun as rr


def main(attitude: str, recording: str) -> None:
    with open(attitude, newline="") as file:
        rows = list(csv.DictReader(file))
    # A row without an attitude is left out: the filter has not begun.
    rows = [row for row in rows if row["qw"]]
    if not rows:
        sys.exit(f"{attitude}: no row has an attitude")
    rr.init("meerkat-mwd", recording_id=attitude)
    rr.save(recording)
    # Earth frame: north, east, down.
    rr.log("earth", rr.ViewCoordinates.FRD, static=True)
    axes = rr.Arrows3D(vectors=[[1, 0, 0], [0, 1, 0], [0, 0, 2]], colors=[[196, 80, 10], [21, 127, 91], [31, 100, 180]])
    rr.log("earth/tool", axes, static=True)
    time = rr.TimeColumn("t", duration=[float(row["t_s"]) for row in rows])
    # Scalar last, from body to earth.
    turns = [[float(row[name]) for name in ("qx", "qy", "qz", "qw")] for row in rows]
    rr.send_columns("earth/tool", indexes=[time], columns=rr.Transform3D.columns(quaternion=turns))
    for name in (name for name in rows[0] if name.endswith("_deg")):
        values = [float(row[name]) if row[name] else math.nan for row in rows]
        kind = "deviations" if name.startswith("sigma") else "angles"
        rr.send_columns(f"{kind}/{name}", indexes=[time], columns=rr.Scalars.columns(scalars=values))


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(*sys.argv[1:])
