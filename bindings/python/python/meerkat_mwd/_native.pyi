from typing import Any, final

from numpy.typing import NDArray

__version__: str

@final
class Trace:
    """A recording: samples, keys of its header, and a reference attitude if there is one."""

    @staticmethod
    def read(path: str) -> Trace:
        """Reads a trace file, .csv or .csv.gz."""
    @staticmethod
    def from_arrays(
        t_s: NDArray[Any],
        gyr: NDArray[Any],
        acc: NDArray[Any],
        mag: NDArray[Any] | None = None,
        temperature: NDArray[Any] | None = None,
        keys: list[tuple[str, str]] = ...,
    ) -> Trace:
        """A trace of float64 arrays: s (N,), rad/s, m/s^2, uT (N, 3), degC (N,). NaN is a missing value."""
    def write(self, path: str) -> None:
        """Writes the trace, gzip when the name ends in .gz."""
    def arrays(self) -> dict[str, NDArray[Any]]:
        """Arrays by name: t_s, gyr, acc, mag, temperature; reference and true_rate where there are."""
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
    def push(
        self,
        t_s: float,
        gyr: tuple[float, float, float] | list[float] | NDArray[Any],
        acc: tuple[float, float, float] | list[float] | NDArray[Any],
        mag: tuple[float, float, float] | list[float] | NDArray[Any] | None = None,
        temperature: float | None = None,
    ) -> dict[str, Any] | None:
        """Takes a sample and does the work that the chip does beside it; the attitude, or None before there is one."""

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
