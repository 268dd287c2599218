"""Files that were written by the programs and libraries of others.

Where they come from: no package of PyPI or crates.io that was looked at (pyulog, px4-ulog, scipy) holds the log of a
real vehicle. The ULog's messages are made here from a real recording after PX4's description of the format
(https://docs.px4.io/main/en/dev_log/ulog_file_format.html), read by pyulog, PX4's own library, and written again by it.
The .mat files are real: MATLAB 6.1, 7.1 and 7.4 wrote them on SunOS and Linux, and SciPy brings them for its own tests
(``scipy/io/matlab/tests/data`` of its wheel, BSD licence). None of them is a recording; that of ``test_package`` is
one, and SciPy writes it. The flights of the same files made in Rust are compared in ``host-tests/tests/import``.
"""

import io
import struct
from pathlib import Path

import numpy as np
import pytest

import meerkat_mwd as mwd

from test_package import MAGNET

ULOG_HEAD = b"ULog\x01\x12\x35\x01" + bytes(8)


def message(kind, body):
    return struct.pack("<HB", len(body), ord(kind)) + body


def ulog(arrays):
    """A vehicle's log: the messages of PX4 that hold the sensors."""
    formats = [
        "sensor_combined:uint64_t timestamp;float[3] gyro_rad;uint32_t gyro_integral_dt;"
        "int32_t accelerometer_timestamp_relative;float[3] accelerometer_m_s2;",
        "vehicle_magnetometer:uint64_t timestamp;float[3] magnetometer_ga;",
    ]
    log = ULOG_HEAD + message("B", bytes(40)) + b"".join(message("F", text.encode()) for text in formats)
    log += b"".join(message("A", struct.pack("<BH", 0, k) + text.split(":")[0].encode()) for k, text in enumerate(formats))
    for t_s, gyr, acc, mag in zip(arrays["t_s"], arrays["gyr"], arrays["acc"], arrays["mag"]):
        t_us = round(t_s * 1e6)
        log += message("D", struct.pack("<HQ3fIi3f", 0, t_us, *gyr, 10_000, 0, *acc))
        if np.isfinite(mag).all():
            log += message("D", struct.pack("<HQ3f", 1, t_us, *(mag / 100)))
    return log


def test_a_ulog_that_px4s_own_library_wrote_is_imported(tmp_path):
    pyulog = pytest.importorskip("pyulog")
    arrays = mwd.read(MAGNET).arrays()
    arrays = {name: values[:6000] for name, values in arrays.items()}
    theirs = pyulog.ULog(io.BytesIO(ulog(arrays)))
    assert np.allclose(theirs.get_dataset("sensor_combined").data["gyro_rad[2]"], arrays["gyr"][:, 2])
    file = tmp_path / "log.ulg"
    theirs.write_ulog(str(file))
    found = mwd.import_recording(file).trace.arrays()
    for name in ["gyr", "acc", "mag"]:
        assert np.allclose(found[name], arrays[name], rtol=1e-5, equal_nan=True), name


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("testdouble_7.4_GLNX86", "testdouble_7.4_GLNX86: testdouble"),
        ("testmatrix_7.1_GLNX86", "testmatrix_x, testmatrix_y, testmatrix_z"),
        ("teststruct_7.4_GLNX86", "teststruct: doublefield, complexfield"),
        ("teststructarr_7.4_GLNX86", "no numeric array of more than one row"),
        ("testdouble_6.1_SOL2", "big-endian"),
    ],
)
def test_files_that_matlab_itself_wrote_are_read(name, told):
    # None is a recording; what is in them is told.
    file = Path(pytest.importorskip("scipy.io.matlab").__file__).parent / "tests/data" / f"{name}.mat"
    if not file.exists():
        pytest.skip("this SciPy comes without its test data")
    with pytest.raises(ValueError, match=told):
        mwd.import_recording(file)
