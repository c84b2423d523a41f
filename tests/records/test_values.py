"""Words of a shop's tables mean what the side file says; what is wrong is said at once."""

from pathlib import Path

import pandas as pd
import pytest

from autodb.errors import UnusableInput
from autodb.files.operation_words import OTHERS, WORDS, suggested_operation
from autodb.records import source as records
from autodb.records.tables import CutTable
from tests.conftest import Cli

TABLE = """\
cut,operation,work.material,tool,force.z
1,Längsdrehen,Stahl,A,100
2,Plandrehen,Stahl,A,110
3,turn,C45,B,120
"""


def test_texts_mean_what_the_side_file_says(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text(TABLE, "utf-8")
    (tmp_path / "a.toml").write_text(
        '[values]\noperation = {"Längsdrehen" = "turn", "Plandrehen" = "face"}\n'
        'material = {"Stahl" = "C45"}\ntool = {"A" = "CNMG 120408"}\n',
        "utf-8",
    )
    table = records.read(path)
    assert isinstance(table, CutTable)
    assert table.texts["operation"] == ["turn", "face", "turn"]
    assert table.texts["work.material"] == ["C45"] * 3
    assert table.texts["tool"] == ["CNMG 120408", "CNMG 120408", "B"]


def test_an_unknown_operation_is_said_at_import(cli: Cli, tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text(TABLE, "utf-8")
    cli("init")
    cli("machine", "add", "lathe-1")
    done = cli("import", path, "--machine", "lathe-1")
    assert (done.code, done.err.count("\n")) == (2, 1)
    assert '{"Längsdrehen" = "turn", "Plandrehen" = "face"}' in done.err


def test_an_operation_that_means_none_enters_and_is_said(cli: Cli, tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("cut,operation,force.z\n1,grinding,100\n2,turn,110\n")
    cli("init")
    cli("machine", "add", "lathe-1")
    done = cli("import", path, "--machine", "lathe-1")
    assert done.code == 0
    assert "no operation of ours: 'grinding'" in done.out


def test_all_problems_are_said_at_once(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text(TABLE, "utf-8")
    (tmp_path / "a.toml").write_text(
        '[channels]\n"force.x" = "Fx"\n"force.z" = {column = "force.z", unit = "mA"}\n'
    )
    with pytest.raises(UnusableInput) as refused:
        records.read(path)
    said = str(refused.value)
    assert "2 problems: (1) no column 'Fx'" in said
    assert "(2) column 'force.z': unit 'mA' cannot become N" in said


def test_a_means_for_no_operation_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text(TABLE, "utf-8")
    (tmp_path / "a.toml").write_text('[values]\noperation = {"Längsdrehen" = "turning"}\n', "utf-8")
    with pytest.raises(UnusableInput, match=r"values\.operation"):
        records.read(path)


def test_words_suggest_their_own_operation_and_others_none() -> None:
    for name, words in WORDS.items():
        for word in (name, *words, *(word.upper() for word in words)):
            assert suggested_operation(word) == name, word
    assert [word for word in OTHERS if suggested_operation(word) is not None] == []
    assert suggested_operation("Laengsdrehen") == "turn"
    assert suggested_operation("polieren") is None


@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
def test_a_channel_with_its_unit_in_brackets_is_that_channel(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"a{suffix}"
    table = pd.DataFrame({"t [ms]": [0, 10, 20], "force.x [kN]": [1.0, 2.0, 3.0]})
    if suffix == ".csv":
        table.to_csv(path, index=False)
    else:
        table.to_parquet(path)
    found = records.read(path)
    assert found["t"].tolist() == [0.0, 0.01, 0.02]
    assert found["force.x"].tolist() == [1000.0, 2000.0, 3000.0]


def test_a_channel_without_a_unit_goes_before_one_with_it(tmp_path: Path) -> None:
    path = tmp_path / "a.parquet"
    pd.DataFrame(
        {"t": [0.0, 0.1, 0.2], "force.x": [1.0, 2.0, 3.0], "force.x [kN]": 9.0}
    ).to_parquet(path)
    assert records.read(path)["force.x"].tolist() == [1.0, 2.0, 3.0]
