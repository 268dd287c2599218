"""Self-calibrating attitude for measurement-while-drilling probes.

Readings are in the body frame, right-handed: rates in rad/s, specific force in m/s^2 (at rest it points up), field in
microtesla, time in seconds. Quaternions are scalar first and turn a vector of the body into north, east, down:
``v_ned = q v_body q*``. A missing value is NaN. Results are those of ``cargo mwd``, byte for byte.
"""

from __future__ import annotations

import json as _json
import os as _os
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as _np

from . import _native
from ._native import Probe, Trace, __version__

if TYPE_CHECKING:
    import pandas as pd
    from numpy.typing import ArrayLike, NDArray

__all__ = [
    "AttitudeFilter",
    "Calibration",
    "Flight",
    "Import",
    "Probe",
    "Trace",
    "__version__",
    "calibrate",
    "diagnose",
    "import_recording",
    "read",
    "replay",
    "simulate",
    "survey",
    "trace",
]

_Path = str | _os.PathLike[str]

#: Columns of a trace's file.
_COLUMNS = frozenset(
    "t_s gx gy gz ax ay az mx my mz temp_c qw qx qy qz sample_flags movement rest wx_true wy_true wz_true".split()
)


def read(path: _Path, *, strict: bool = False) -> Trace:
    """Reads a trace file, ``.csv`` or ``.csv.gz``.

    Args:
        path: The file.
        strict: A row whose time repeats or goes back is an error. Else it is dropped and counted (``Trace.dropped``,
            ``Trace.notes``); over one row in twenty is an error anyhow.
    """
    return Trace.read(_os.fspath(path), strict)


def trace(
    t_s: ArrayLike | Mapping[str, Any] | pd.DataFrame,
    gyr: ArrayLike | None = None,
    acc: ArrayLike | None = None,
    mag: ArrayLike | None = None,
    temperature: ArrayLike | None = None,
    *,
    strict: bool = False,
    **keys: object,
) -> Trace:
    """A recording of arrays, or of a DataFrame.

    Args:
        t_s: Times, seconds, (N,); or a DataFrame (or mapping) with the columns of a trace file: ``t_s gx gy gz ax ay
            az`` and optionally the others, of which a group is whole: ``mx my mz``, ``temp_c``, ``qw qx qy qz``,
            ``sample_flags``, ``movement``, ``rest``, ``wx_true wy_true wz_true``. Other columns are noted. A row whose time
            repeats or goes back is dropped and counted, as in a file: ``Trace.dropped``, ``Trace.notes``; over one
            row in twenty is an error.
        gyr: Rates, rad/s, (N, 3).
        acc: Specific force, m/s^2, (N, 3).
        mag: Field, microtesla, (N, 3), NaN where it was not read.
        temperature: Degrees Celsius, (N,).
        strict: A row whose time repeats or goes back is an error.
        keys: Keys of a trace's header, for instance ``body_frame="tool"``.
    """

    def array(values: Any) -> NDArray[_np.float64]:
        return _np.ascontiguousarray(values, dtype=float)

    if gyr is None:
        if not (acc is None and mag is None and temperature is None):
            raise TypeError("a table has acc, mag and temperature as columns: ax ay az, mx my mz, temp_c")
        table: Any = t_s
        names = [name for name in table.keys() if name in _COLUMNS]
        return Trace.from_columns(
            names,
            [array(table[name]) for name in names],
            [repr(name) for name in table.keys() if name not in _COLUMNS],
            [(key, _text(value)) for key, value in keys.items()],
            strict,
        )
    if acc is None:
        raise TypeError("gyr and acc are both needed")

    return Trace.from_arrays(
        array(t_s),
        array(gyr),
        array(acc),
        None if mag is None else array(mag),
        None if temperature is None else array(temperature),
        [(key, _text(value)) for key, value in keys.items()],
        strict,
    )


def _text(value: object) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)


def _as_trace(recording: Any, strict: bool = False) -> Trace:
    if isinstance(recording, Trace):
        if strict and any(recording.dropped):
            raise ValueError("; ".join(note for note in recording.notes if "dropped" in note))
        return recording
    if isinstance(recording, (str, _os.PathLike)):
        return read(recording, strict=strict)
    return trace(recording, strict=strict)


def _frame(columns: Mapping[str, Any]) -> pd.DataFrame:
    import pandas as pd

    flat: dict[str, Any] = {}
    for name, values in columns.items():
        if getattr(values, "ndim", 1) == 1:
            flat[name] = values
        else:
            axes = {"q": ["qw", "qx", "qy", "qz"], "rate": ["wx", "wy", "wz"]}[name]
            flat.update(zip(axes, values.T))
    return pd.DataFrame(flat)


