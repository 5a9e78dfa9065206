"""Every column of exported logs against what was recorded, bit for bit.

usage: columns.py FOLDER

FOLDER holds run.csv, run.parquet and run.mat, and in `expected` one file for each
column: the bytes of its numbers (`.f4`, `.f8`, `.u2`, `.u4`; `.i4` with -1 where a
sample is missing), or its words (`.json`). A true state that is not known is NaN.
"""

import csv
import json
import pathlib
import sys

import numpy
import polars
import pyarrow.parquet
import scipy.io

def read_expected(folder):
    """Columns by name: arrays of numbers, or lists of words."""
    columns = {}
    for path in folder.iterdir():
        if path.suffix == ".json":
            columns[path.stem] = json.loads(path.read_text())
        else:
            columns[path.stem] = numpy.fromfile(path, "<" + path.suffix[1:])
    return columns


def check(where, name, got, expected):
    """The same to the bit, and of the same kind."""
    if isinstance(expected, list):
        assert list(got) == expected, f"{where}: {name} has other words"
        return
    got = numpy.asarray(got)
    assert got.dtype == expected.dtype, f"{where}: {name} is {got.dtype}"
    assert got.tobytes() == expected.tobytes(), f"{where}: {name} differs"


def from_parquet(table, name, expected):
    """A column of an arrow table."""
    column = table[name].combine_chunks()
    if isinstance(expected, list):
        return [word or "" for word in column.to_pylist()]
    if expected.dtype == numpy.int32:
        assert str(column.type) == "uint16", f"{name} is {column.type}"
        missing = numpy.asarray(column.is_null())
        assert (missing == (expected < 0)).all(), f"{name}: other samples are missing"
        return column.fill_null(0).to_numpy().astype("i4") - missing
    if name.startswith("true_"):
        return column.fill_null(numpy.nan).to_numpy()
    assert column.null_count == 0, f"{name} has nulls"
    return column.to_numpy()


def check_parquet(path, expected):
    table = pyarrow.parquet.read_table(path)
    assert table.column_names and set(table.column_names) == set(expected)
    for name, column in expected.items():
        check("pyarrow", name, from_parquet(table, name, column), column)
    metadata = {key.decode(): value.decode() for key, value in table.schema.metadata.items()}
    units = json.loads(metadata["units"])
    assert units["angle_rad_1"] == "rad" and units["torque_nm_2"] == "N m", units
    assert json.loads(metadata["about"]).keys() == expected.keys()
    assert json.loads(metadata["settings"])["setup.period_us"] == 1000
    assert "simulated" in metadata["run"] and metadata["damage"], metadata

    frame = polars.read_parquet(path)
    for name, column in expected.items():
        check("polars", name, from_parquet(frame.to_arrow(), name, column), column)


def check_mat(path, expected):
    file = scipy.io.loadmat(path, struct_as_record=False, squeeze_me=False)
    log, words, units = (file[name][0, 0] for name in ("log", "words", "units"))
    for name, column in expected.items():
        got = numpy.ascontiguousarray(getattr(log, name)[:, 0])
        if isinstance(column, list):
            texts = ["".join(cell[0]) if cell[0].size else "" for cell in getattr(words, name)]
            got = [texts[code - 1] for code in got]
        elif column.dtype == numpy.int32:
            assert got.dtype == numpy.float32 and (numpy.isnan(got) == (column < 0)).all()
            got = numpy.nan_to_num(got, nan=-1.0).astype("i4")
        check("scipy", name, got, column)
    assert set(log._fieldnames) == set(expected) == set(units._fieldnames)
    assert units.angle_rad_1[0] == "rad" and units.torque_nm_2[0] == "N m"
    settings = file["settings"][0, 0]
    assert settings.setup[0, 0].period_us[0, 0] == 1000
    assert settings.limits[0, 0].angle_rad.shape == (1, 2)
    assert "Nothing is interpolated" in file["about"][0]


def check_csv(path, expected):
    with open(path, newline="") as file:
        rows = list(csv.DictReader(file))
    assert set(rows[0]) == set(expected)
    for name, column in expected.items():
        texts = [row[name] for row in rows]
        if isinstance(column, list):
            check("csv", name, texts, column)
        elif column.dtype == numpy.int32:
            check("csv", name, numpy.array([int(t or -1) for t in texts], "i4"), column)
        elif column.dtype.kind == "f":
            got = numpy.array([column.dtype.type(text or "nan") for text in texts])
            # Text has but one NaN.
            got[numpy.isnan(got)] = column[numpy.isnan(got)]
            check("csv", name, got, column)
        else:
            check("csv", name, numpy.array([int(t) for t in texts], column.dtype), column)


folder = pathlib.Path(sys.argv[1])
expected = read_expected(folder / "expected")
check_parquet(folder / "run.parquet", expected)
check_mat(folder / "run.mat", expected)
check_csv(folder / "run.csv", expected)
ticks = len(expected["tick"])
print(f"{len(expected)} columns of {ticks} ticks are the same in Parquet, .mat and CSV")
