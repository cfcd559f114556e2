"""Fit the calibration that ships with rumu from the E3C marks: `python scripts/fit_panel.py [DATA]`.

Writes src/rumu/assessment/panel.json and prints how well the same fit holds on characters held out.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path

from rumu.assessment.calibration import write_calibration
from rumu_lab.experiments.e3c import held_out_marks
from rumu_lab.experiments.run_settings import RunSettings

ROOT = Path(__file__).parents[1]

if __name__ == "__main__":
    data = Path(sys.argv[1] if len(sys.argv) > 1 else os.environ.get("RUMU_DATA", ROOT / "../shared/data"))
    marks = held_out_marks(RunSettings(data))
    write_calibration(marks.calibration, ROOT / "src/rumu/assessment/panel.json")
    print(marks.text())
