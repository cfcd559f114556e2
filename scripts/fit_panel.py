"""Fit the calibration that ships with rumu from the E3C marks: `python scripts/fit_panel.py [DATA]`.

Writes src/rumu/assessment/panel.json and prints how well the same fit holds on characters held out.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path

from rumu.assessment.calibration import write_calibration
from rumu_lab.experiments import e3c

HOME = Path(__file__).parents[1]

if __name__ == "__main__":
    data = Path(sys.argv[1] if len(sys.argv) > 1 else os.environ.get("RUMU_DATA", HOME / "../shared/data"))
    result = e3c.run(data)
    write_calibration(result.calibration, HOME / "src/rumu/assessment/panel.json")
    print(result.text())
