"""The marked copies are read from both tables by one reader."""

from __future__ import annotations

import pytest

from rumu.errors import CalibrationError
from rumu_lab.experiments.marked_copies import FOLDERS, read_copies, read_templates


def test_the_rows_of_both_tables_are_read(data):
    copies = read_copies(data)
    assert len(copies) == 652 + 158
    assert len({c.character for c in copies}) == 17 + 8
    assert len({c.image.name for c in copies}) == len(copies)  # names tell them apart wherever they are kept
    for copy in copies:
        assert copy.image.is_file() and copy.template.is_file()
        assert 0 <= copy.mark <= 100
        assert len(copy.ratings) >= 5
    assert {c.template for c in copies} == set(read_templates(data))


@pytest.mark.parametrize("folder", FOLDERS)
def test_either_table_that_is_absent_is_named(e3c_data, folder):
    (e3c_data / folder / "scores.csv").unlink()
    with pytest.raises(CalibrationError, match=rf"{folder}.scores\.csv: expected the E3C marks here"):
        read_copies(e3c_data)
