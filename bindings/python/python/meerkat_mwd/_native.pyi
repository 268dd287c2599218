from collections.abc import Mapping
from typing import Any, final

from numpy.typing import NDArray

__version__: str

@final
class Trace:
    """A recording: samples, keys of its header, and a reference attitude if there is one."""

    @staticmethod
    def read(path: str, strict: bool = False) -> Trace:
        """Reads a trace file, .csv or .csv.gz; ``strict`` makes a row that is dropped for its time an error."""
    @staticmethod
    def from_arrays(
        t_s: NDArray[Any],
        gyr: NDArray[Any],
        acc: NDArray[Any],
        mag: NDArray[Any] | None = None,
        temperature: NDArray[Any] | None = None,
        keys: list[tuple[str, str]] = ...,
        strict: bool = False,
    ) -> Trace:
        """A trace of float64 arrays: s (N,), rad/s, m/s^2, uT (N, 3), degC (N,). NaN is a missing value."""
    @staticmethod
    def from_columns(
        names: list[str],
        columns: list[NDArray[Any]],
        ignored: list[str] = ...,
        keys: list[tuple[str, str]] = ...,
        strict: bool = False,
    ) -> Trace:
        """A trace of float64 columns, each with its name in a trace's file. NaN is an empty cell."""
    def write(self, path: str) -> None:
        """Writes the trace, gzip when the name ends in .gz."""
    def arrays(self) -> dict[str, NDArray[Any]]:
        """Arrays by name: t_s, gyr, acc, mag, temperature; reference and true_rate where there are."""
    @property
    def dropped(self) -> tuple[int, int]:
        """Numbers of rows that were dropped: whose time repeats, and whose time goes back."""
    @property
    def notes(self) -> list[str]:
        """Remarks of the reader, such as ignored columns."""
    @property
    def duration_s(self) -> float:
        """From the first sample to the last, seconds."""
    def __len__(self) -> int: ...

@final
class Flight:
    def json(self) -> str: ...
    def surveys_csv(self) -> str: ...
    def write_attitude(self, path: str) -> None: ...
    def write_rates(self, path: str) -> None: ...
    def attitude(self) -> dict[str, NDArray[Any]]: ...
    def rates(self) -> dict[str, NDArray[Any]]: ...

@final
class Probe:
    """A probe as the firmware runs it, sample by sample."""

    def __init__(self, rate_hz: float, config: str | None = None) -> None:
        """The nominal rate, and TOML over the default configuration."""
    def freeze(self, at_s: float) -> None:
        """Lets nothing new take effect from a time on: the last window ends one latency before it, and lands on it.

        Call it before the first sample, or two latencies ahead.
        """
    def push(
        self,
        t_s: float,
        gyr: tuple[float, float, float] | list[float] | NDArray[Any],
        acc: tuple[float, float, float] | list[float] | NDArray[Any],
        mag: tuple[float, float, float] | list[float] | NDArray[Any] | None = None,
        temperature: float | None = None,
    ) -> dict[str, Any] | None:
        """Takes a sample and does the work that the chip does beside it; the attitude, or None before there is one."""
    def take_report(self) -> dict[str, Any] | None:
        """The report of the oldest closed window that was not taken yet, or None.

        Its fields are those of ``identification.windows`` in docs/json.md: ``accepted``, ``reason``, ``P`` (9, row by
        row), ``b_rad_s`` (3), ``sigma`` (12), times in seconds. The last 1,000 wait.
        """
    def take_diagnosis(self) -> dict[str, Any] | None:
        """The oldest diagnosis that was not taken yet, or None; one is made when a window closes.

        ``t_start_s``, ``t_end_s``, ``t_effect_s`` (from when the effects are taken out), seconds; ``verdict``;
        ``effects``, with the fields of ``diagnosis.effects`` in docs/json.md, without the residual of each, which is of
        a whole flight; ``nis`` without and with the effects; ``remainder``. The last 1,000 wait.
        """
    def take_hard_iron_interval(self) -> dict[str, Any] | None:
        """A magnet on the probe, when it has come and again when it has left, or None: ask after each sample.

        ``from_s`` and ``to_s`` (None while it lasts), seconds; ``offset_ut`` and ``sigma_ut``, its field and 1-sigma on
        the body's axes, microtesla; ``field_use``: ``Corrected``, ``Withheld``, or ``ToldAfterwards`` of a magnet that
        came before the probe had turned.
        """

@final
class AttitudeFilter:
    def __init__(self, period_s: float, motion: str) -> None: ...
    def update_batch(
        self, gyr: NDArray[Any], acc: NDArray[Any], mag: NDArray[Any] | None = None
    ) -> dict[str, NDArray[Any]]: ...

def replay(
    trace: Trace,
    config: str | None = None,
    hold_out: float | None = None,
    seed: int | None = None,
    no_effects: bool = False,
    force: bool = False,
) -> Flight: ...
def simulate(scenario: str, seed: int) -> tuple[Trace, list[float]]: ...
def calibrate(
    traces: list[Trace], config: str | None = None, hold_out: float | None = None
) -> tuple[str, str | None]: ...
def survey(stations: str, run: str | None = None) -> str: ...
def import_recording(
    sources: list[str], map: str | None = None, keys: list[tuple[str, str]] = ...
) -> tuple[Trace, str, str, bool]: ...
def key(file: str, program: bytes, given: Mapping[str, Any]) -> str: ...
def tables(address: str, file: str, key: str, results: str, given: Mapping[str, Any]) -> str: ...
def tables_of_unread(address: str, why: str, results: str) -> str: ...
