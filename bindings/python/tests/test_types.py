"""The package's types hold under `mypy --strict`, and so does a script that uses them."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

PACKAGE = Path(__file__).resolve().parents[1]

SCRIPT = """
import numpy as np
import pandas as pd

import meerkat_mwd as mwd

reveal_type(mwd.read("a.csv", strict=True).dropped)
reveal_type(mwd.trace(pd.DataFrame(), body_frame="tool"))
reveal_type(mwd.replay({"t_s": np.zeros(3)}, hold_out=0.5).windows())
reveal_type(mwd.Probe(100.0).take_report())
reveal_type(mwd.AttitudeFilter(0.01).updateBatch(np.zeros((9, 3)), [[0.0, 0.0, 9.8]] * 9)["bias"].shape)
mwd.replay("a.csv", hold_out="half")
"""


def mypy(*arguments: object) -> str:
    pytest.importorskip("mypy")
    run = [sys.executable, "-m", "mypy", "--config-file", PACKAGE / "pyproject.toml", *arguments]
    source = PACKAGE / "python"
    environment = {**os.environ, "MYPYPATH": str(source)}
    done = subprocess.run([str(part) for part in run], capture_output=True, text=True, cwd=source, env=environment)
    return done.stdout + done.stderr


def test_the_package_is_typed_throughout():
    assert "Success: no issues found in 3 source files" in (told := mypy("-p", "meerkat_mwd")), told


def test_a_script_sees_the_types(tmp_path):
    script = tmp_path / "script.py"
    script.write_text(SCRIPT)
    told = mypy(script)
    revealed = [line.split("Revealed type is ")[1].strip('"') for line in told.splitlines() if "Revealed" in line]
    assert len(revealed) == 5 and not any(kind == "Any" for kind in revealed), told
    assert "int" in revealed[0] and "Trace" in revealed[1] and "DataFrame" in revealed[2] and "None" in revealed[3], told
    errors = [line for line in told.splitlines() if "error:" in line]
    assert len(errors) == 1 and "hold_out" in errors[0], told
