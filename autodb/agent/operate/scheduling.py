"""Have a machine refreshed every so often: systemd units, or a line for cron.

Pure text: nothing is installed. Commands name everything by its whole path, since neither systemd
nor cron has a working folder or a shell's PATH. Two passes at a time do no harm, and what was
missed while the computer was off is caught up by the next.
"""

import hashlib
import re
import shlex
from collections.abc import Sequence
from dataclasses import dataclass

from autodb.errors import UnusableInput
from autodb.wording import phrase

EVERY_MIN = (1, 2, 3, 4, 5, 6, 10, 12, 15, 20, 30)
EVERY_H = (1, 2, 3, 4, 6, 8, 12, 24)
"""What cron can say: intervals that divide an hour, or a day."""
NICE = 10
"""By how much a pass gives way to who waits for an answer (nice). Chosen: beside a look-up that
wants a core it gets a tenth of it, and all of one that nobody wants."""


@dataclass(frozen=True)
class Units:
    """Two files of systemd by name, and the commands that put them to work."""

    files: dict[str, str]
    to_do: tuple[str, ...]


def systemd_units(machine: str, command: Sequence[str], *, every_min: int) -> Units:
    """Return a service that refreshes a machine once, and a timer that starts it."""
    name = f"autodb-refresh-{slug(machine)}"
    service = f"""[Unit]
Description=autodb refresh of {_unit_text(machine)}

[Service]
Type=oneshot
ExecStart={" ".join(systemd_word(word) for word in command)}
Nice={NICE}
"""
    timer = f"""[Unit]
Description=autodb refresh of {_unit_text(machine)} every {every_min} min

[Timer]
OnBootSec=2min
OnUnitActiveSec={every_min}min
Unit={name}.service

[Install]
WantedBy=timers.target
"""
    to_do = (
        f"cp {name}.service {name}.timer ~/.config/systemd/user/",
        f"systemctl --user daemon-reload && systemctl --user enable --now {name}.timer",
        _command("loginctl enable-linger", phrase("so that it runs while nobody is logged in")),
        _command(f"journalctl --user -u {name}.service", phrase("what it said")),
    )
    return Units({f"{name}.service": service, f"{name}.timer": timer}, to_do)


def _command(words: str, why: str) -> str:
    return f"{words}    # {why}"


def cron_line(command: Sequence[str], *, every_min: int) -> str:
    """Return a line for `crontab -e`; raises UnusableInput for an interval that cron cannot say."""
    hours, minutes = divmod(every_min, 60)
    if every_min in EVERY_MIN:
        when = "* * * * *" if every_min == 1 else f"*/{every_min} * * * *"
    elif not minutes and hours in EVERY_H:
        when = {1: "0 * * * *", 24: "0 0 * * *"}.get(hours, f"0 */{hours} * * *")
    else:
        whole = ", ".join(str(one) for one in (*EVERY_MIN, *(60 * one for one in EVERY_H)))
        raise UnusableInput(
            phrase(
                "--every {minutes}: cron cannot say it; use {whole}",
                minutes=every_min,
                whole=whole,
            )
        )
    words = " ".join(shlex.quote(word) for word in command).replace("%", r"\%")
    return f"{when} nice -n {NICE} {words}"


def slug(machine: str) -> str:
    """Return a machine's name as a file may be called; another name never gives the same."""
    plain = re.sub(r"[^A-Za-z0-9_.-]", "-", machine)
    if plain == machine:
        return plain
    return f"{plain}-{hashlib.sha256(machine.encode()).hexdigest()[:6]}"


def _unit_text(text: str) -> str:
    return text.replace("%", "%%").replace("\n", " ")


def systemd_word(word: str) -> str:
    """Return a word of a command as systemd reads it back."""
    escaped = word.replace("\\", "\\\\").replace('"', '\\"').replace("%", "%%").replace("$", "$$")
    return f'"{escaped}"' if re.search(r"[\s\"';\\]", word) or not word else escaped