class Flight:
    """Result of a recording's flight."""

    def __init__(self, native: _native.Flight) -> None:
        self._native = native
        self._json: dict[str, Any] | None = None

    @property
    def json(self) -> dict[str, Any]:
        """The result, its fields as docs/json.md has them."""
        if self._json is None:
            read: dict[str, Any] = _json.loads(self._native.json())
            self._json = read
        return self._json

    @property
    def json_text(self) -> str:
        """The file that ``cargo mwd replay --json`` writes."""
        return self._native.json() + "\n"

    def attitude(self) -> dict[str, NDArray[Any]]:
        """Arrays with one row a sample: ``t_s`` (N,), ``q`` (N, 4), angles and their 1-sigma in degrees (N,),
        ``flags`` (N,). NaN where there is no attitude yet."""
        return self._native.attitude()

    def rates(self) -> dict[str, NDArray[Any]]:
        """``t_s`` (N,), the times of validity, and ``rate`` (N, 3), rad/s, compensated by all that flies."""
        return self._native.rates()

    def attitude_frame(self) -> pd.DataFrame:
        """The attitude as a DataFrame."""
        return _frame(self.attitude())

    def windows(self) -> pd.DataFrame:
        """One row a window of the identification."""
        import pandas as pd

        return pd.json_normalize(self.json["identification"]["windows"])

    def surveys(self) -> pd.DataFrame:
        """One row a survey, at rest and over whole turns."""
        import io

        import pandas as pd

        return pd.read_csv(io.StringIO(self._native.surveys_csv()))

    @property
    def surveys_csv(self) -> str:
        """The file that ``cargo mwd replay --surveys`` writes."""
        return self._native.surveys_csv()

    @property
    def p(self) -> NDArray[_np.float64]:
        """P that flies at the end, (3, 3)."""
        return _np.array(self.json["identification"]["final"]["P"]).reshape(3, 3)

    @property
    def b_rad_s(self) -> NDArray[_np.float64]:
        """Bias that flies at the end, rad/s, (3,)."""
        return _np.array(self.json["identification"]["final"]["b_rad_s"])

    def write_attitude(self, path: _Path) -> None:
        """Writes the file of ``cargo mwd replay --attitude``."""
        self._native.write_attitude(_os.fspath(path))

    def write_rates(self, path: _Path) -> None:
        """Writes the file of ``cargo mwd replay --rates``."""
        self._native.write_rates(_os.fspath(path))

    def __repr__(self) -> str:
        facts = self.json["trace"]
        windows = self.json["identification"]["windows"]
        accepted = sum(window["accepted"] for window in windows)
        return f"Flight({facts['samples']} samples, {accepted} of {len(windows)} windows accepted)"


def replay(
    recording: Trace | _Path | Mapping[str, Any] | pd.DataFrame,
    *,
    config: _Path | None = None,
    hold_out: float | None = None,
    seed: int | None = None,
    no_effects: bool = False,
    strict: bool = False,
    force: bool = False,
) -> Flight:
    """Flies a recording, as ``cargo mwd replay`` does. Other threads run meanwhile.

    Args:
        recording: A trace, its file, or a DataFrame with the columns of one.
        config: TOML that overrides the trace's header.
        hold_out: Freeze the parameters before this last fraction, and score only there.
        seed: Seed of the searches.
        no_effects: Identify the twelve parameters only.
        strict: A row whose time repeats or goes back is an error; else it is dropped and counted.
        force: Fly a recording whose units, signs or axes cannot be; nothing is identified from it.
    """
    native = _native.replay(
        _as_trace(recording, strict), None if config is None else _os.fspath(config), hold_out, seed, no_effects, force
    )
    return Flight(native)


def diagnose(recording: Trace | _Path | Mapping[str, Any] | pd.DataFrame, **options: Any) -> dict[str, Any]:
    """Which physical effects a recording shows: the field ``diagnosis`` of the result. Options as in :func:`replay`."""
    diagnosis: dict[str, Any] = replay(recording, **options).json["diagnosis"]
    return diagnosis


def simulate(scenario: _Path, seed: int = 1) -> tuple[Trace, NDArray[_np.float64], NDArray[_np.float64]]:
    """Simulates a scenario file; returns the trace, and the gyro's true P (3, 3) and b (3,), rad/s."""
    simulated, model = _native.simulate(_os.fspath(scenario), seed)
    return simulated, _np.array(model[:9]).reshape(3, 3), _np.array(model[9:])


class Calibration:
    """Accelerometer and magnetometer models."""

    def __init__(self, account: dict[str, Any], toml: str | None) -> None:
        #: What was found, as ``cargo mwd calibrate --json`` writes it.
        self.account = account
        #: The record for ``config``; None if nothing could be calibrated.
        self.toml = toml


def calibrate(
    recordings: Iterable[Trace | _Path], *, config: _Path | None = None, hold_out: float | None = None
) -> Calibration:
    """Makes sensor models from recordings with rests and turns, as ``cargo mwd calibrate`` does."""
    traces = [_as_trace(recording) for recording in recordings]
    account, toml = _native.calibrate(traces, None if config is None else _os.fspath(config), hold_out)
    return Calibration(_json.loads(account), toml)


