"""The notebook runs from its first cell to its last, and draws."""

import base64
from pathlib import Path

import nbformat
from nbclient import NotebookClient

from test_package import ROOT

NOTEBOOK = Path(__file__).resolve().parents[1] / "notebooks/from_a_recording_to_plots.ipynb"
RECORDING = ROOT / "host-tests/traces/broad_06_fast_rotation_110s.csv.gz"


def test_the_notebook_goes_from_a_recording_to_plots(tmp_path, monkeypatch):
    monkeypatch.setenv("RECORDING", str(RECORDING))
    notebook = nbformat.read(NOTEBOOK, as_version=4)
    assert all(not cell.get("outputs") for cell in notebook.cells), "it is kept without what it prints"
    NotebookClient(notebook, timeout=300, resources={"metadata": {"path": str(tmp_path)}}).execute()
    outputs = [output for cell in notebook.cells for output in cell.get("outputs", [])]
    pictures = [output["data"]["image/png"] for output in outputs if "image/png" in output.get("data", {})]
    assert len(pictures) == 3
    assert all(base64.b64decode(picture).startswith(b"\x89PNG") for picture in pictures)
    text = "".join(output.get("text", "") for output in outputs)
    assert "in deg/s" in text and "in gauss" in text and "WRONG" not in text
    for number, picture in enumerate(pictures):
        (tmp_path / f"{number}.png").write_bytes(base64.b64decode(picture))
