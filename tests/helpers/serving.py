"""A service on loopback, in a thread of the test."""

import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path

import httpx
import uvicorn
from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import NameOID

from autodb.web import server as serving
from autodb.web.app import make_app
from autodb.web.http.settings import Settings
from autodb.web.server import Certificate


def listening(
    settings: Settings, certificate: Certificate | None = None
) -> tuple[uvicorn.Server, threading.Thread, str]:
    """Return a service that answers, its thread, and its address."""
    settings = replace(settings, port=0, tls=certificate is not None)
    bound = serving.bound(settings)
    made = serving.server_of(make_app(settings), certificate, settings.proxies)
    thread = threading.Thread(target=made.run, kwargs={"sockets": [bound]})
    thread.start()
    while not made.started:
        time.sleep(0.01)
        assert thread.is_alive()
    scheme = "http" if certificate is None else "https"
    return made, thread, f"{scheme}://localhost:{bound.getsockname()[1]}"


@contextmanager
def served(settings: Settings, certificate: Certificate | None = None) -> Iterator[str]:
    """Have a service answer; give its address."""
    made, thread, at = listening(settings, certificate)
    try:
        yield at
    finally:
        made.should_exit = True
        thread.join(30.0)


def wait_for(at: str) -> None:
    """Wait until a service answers."""
    until = time.monotonic() + 60.0
    while time.monotonic() < until:
        with suppress(httpx.HTTPError):
            if httpx.get(f"{at}/healthz").status_code == 200:
                return
        time.sleep(0.1)
    raise AssertionError("it does not answer")


def self_signed(folder: Path) -> Certificate:
    """Return a certificate of this computer that is its own authority, made in a folder."""
    key = ec.generate_private_key(ec.SECP256R1())
    name = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, "localhost")])
    now = datetime.now(UTC)
    made = (
        x509.CertificateBuilder()
        .subject_name(name)
        .issuer_name(name)
        .public_key(key.public_key())
        .serial_number(1)
        .not_valid_before(now - timedelta(days=1))
        .not_valid_after(now + timedelta(days=1))
        .add_extension(x509.SubjectAlternativeName([x509.DNSName("localhost")]), critical=False)
        .add_extension(x509.BasicConstraints(ca=True, path_length=None), critical=True)
        .sign(key, hashes.SHA256())
    )
    pem = serialization.Encoding.PEM
    (folder / "c.pem").write_bytes(made.public_bytes(pem))
    plain = serialization.PrivateFormat.PKCS8, serialization.NoEncryption()
    (folder / "k.pem").write_bytes(key.private_bytes(pem, *plain))
    return Certificate(folder / "c.pem", folder / "k.pem")
