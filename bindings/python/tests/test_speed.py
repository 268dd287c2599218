"""Attitude alone beside VQF: both over the same arrays, in the same run.

``MWD_MARKDOWN=docs/measurements pytest -s bindings/python/tests/test_speed.py`` writes the page of measurements.
"""

import os
import time
from pathlib import Path

import numpy as np
import pytest

import meerkat_mwd as mwd

from test_package import SCENARIO


def inclination_deg(up):
    return np.degrees(np.arccos(np.clip(up, -1, 1)))


def test_the_same_call_as_vqfs_over_the_same_arrays():
    """Prints the times; what is asserted is that both were given the same work."""
    vqf = pytest.importorskip("vqf")
    trace, _, _ = mwd.simulate(SCENARIO, seed=4)
    arrays = trace.arrays()
    step = float(np.median(np.diff(arrays["t_s"])))
    gyr, acc, mag = (np.ascontiguousarray(arrays[name], dtype=float) for name in ["true_rate", "acc", "mag"])
    mag = np.nan_to_num(mag)
    ours, theirs = [], []
    for _ in range(7):
        for took, run in [
            (ours, lambda: mwd.AttitudeFilter(step).updateBatch(gyr, acc, mag)),
            (theirs, lambda: vqf.VQF(step).updateBatch(gyr, acc, mag)),
        ]:
            began = time.process_time()
            found = run()["quat9D"]
            took.append(time.process_time() - began)
            w, x, y, z = found[-2000:].T
            # Part of the body's z axis along the earth's.
            assert np.ptp(inclination_deg(1 - 2 * (x * x + y * y))) < 20 and w.shape == z.shape
    per_sample = [1e9 * min(took) / len(gyr) for took in (ours, theirs)]
    ratio = per_sample[0] / per_sample[1]
    print(f"\nupdateBatch of {len(gyr)} samples: {per_sample[0]:.0f} ns a sample, vqf's {per_sample[1]:.0f} ns; ratio {ratio:.2f}")
    if folder := os.environ.get("MWD_MARKDOWN"):
        (Path(folder) / "update_batch.md").write_text(PAGE.format(len(gyr), 1e3 / per_sample[0], 1e3 / per_sample[1], ratio, *per_sample))


PAGE = """    MWD_MARKDOWN=docs/measurements pytest -s bindings/python/tests/test_speed.py

# updateBatch beside VQF's

`updateBatch` of the Python package beside that of `vqf` (PyPI), rates, forces and field of {0} simulated samples at 100 Hz, in one
run: the least processor time of seven. Ours passes them through two filters, with and without the field.

| | ns a sample | million samples a second |
|---|---|---|
| `meerkat_mwd.AttitudeFilter` | {4:.0f} | {1:.2f} |
| `vqf.VQF` | {5:.0f} | {2:.2f} |

Ratio of the times: {3:.2f}.
"""
