"""A connection to an OPC UA server: user, password, certificate, and what is away."""

import asyncio
import contextlib
import os
from pathlib import Path
from typing import Any

from asyncua.client.client import Client
from asyncua.ua.uaerrors import UaError

from autodb.errors import UnusableInput
from autodb.live.source import Away

TIMEOUT_S = 5.0


def away(url: str, error: Exception) -> Away:
    """Return the refusal of a server that does not answer, or answers with an error."""
    said = str(error).splitlines()
    return Away(f"{url}: {said[0] if said and said[0] else type(error).__name__}")


class OpcUaSession:
    """A connection to a server, as an agent file says it is made."""

    def __init__(self, source: Any) -> None:
        self._source = source
        self._client = Client(source.url, timeout=TIMEOUT_S)

    async def __aenter__(self) -> Client:
        source, client = self._source, self._client
        try:
            if source.user is not None:
                client.set_user(source.user)
            if source.password_env is not None:
                client.set_password(_password(source.password_env))
            if source.security is not None:
                client.application_uri = application_uri(source.security, url=source.url)
                await client.set_security_string(source.security)
            await client.connect()
        except (UaError, OSError, TimeoutError, ValueError) as error:
            raise away(source.url, error) from None
        return client

    async def __aexit__(self, *_: object) -> None:
        with contextlib.suppress(UaError, OSError, TimeoutError):  # it is gone already
            await asyncio.wait_for(self._client.disconnect(), TIMEOUT_S)


def application_uri(security: str, *, url: str) -> str:
    """Return what the certificate of a security text calls its application (OPC 10000-6, 6.2.2).

    A server may refuse a client that calls itself otherwise. Raises UnusableInput for a text that
    is none, or names a file that is not there or no certificate.
    """
    from cryptography import x509

    cells = security.split(",")
    if len(cells) not in (4, 5):
        raise UnusableInput(
            f"{url}: security = '{security}' is not POLICY,MODE,CERTIFICATE,KEY, like "
            "Basic256Sha256,SignAndEncrypt,cert.pem,key.pem"
        )
    for name in cells[2:]:
        if not Path(name).is_file():
            raise UnusableInput(f"{url}: security: no file {name}")
    content = Path(cells[2]).read_bytes()
    pem = content.lstrip().startswith(b"-----")
    try:
        read = x509.load_pem_x509_certificate if pem else x509.load_der_x509_certificate
        names = read(content).extensions.get_extension_for_class(x509.SubjectAlternativeName)
        uris = names.value.get_values_for_type(x509.UniformResourceIdentifier)
    except (ValueError, x509.ExtensionNotFound) as error:
        raise UnusableInput(f"{url}: security: {cells[2]} is no certificate ({error})") from None
    if not uris:
        raise UnusableInput(f"{url}: security: {cells[2]} names no application (URI)")
    return uris[0]


def _password(variable: str) -> str:
    if variable not in os.environ:
        raise UnusableInput(f"password_env: no variable {variable} in the environment; set it")
    return os.environ[variable]
