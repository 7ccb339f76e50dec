"""What a run writes only where it is asked for: pictures, and whole sections of rails and wheels."""

import subprocess
import sys
import xml.etree.ElementTree as ET

from flangeway.railway.track.placements import SIDES
from flangeway.railway.track.wheelset_problem import ROLES

COARSE = {"size_scale": 5.0, "patch_cells": 10}
CASES = {
    "hertz": {"size_mm": 2.0, "lower_size_mm": 2.5},
    "rolling-patch": {"theory": "polach"},
    "torsion": {"size": 20.0},
    "wheelset": COARSE,
    "wheelset-tangent": {"size_scale": 8.0},
}


def test_without_pictures_nothing_loads_matplotlib(tmp_path):
    """A case of any kind runs and writes its report and files without Matplotlib where no picture is drawn."""
    code = (
        "import sys; from pathlib import Path; from flangeway.cases import load_case; "
        "from flangeway.report.case_outputs import case_record, write_record; "
        f"records = [case_record(load_case(name, **inputs).run()) for name, inputs in {CASES!r}.items()]; "
        f"[write_record(record, Path({str(tmp_path)!r}, str(n)), pictures=False) for n, record in enumerate(records)]; "
        "assert 'matplotlib' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
    assert len([*tmp_path.glob("*/report.html")]) == len(CASES)


def test_whole_sections_are_written_where_they_are_asked_for(call, tmp_path):
    """Sections of all rails and wheels are added by the option, and the collection opens exactly the VTU files."""
    settings = [word for key, value in COARSE.items() for word in ("--set", f"{key}={value:g}")]
    sections = {f"section-{role}-{side}.vtu" for role in ROLES for side in SIDES}
    for option, expected in ((), set()), (("--whole-sections",), sections):
        out = tmp_path / f"{len(option)}"
        assert call("run", "wheelset", *settings, *option, "--out", str(out), "--no-pictures", "-q")[0] == 0
        files = {file.name for file in out.glob("*.vtu")}
        assert {file for file in files if file.startswith("section-")} == expected
        parts = ET.parse(out / "wheelset.pvd").getroot().iter("DataSet")
        assert {part.get("file") for part in parts} == files
