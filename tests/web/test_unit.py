"""The service as a unit of systemd: read back as systemd does, and nothing wrong with it."""

import configparser
import shlex
import shutil
import subprocess
from pathlib import Path

import pytest

from tests.conftest import Cli

LOCKED = {
    "NoNewPrivileges": "yes", "ProtectSystem": "strict", "PrivateTmp": "yes",
    "CapabilityBoundingSet": "", "KillMode": "mixed", "LimitCORE": "0",
}  # fmt: skip


def _parsed(text: str) -> configparser.ConfigParser:
    parsed = configparser.ConfigParser(interpolation=None, strict=False)
    parsed.optionxform = str  # type: ignore[assignment, method-assign]
    parsed.read_string(text)
    return parsed


def _unit(cli: Cli, *options: object) -> str:
    """Return the unit of a service that may write."""
    cli("init")
    cli("token", "add", "shop", "--role", "operate")
    done = cli("serve", "--unit", "--write", *options)
    assert (done.code, done.err) == (0, "")
    return done.out


def test_the_unit_serves_as_it_was_said(cli: Cli) -> None:
    Path("kept recordings").mkdir()
    options = ("--host", "0.0.0.0", "--recordings", "kept recordings", "--upload-mib", 64,
               "--units", "inch")  # fmt: skip
    names = ("--name", "a.example", "--name", "b.example")
    unit = _parsed(_unit(cli, *options, *names, "--proxy", "192.0.2.1"))
    service = unit["Service"]
    words = shlex.split(service["ExecStart"])
    here = Path.cwd().resolve()
    assert words[1:4] == ["-m", "autodb", "serve"]
    said = dict(zip(words[4::2], words[5::2], strict=False))
    assert said["--db"] == f"sqlite:///{here / 'autodb.sqlite3'}"
    assert words[words.index("--recordings") + 1] == str(here / "kept recordings")
    assert words[words.index("--upload-mib") + 1] == "64"
    assert words[words.index("--units") + 1] == "inch"
    assert [words[k + 1] for k, word in enumerate(words) if word == "--name"] == [
        "a.example", "b.example"
    ]  # fmt: skip
    assert words[words.index("--proxy") + 1] == "192.0.2.1"
    assert "--write" in words
    assert service["User"] == Path("autodb.sqlite3").owner()
    assert LOCKED.items() <= dict(service).items()
    assert "IPAddressDeny" not in service


def test_it_may_write_its_own_folders_alone(cli: Cli) -> None:
    Path("kept").mkdir()
    text = _unit(cli, "--recordings", "kept")
    here = Path.cwd().resolve()
    wanted = [f"ReadWritePaths={here}", f"ReadWritePaths={here / 'kept'}"]
    assert [line for line in text.splitlines() if line.startswith("ReadWritePaths")] == wanted
    assert "IPAddressDeny=any\nIPAddressAllow=localhost" in text


def test_its_log_is_bounded_and_drives_out_no_others(cli: Cli) -> None:
    text = _unit(cli)
    journal = _parsed(text)["Service"]["LogNamespace"]
    first = text.splitlines()[0]
    assert f"/etc/systemd/journald@{journal}.conf" in first
    printed = shlex.split(first)[2].encode().decode("unicode_escape")
    assert dict(_parsed(printed)["Journal"]) == {"SystemMaxUse": "500M", "MaxRetentionSec": "90day"}


def test_a_low_port_takes_the_one_capability_that_it_needs(cli: Cli) -> None:
    service = _parsed(_unit(cli, "--port", 443))["Service"]
    assert service["CapabilityBoundingSet"] == service["AmbientCapabilities"]
    assert service["AmbientCapabilities"] == "CAP_NET_BIND_SERVICE"


def test_systemd_finds_nothing_wrong_with_it(cli: Cli, tmp_path: Path) -> None:
    verify = shutil.which("systemd-analyze")
    if verify is None:
        pytest.skip("systemd-analyze is not here")
    (tmp_path / "autodb.service").write_text(_unit(cli, "--port", 443), encoding="utf-8")
    done = subprocess.run(
        [verify, "verify", str(tmp_path / "autodb.service")],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert [line for line in done.stderr.splitlines() if "autodb" in line] == []


@pytest.mark.parametrize(
    ("options", "line"),
    [
        (("--upload-mib", "9"), "with --write only"),
        (("--recordings", "."), "with --write only"),
        (("--write", "--recordings", "none"), "none: no such folder"),
        (("--write", "--unit"), "autodb token add NAME --role operate"),
    ],
)
def test_what_would_not_serve_is_refused(cli: Cli, options: tuple[str, ...], line: str) -> None:
    cli("init")
    done = cli("serve", *options)
    assert (done.code, line in done.err) == (2, True), done.err