def survey(stations: str | pd.DataFrame, run: str | None = None) -> dict[str, Any]:
    """Corrects the stations of a run together and computes the path, as ``cargo mwd survey --json`` does.

    Args:
        stations: A DataFrame or CSV text with the columns of docs/surveys.md.
        run: Settings of the run, TOML text.
    """
    text = stations if isinstance(stations, str) else stations.to_csv(index=False)
    surveyed: dict[str, Any] = _json.loads(_native.survey(text, run))
    return surveyed


class Import:
    """A foreign recording as it was understood."""

    def __init__(self, native: tuple[Trace, str, str, bool]) -> None:
        #: The trace, the map as TOML, what was found as text, and whether the gate found it wrong.
        self.trace, self.map, self.told, self.is_wrong = native


def import_recording(
    sources: _Path | Iterable[_Path], *, map: _Path | None = None, force: bool = False, **keys: object
) -> Import:
    """Imports a foreign recording, as ``cargo mwd import`` does.

    Raises:
        ValueError: the gate found what cannot be, and ``force`` is not set; the text names the likely fix.
    """
    paths = [sources] if isinstance(sources, (str, _os.PathLike)) else list(sources)
    native = _native.import_recording(
        [_os.fspath(path) for path in paths],
        None if map is None else _os.fspath(map),
        [(key, _text(value)) for key, value in keys.items()],
    )
    imported = Import(native)
    if imported.is_wrong and not force:
        raise ValueError(imported.told)
    return imported


def _enu(ned: NDArray[_np.float32]) -> NDArray[_np.float32]:
    """Body to east, north, up, of quaternions to north, east, down."""
    w, x, y, z = ned.T
    half = _np.float32(_np.sqrt(0.5))
    # Half a turn about the bisector of north and east, from the left.
    return _np.stack([-half * (x + y), half * (w + z), half * (w - z), half * (y - x)], axis=1)


class AttitudeFilter:
    """Attitude alone, with the call of VQF: rates are taken as they are, and nothing is identified.

    Where it is not as VQF:

    - The constructor takes one period for all sensors and the kind of motion, and none of VQF's parameters. There is
      no ``update`` of single samples (:class:`Probe` has one), no ``updateBatchFullState`` and no offline filter.
    - Quaternions are NaN until the first specific force aligns the filter, where VQF begins with no rotation.
    - ``quat6D`` is a second filter that never sees the field, and ``delta`` the heading of ``quat9D`` against it; in
      VQF both share their tilt. Its heading begins where the first sample's x axis points, as arbitrary as VQF's.
    - ``bias``, ``biasSigma`` and ``restDetected`` are of the filter with the field, if there is one.
    - ``biasSigma`` is the largest 1-sigma of the three axes as the filter states it; VQF's is an upper bound.
    - ``magDistDetected`` is true where a field was given and not used, for whatever reason; VQF's where its norm or
      dip is off. A field of NaN or of zeros is missing, and not disturbed.
    - The field must be of microtesla's size; VQF takes any unit.
    - Arrays are float32, but for the two of bool; VQF's are float64.

    Args:
        period_s: Time between two samples, seconds, 0.0001 to 0.05; VQF's ``gyrTs``.
        motion: ``hand``, or ``drill_string`` for a probe that goes round and is not carried about.
    """

    def __init__(self, period_s: float, motion: str = "hand") -> None:
        self._native = _native.AttitudeFilter(period_s, motion)

    def updateBatch(  # noqa: N802 - VQF's name
        self, gyr: ArrayLike, acc: ArrayLike, mag: ArrayLike | None = None
    ) -> dict[str, NDArray[Any]]:
        """Filters whole arrays of shape (N, 3): rad/s, m/s^2, microtesla. NaN is a missing reading.

        Returns a dictionary, in all cases

        - ``quat6D`` (N, 4): body to east, north, up, VQF's earth frame, scalar first, without the field;
        - ``bias`` (N, 3): the gyro's bias in the body frame, rad/s, and ``biasSigma`` (N,), its deviation;
        - ``restDetected`` (N,): whether the probe rests;

        and with ``mag``

        - ``quat9D`` (N, 4): as ``quat6D``, with the field;
        - ``delta`` (N,): heading of ``quat9D`` against ``quat6D``, radians, counted from east to north;
        - ``magDistDetected`` (N,): whether the field was not used;

        and, not in VQF, ``quatNED`` (N, 4): the better of both as body to north, east, down.
        """

        def array(values: ArrayLike) -> NDArray[_np.float64]:
            return _np.ascontiguousarray(values, dtype=float)

        result = self._native.update_batch(array(gyr), array(acc), None if mag is None else array(mag))
        result["quatNED"] = result["quat6D" if mag is None else "quat9D"]
        result["quat6D"] = _enu(result["quat6D"])
        if mag is not None:
            result["quat9D"] = _enu(result["quat9D"])
            (w, x, y, z), (v, a, b, c) = result["quat9D"].T, result["quat6D"].T
            # The turn about up in quat9D times the conjugate of quat6D.
            half = _np.arctan2(z * v - w * c + y * a - x * b, w * v + x * a + y * b + z * c)
            result["delta"] = (2 * half + _np.pi) % (2 * _np.pi) - _np.pi
        return result
