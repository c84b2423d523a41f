"""The service as a unit of systemd: as its own user, allowed no more than it needs.

Pure text: nothing is installed.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from autodb.agent.operate.scheduling import systemd_word
from autodb.web.http.settings import Settings

NAME = "autodb.service"
PRIVILEGED = 1024
"""Ports below need a capability (Linux)."""
LOGS = "autodb"
"""Journal of its own (LogNamespace): what is asked of it drives no other service's lines out."""
LOGS_KEPT = (r"[Journal]\nSystemMaxUse=500M\nMaxRetentionSec=90day\n", "journald@autodb.conf")
"""How much is logged, and how long, and the file that says so. Chosen."""
INSTALL = (
    f"printf '{LOGS_KEPT[0]}' | sudo tee /etc/systemd/{LOGS_KEPT[1]}",
    f"autodb serve … --unit | sudo tee /etc/systemd/system/{NAME}",
    f"sudo systemctl daemon-reload && sudo systemctl enable --now {NAME}",
)


@dataclass(frozen=True)
class Runs:
    """What is run, as which user, and the folders that it may write to.

    ``database_here``: its database is a file, so that it asks no other computer.
    """

    command: Sequence[str]
    user: str
    writes: Sequence[Path]
    database_here: bool


def unit(settings: Settings, runs: Runs) -> str:
    """Return the unit that serves with these settings, and what puts it to work as comments."""
    low = settings.port < PRIVILEGED
    bind = "CAP_NET_BIND_SERVICE" if low else ""
    alone = settings.on_loopback and runs.database_here
    lines = [
        *(f"# {line}" for line in INSTALL),
        "[Unit]",
        "Description=autodb service",
        "Wants=network-online.target",
        "After=network-online.target",
        "",
        "[Service]",
        f"ExecStart={' '.join(systemd_word(word) for word in runs.command)}",
        f"User={runs.user}",
        "Restart=on-failure",
        "KillMode=mixed",
        "UMask=0027",
        f"LogNamespace={LOGS}",
        *_SANDBOX,
        f"CapabilityBoundingSet={bind}",
        *([f"AmbientCapabilities={bind}"] if low else []),
        *(["IPAddressDeny=any", "IPAddressAllow=localhost"] if alone else []),
        *(f"ReadWritePaths={systemd_word(str(path))}" for path in runs.writes),
        "",
        "[Install]",
        "WantedBy=multi-user.target",
    ]
    return "\n".join(lines)


_SANDBOX = (
    "NoNewPrivileges=yes",
    "ProtectSystem=strict",
    "ProtectHome=read-only",
    "PrivateTmp=yes",
    "PrivateDevices=yes",
    "ProtectClock=yes",
    "ProtectControlGroups=yes",
    "ProtectHostname=yes",
    "ProtectKernelLogs=yes",
    "ProtectKernelModules=yes",
    "ProtectKernelTunables=yes",
    "ProtectProc=invisible",
    "LockPersonality=yes",
    "RestrictAddressFamilies=AF_INET AF_INET6 AF_UNIX",
    "RestrictNamespaces=yes",
    "RestrictRealtime=yes",
    "RestrictSUIDSGID=yes",
    "SystemCallArchitectures=native",
    "SystemCallFilter=@system-service",
    "SystemCallErrorNumber=EPERM",
    "LimitCORE=0",
)
"""What it needs not: systemd.exec(5)."""
