"""Files of `mwd survey`, read back by programs and libraries of others."""

import importlib.util
import json
import os
import socket
import subprocess
import sys
import threading
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[3]
PROGRAM = Path(os.environ.get("MWD_PROGRAM", ROOT / "target/debug/mwd"))
RUN = ROOT / "host-tests/tests/surveys/forty_stations"
# A name that a careless writer lets break a header, an element or an identifier.
NAME = 'A & B: "1" <north> ~2'
SAG = '[sag]\nmodel = "stated"\nlevel_deg = 0.2\n'
# Energistics' common types, which witsml-2.0's Python classes take from another version.
COMMON = "{http://www.energistics.org/energyml/data/commonv2}"


def reader(module):
    """Skips where a reader could not be installed; `.ci/run` demands all of them."""
    if importlib.util.find_spec(module.split(".")[0]) is None:
        told = f"{module} is not installed: pip install 'bindings/python[test]' (welleng needs Python 3.11)"
        pytest.fail(told) if os.environ.get("MWD_REQUIRE_READERS") else pytest.skip(told)


def alone(script, *arguments):
    """Output of a script, as JSON. Bindings of two versions of one schema cannot be in one process."""
    done = subprocess.run([sys.executable, "-c", script, *map(str, arguments)], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """A run of 40 stations: its files, what a receiver of WITS got, and its JSON's stations."""
    folder = tmp_path_factory.mktemp("run")
    settings = RUN.with_suffix(".toml").read_text()
    settings = settings.replace('well = "simulated run of 40 stations"', f"well = '{NAME}'\ngrid = {{ utm_zone = 31 }}")
    assert NAME in settings
    (folder / "run.toml").write_text(settings + SAG)
    files = {name: folder / f"out.{name}" for name in ["csv", "plain", "witsml1", "witsml2", "las", "json"]}
    received = bytearray()
    with socket.create_server(("127.0.0.1", 0)) as server:
        server.settimeout(60)

        def receive():
            connection, _ = server.accept()
            while part := connection.recv(1 << 16):
                received.extend(part)

        receiver = threading.Thread(target=receive)
        receiver.start()
        out = [word for name, path in files.items() for word in (f"--{name}", path)]
        command = [PROGRAM, "survey", RUN.with_suffix(".csv"), "--run", folder / "run.toml", *out]
        done = subprocess.run([*command, "--wits0", "127.0.0.1:%d" % server.getsockname()[1]], capture_output=True, text=True)
        receiver.join()
    assert done.returncode == 0, done.stderr
    return files, bytes(received), json.loads(files["json"].read_text())["stations"]


def column(stations, *path):
    values = stations
    for key in path:
        values = [value[key] for value in values]
    return np.array(values)


def test_pandas_reads_the_tables(run):
    import pandas as pd

    files, _, stations = run
    full = pd.read_csv(files["csv"], comment="#")
    assert len(full) == 40
    assert np.allclose(full.azimuth_deg, column(stations, "azimuth_deg"), atol=1e-4)
    assert np.allclose(full[["north_m", "east_m", "tvd_m"]], column(stations, "position_m"), atol=1e-3)
    assert np.allclose(full.convergence_deg, column(stations, "convergence_deg"), atol=1e-4)
    assert (full.reference_model == "simulated").all() and (full.reference_date == "2026-06-01").all()
    assert np.allclose(full.sag_deg, column(stations, "sag_deg"), atol=1e-4) and full.sag_deg.max() > 0.1
    plain = pd.read_csv(files["plain"])
    assert list(plain.columns) == ["md", "inc", "azi"] and np.allclose(plain.inc, full.inclination_deg)


def test_welleng_takes_the_plain_table_to_the_same_positions(run):
    reader("welleng")
    import pandas as pd
    import welleng.survey

    files, _, stations = run
    plain, ours = pd.read_csv(files["plain"]), column(stations, "position_m")
    theirs = welleng.survey.Survey(plain.md.values, plain.inc.values, plain.azi.values, start_nev=ours[0])
    assert np.abs(np.column_stack([theirs.n, theirs.e, theirs.tvd]) - ours).max() < 1e-3
    assert np.allclose(theirs.dls[1:], column(stations, "dogleg_deg_30m")[1:], atol=1e-3)


def test_lasio_reads_the_log(run):
    reader("lasio")
    import lasio

    files, _, stations = run
    log = lasio.read(files["las"])
    assert log.well.STRT.value == stations[0]["md_m"] and log.well.STOP.value == stations[-1]["md_m"]
    assert log.curves.AZIM.unit == "DEG" and log.params.MODL.value == "simulated"
    assert "0.200 deg in a level hole" in log.params.SAGC.value
    for name, path in [("DEPT", ["md_m"]), ("INCL", ["inclination_deg"]), ("AZIM", ["azimuth_deg"]), ("SAG", ["sag_deg"]),
                       ("DECL", ["reference", "declination_deg"]), ("CONV", ["convergence_deg"]), ("TVD", ["position_m", 2]), ("NS", ["position_m", 0]), ("EMAJ", ["ellipse", 0])]:
        assert np.allclose(log[name], column(stations, *path), atol=1e-4), name


# Prints what a schema's binding holds of a document, after it has validated all of it.
WITSML_1 = """
import json, sys
from komle.bindings.v1411.write import witsml
document = witsml.CreateFromDocument(open(sys.argv[1]).read())
document.validateBinding()
trajectory = document.trajectory[0]
value = lambda element: float(element.value())
print(json.dumps({"well": trajectory.nameWell, "stations": [
    [value(s.md), value(s.incl), value(s.azi), value(s.dispNs), value(s.dispEw), value(s.tvd), value(s.matrixCov.varianceNN),
     value(s.corUsed.stnMagDeclUsed), value(s.corUsed.stnGridConUsed), value(s.corUsed.sagIncCor),
     s.magModelUsed, s.magModelValid, bool(s.sagCorUsed)] for s in trajectory.trajectoryStation],
    "first": [value(trajectory.magDeclUsed), value(trajectory.gridConUsed)]}, default=str))
"""
WITSML_2 = """
import json, sys
from komle.bindings.v20 import witsml
document = witsml.CreateFromDocument(open(sys.argv[1]).read())
document.validateBinding()
value = lambda element: float(element.value())
print(json.dumps({"well": document.Wellbore.Title, "stations": [
    [value(s.Md), value(s.Incl), value(s.Azi), value(s.DispNs), value(s.DispEw), value(s.Tvd), value(s.MatrixCov.VarianceNN),
     value(s.CorUsed.StnMagDeclUsed), value(s.CorUsed.StnGridConUsed), value(s.CorUsed.SagIncCor),
     s.MagModelUsed, s.MagModelValid, bool(s.SagCorUsed)] for s in document.TrajectoryStation],
    "first": [value(document.MagDeclUsed), value(document.GridConUsed)]}, default=str))
"""


@pytest.mark.parametrize(("kind", "script", "spoilt"), [
    ("witsml1", WITSML_1, ("magnetic MWD</typeTrajStation>", "MD INCL and AZI</typeTrajStation>")),
    ("witsml2", WITSML_2, ('uom="dega"', 'uom="m"')),
])
def test_komle_validates_the_trajectory_against_its_schema(run, tmp_path, kind, script, spoilt):
    reader("komle.bindings")
    files, _, stations = run
    read = alone(script, files[kind])
    assert read["well"] == NAME and len(read["stations"]) == 40
    for theirs, ours in zip(read["stations"], stations):
        expected = [ours["md_m"], ours["inclination_deg"], ours["azimuth_deg"], *ours["position_m"], ours["covariance_m2"][0][0],
                    ours["reference"]["declination_deg"], ours["convergence_deg"], ours["sag_deg"]]
        assert np.allclose(theirs[:10], expected, atol=1e-3)
        assert theirs[10:] == ["simulated", "2026-06-01", True]
    # By what is in the file, a magnetic azimuth becomes that of the grid.
    declination, convergence = read["first"]
    assert abs(convergence) > 1 and abs(theirs[2] - (ours["magnetic_azimuth_deg"] + declination - convergence)) < 1e-3
    # The reader does look: a value of another version, or a wrong unit, is refused.
    text = files[kind].read_text()
    assert spoilt[0] in text
    (tmp_path / "spoilt.xml").write_text(text.replace(*spoilt, 1))
    with pytest.raises(AssertionError, match="SimpleFacetValueError.*enumeration constraint violated"):
        alone(script, tmp_path / "spoilt.xml")


def test_energyml_knows_every_element_and_unit_of_the_trajectory(run):
    """All but citation and identifiers, whose namespace that package has in another version."""
    reader("energyml")
    from energyml.witsml.v2_0 import witsmlv2
    from xsdata.formats.dataclass.parsers import XmlParser
    from xsdata.formats.dataclass.parsers.config import ParserConfig

    files, _, stations = run
    root = ET.parse(files["witsml2"]).getroot()
    root.attrib.clear()
    for parent in list(root.iter()):
        for child in [child for child in parent if child.tag.startswith(COMMON)]:
            parent.remove(child)
    strict = ParserConfig(fail_on_unknown_properties=True, fail_on_unknown_attributes=True, fail_on_converter_warnings=True)
    trajectory = XmlParser(strict).from_bytes(ET.tostring(root), witsmlv2.Trajectory)
    assert np.allclose([s.azi.value for s in trajectory.trajectory_station], column(stations, "azimuth_deg"), atol=1e-4)
    assert trajectory.trajectory_station[-1].incl.uom.value == "dega"


def decoded(data):
    """Records of WITS level 0: between lines `&&` and `!!`, lines of record and item, two digits each, and a value."""
    records, record = [], None
    for line in data.decode("ascii").split("\r\n"):
        if line == "&&":
            assert record is None
            record = {}
        elif line == "!!":
            records.append(record)
            record = None
        elif line:
            assert record is not None and line[:4].isdigit() and line[:4] not in record, line
            record[line[:4]] = line[4:]
    assert record is None
    return records


def test_a_receiver_of_wits_decodes_every_record(run):
    _, received, stations = run
    records = decoded(received)
    assert [record["0704"] for record in records] == [str(k + 1) for k in range(40)]
    for record, ours in zip(records, stations):
        assert set(record) == {"0701", "0703", "0704", "0708", "0709", "0713", "0714", "0715", "0717", "0718", "0719", "0720"}
        assert record["0701"] == NAME[:16] and record["0703"] == "7"
        north, east, tvd = ours["position_m"]
        for item, value, within in [("0708", ours["md_m"], 0.006), ("0709", tvd, 0.006), ("0713", ours["inclination_deg"], 6e-4),
                                    ("0714", ours["measured_deg"][1], 6e-4), ("0715", ours["azimuth_deg"], 6e-4),
                                    ("0718", north, 0.006), ("0719", east, 0.006), ("0720", ours["dogleg_deg_30m"] / 0.3, 6e-4)]:
            assert abs(float(record[item]) - value) < within, item
