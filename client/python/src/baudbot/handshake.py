"""Why a call does not reach its server over TLS.

gRPC tells it only in words, which differ between its versions. So the reason is found by a handshake of Python's own, whose errors have
codes.
"""

from __future__ import annotations

import re
import socket
import ssl
from contextlib import suppress

import grpc

from .channel import target
from .credentials import Credentials
from .errors import Error, Refused, Untrusted, from_rpc, is_unreached, printable

#: How long a server may take for each part of the handshake.
_PATIENCE_S = 5.0

#: What a client of HTTP/2 says first, with settings that change nothing. Each server has an answer to it.
_FIRST_WORDS = b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n" + b"\x00\x00\x00\x04\x00\x00\x00\x00\x00"

#: Alerts of a server about the certificate that it was shown, or was not, by their names in OpenSSL.
_OF_CLIENT = re.compile(r"ALERT_(.*CERTIFICATE|UNKNOWN_CA|ACCESS_DENIED|DECRYPT_ERROR)")


def failed(error: grpc.RpcError, address: str) -> Error:
    """The error of a call to the server at this address. If certificates are the reason, it says so."""
    if not is_unreached(error) or not address.startswith("https://"):
        return from_rpc(error, address)
    credentials = Credentials.find(address)
    context, hint = _context(credentials), ""
    try:
        if not _is_answered(target(address), context):
            hint = _may_be(credentials.certificate_file)
    except ssl.SSLCertVerificationError as problem:
        host = _host(target(address))[0]
        text = of_server(problem.verify_code, problem.verify_message, host, credentials.ca_file)
        return Untrusted(f"the certificate of the server at {address} {text}")
    except ssl.SSLError as problem:
        reason = problem.reason or ""
        if _OF_CLIENT.search(reason):
            return Untrusted(f"the server at {address} {of_client(credentials.certificate_file)}")
        if reason == "WRONG_VERSION_NUMBER":
            hint = "the program that listens there does not use TLS; write the address without https://"
        elif "ALERT" in reason or isinstance(problem, (ssl.SSLEOFError, ssl.SSLZeroReturnError)):
            hint = _may_be(credentials.certificate_file)
    except OSError:
        pass  # what cannot be reached at all has nothing to do with certificates
    return from_rpc(error, address, hint and f"; {hint}")


def of_server(code: int, words: str, host: str, ca: str | None) -> str:
    """What is wrong with the certificate of a server, by OpenSSL's code, and what to do about it."""
    if code == 10:
        return "has expired: the server needs a new one"
    if code == 9:
        return "is not valid yet: is the clock of this machine right?"
    if code in (62, 64):
        return f"is not valid for the name `{host}`: connect by a name that it has, or give the server one for this name"
    # No issuer that is known, of a chain or of one alone, or one of the same name with another key.
    if code not in (2, 7, 18, 19, 20, 21):
        return f"cannot be trusted ({printable(words)})"
    if ca is None:
        return "is not trusted: name the authority that signed it with BAUDBOT_CA"
    return f"is not trusted: the authority in {printable(ca)} has not signed it; name the one that has with BAUDBOT_CA"


def of_client(certificate: str | None) -> str:
    """What a server wants that does not take the certificate which it is shown."""
    if certificate is None:
        return "asks for a client certificate: set BAUDBOT_CERTIFICATE and BAUDBOT_KEY"
    shown = printable(certificate)
    return f"does not accept the client certificate in {shown}: it may have expired, or the server does not trust the authority that signed it"


def _may_be(certificate: str | None) -> str:
    """What the reason may be why a server hangs up, or is silent."""
    if certificate is None:
        return "a server there may ask for a client certificate: set BAUDBOT_CERTIFICATE and BAUDBOT_KEY"
    return f"a server there may not trust the authority that signed the client certificate in {printable(certificate)}"


def _host(authority: str) -> tuple[str, str]:
    host, _, port = authority.rpartition(":")
    return host.removeprefix("[").removesuffix("]"), port


def _is_answered(authority: str, context: ssl.SSLContext) -> bool:
    """Whether the server answers after a handshake, and neither hangs up nor is silent. Raises what is wrong with the handshake, and
    an OSError if nobody takes the connection.
    """
    host, port = _host(authority)
    with socket.create_connection((host, port), timeout=_PATIENCE_S) as plain:
        try:
            with context.wrap_socket(plain, server_hostname=host) as secure:
                # A server that hangs up has said before why.
                with suppress(OSError):
                    secure.sendall(_FIRST_WORDS)
                return bool(secure.recv(1))
        except ssl.SSLError:
            raise
        except OSError:
            return False


def _context(credentials: Credentials) -> ssl.SSLContext:
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    context.set_alpn_protocols(["h2"])
    # gRPC trusts a server's own certificate, too.
    context.verify_flags |= ssl.VERIFY_X509_PARTIAL_CHAIN
    try:
        if credentials.ca_file is None:
            context.load_default_certs()
        else:
            context.load_verify_locations(credentials.ca_file)
    except OSError:
        ca = printable(credentials.ca_file or "")
        raise Refused(f"BAUDBOT_CA={ca}: has no certificate (-----BEGIN CERTIFICATE-----)") from None
    if credentials.certificate_file is not None:
        try:
            # With a password nobody is asked for one.
            context.load_cert_chain(credentials.certificate_file, credentials.key_file, password="")
        except OSError as error:
            text = printable(f"BAUDBOT_CERTIFICATE={credentials.certificate_file} and BAUDBOT_KEY={credentials.key_file}")
            raise Refused(f"{text}: are no certificate and its key ({getattr(error, 'reason', None) or error})") from None
    return context
