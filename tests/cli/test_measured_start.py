"""A shop that has measured forces and no current: it is not sent to calibrate."""

from pathlib import Path

from tests.conftest import Cli

ROWS = (
    "Versuch;Verfahren;Werkstoff;Schneidplatte;vc [m/min];f [mm/U];ap [mm];Fc [N];Ff [N];Fp [N]\n"
    "1;Längsdrehen;C45E;CNMG 120408;200;0,20;2,5;1251,7;556,6;384,2\n"
    "2;Längsdrehen;C45E;CNMG 120408;240;0,25;1,0;611,7;254,7;271,0\n"
    "3;Längsdrehen;C45E;CNMG 120408;120;0,30;2,0;1380,1;600,3;462,0\n"
)


def test_measured_forces_are_not_sent_to_calibrate(cli: Cli) -> None:
    Path("Versuche.csv").write_text(ROWS, encoding="cp1252")
    cli("init")
    cli("machine", "add", "lathe-1")
    assert (
        "have 'autodb look FILE --write' propose a side file" in cli("import", "Versuche.csv").err
    )
    assert cli("look", "Versuche.csv", "--write").code == 0
    assert cli("import", "Versuche.csv").code == 0
    steps = cli().out
    assert "autodb refresh" in steps
    assert "calibrate" not in steps
    refused = cli("calibrate")
    assert refused.code == 2
    assert refused.err.endswith("measured need no calibration: run 'autodb refresh'\n")
    assert "C45E / CNMG 120408: version 1 from 3 cuts" in cli("refresh").out
