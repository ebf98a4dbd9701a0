"""What a client shows to whom: tokens, and certificates of servers and clients."""

import asyncio
import os
import subprocess
import unittest
import unittest.mock
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from tempfile import TemporaryDirectory

import baudbot
import grpc
from baudbot.attach import unlisted
from baudbot.channel import open_channel
from baudbot.credentials import Credentials, own_token
from baudbot.handshake import failed, of_client, of_server
from server import Server

TOKEN = "baudbot_" + "A" * 43
#: Addresses of other machines, of which there is none: these numbers are for documents.
ELSEWHERE = ("192.0.2.7:7400", "http://192.0.2.7:7400/", "robots.lab:7400", "localhost.lab:7400", "[2001:db8::7]:7400")
HERE = (
    "127.0.0.1:7400",
    "http://127.8.9.10:7400/",
    "localhost:7400",
    "LOCALHOST.:7400",
    "robots.localhost:7400",
    "[::1]:7400",
    "[::ffff:127.0.0.1]:7400",
    "0.0.0.0:7400",
    "unix:/tmp/a.sock",
)


def environment(**variables):
    """The environment without what may be set there, and with these variables."""
    names = ("TOKEN", "TOKEN_FILE", "CA", "CERTIFICATE", "KEY", "CONNECT", "WORLD", "ROBOT")
    rest = {name: value for name, value in os.environ.items() if name not in {f"BAUDBOT_{name}" for name in names}}
    return unittest.mock.patch.dict(os.environ, rest | variables, clear=True)


class Still(baudbot.Brain):
    def step(self, turn):
        return None


class Tokens(unittest.TestCase):
    def folder(self):
        return Path(self.enterContext(TemporaryDirectory()))

    def refused(self, text, address="127.0.0.1:7400", **variables):
        with self.assertRaises(baudbot.Refused) as caught:
            Credentials.find(address, variables)
        self.assertIn(text, str(caught.exception))

    def test_none_is_sent_to_another_machine_without_tls(self):
        for address in ELSEWHERE:
            place = address.removeprefix("http://").rstrip("/")
            self.refused(f"no token is sent to {place} without TLS", address, BAUDBOT_TOKEN=TOKEN)
            self.refused(f"write https://{place}, or, if the server is behind a proxy, the proxy's", address, BAUDBOT_TOKEN=TOKEN)
            self.assertIsNone(Credentials.find(address, {}).token, "without a token the address is as good as any")
            self.assertEqual(Credentials.find(f"https://{place}", {"BAUDBOT_TOKEN": TOKEN}).token, TOKEN)
        for address in HERE:
            self.assertEqual(Credentials.find(address, {"BAUDBOT_TOKEN": TOKEN}).token, TOKEN, address)

    def test_no_way_to_a_server_sends_one(self):
        ways = (
            open_channel,
            baudbot.Client,
            baudbot.Trainer,
            lambda address: baudbot.attach(Still, connect=address, world="w", robots="r"),
            lambda address: asyncio.run(baudbot.aio.attach(Still, connect=address, world="w", robots="r")),
        )
        with environment(BAUDBOT_TOKEN=TOKEN):
            for way in ways:
                with self.assertRaisesRegex(baudbot.Refused, "no token is sent to 192.0.2.7:7400 without TLS"):
                    way("http://192.0.2.7:7400")

    def test_ones_own_is_for_servers_of_this_machine(self):
        folder = self.folder() / "baudbot"
        folder.mkdir(mode=0o700)
        for address in ("127.0.0.1:7400", "192.0.2.7:7400", "robots.lab:7400"):
            (folder / f"{address}.token").write_text(TOKEN)
        with environment(XDG_RUNTIME_DIR=str(folder.parent)):
            for address in ("127.0.0.1:7400", "http://localhost:7400", "https://127.0.0.1:7400"):
                self.assertEqual(own_token(address), TOKEN, address)
            for address in (*ELSEWHERE, "https://192.0.2.7:7400"):
                self.assertIsNone(own_token(address), address)

    def test_what_is_empty_is_not_set(self):
        folder = self.folder()
        (folder / "token").write_text(f"{TOKEN}\n")
        names = ("TOKEN", "TOKEN_FILE", "CA", "CERTIFICATE", "KEY")
        empty = {f"BAUDBOT_{name}": "" for name in names}
        self.assertEqual(Credentials.find("192.0.2.7:7400", empty), Credentials())
        from_file = empty | {"BAUDBOT_TOKEN_FILE": str(folder / "token")}
        self.assertEqual(Credentials.find("127.0.0.1:7400", from_file).token, TOKEN)
        (folder / "baudbot").mkdir(mode=0o700)
        (folder / "baudbot/127.0.0.1:7400.token").write_text(TOKEN)
        with environment(XDG_RUNTIME_DIR=str(folder)):
            self.assertEqual(Credentials.find("127.0.0.1:7400", empty).token, TOKEN)

    def test_files_that_cannot_be_used_are_named_with_their_variable(self):
        folder = self.folder()
        missing, binary, long = (folder / name for name in ("missing", "binary", "long"))
        binary.write_bytes(b"\xff\xfe")
        long.write_text("a" * 4097)
        for name in ("TOKEN_FILE", "CA"):
            self.refused(f"BAUDBOT_{name}={missing}: No such file or directory", **{f"BAUDBOT_{name}": str(missing)})
        self.refused(f"BAUDBOT_TOKEN_FILE={binary}: is not a text", BAUDBOT_TOKEN_FILE=str(binary))
        self.refused(f"BAUDBOT_TOKEN_FILE={long}: has more than 4096 bytes", BAUDBOT_TOKEN_FILE=str(long))
        self.refused("BAUDBOT_TOKEN_FILE=/dev/zero: has more than 4096 bytes", BAUDBOT_TOKEN_FILE="/dev/zero")
        self.refused("BAUDBOT_CA=/dev/zero: has more than 1048576 bytes", BAUDBOT_CA="/dev/zero")
        self.refused("BAUDBOT_CERTIFICATE: needs its key, in BAUDBOT_KEY", BAUDBOT_CERTIFICATE="a.pem")
        self.refused("BAUDBOT_KEY: needs its certificate, in BAUDBOT_CERTIFICATE", BAUDBOT_KEY="a.pem")

    def test_one_that_only_drives_needs_names(self):
        class Refusal(grpc.RpcError):
            def __init__(self, code):
                self.code, self.details = lambda: code, lambda: "the token `a` has no right to this"

        told = str(unlisted(Refusal(grpc.StatusCode.PERMISSION_DENIED)))
        self.assertIn("this token cannot list worlds and robots, so name the world and the robots in full", told)
        self.assertIn("the token `a` has no right to this", told)
        self.assertIsNone(unlisted(Refusal(grpc.StatusCode.UNAVAILABLE)))


class Denies(grpc.GenericRpcHandler):
    """Has no right for anybody."""

    def service(self, handler_call_details):
        def deny(request, context):
            context.abort(grpc.StatusCode.PERMISSION_DENIED, "no right to this")

        return grpc.unary_unary_rpc_method_handler(deny)


class Listing(unittest.TestCase):
    def test_is_not_needed_by_those_who_may_not(self):
        with ThreadPoolExecutor() as pool:
            server = grpc.server(pool, handlers=[Denies()])
            address = f"127.0.0.1:{server.add_insecure_port('127.0.0.1:0')}"
            server.start()
            try:
                with environment():
                    for attach in (baudbot.attach, lambda *given, **more: asyncio.run(baudbot.aio.attach(*given, **more))):
                        with self.assertRaisesRegex(baudbot.Refused, "cannot list worlds and robots, so name .* no right to this"):
                            attach(Still, connect=address)
            finally:
                server.stop(None).wait()


class Lab:
    """An authority, and what it has signed, by OpenSSL."""

    def __init__(self, folder):
        self.folder = Path(folder)
        self._openssl("req", "-x509", *self._key("ca"), "-days", "2", "-out", self.path("ca.pem"))

    def path(self, name):
        return str(self.folder / name)

    def sign(self, name, extension):
        """A certificate and its key."""
        self._openssl("req", *self._key(name), "-out", self.path("request"))
        Path(self.path("extension")).write_text(extension)
        authority = ["-CA", self.path("ca.pem"), "-CAkey", self.path("ca-key.pem"), "-CAcreateserial", "-days", "1"]
        extensions = ["-extfile", self.path("extension")]
        self._openssl("x509", "-req", "-in", self.path("request"), *authority, *extensions, "-out", self.path(f"{name}.pem"))
        return self.path(f"{name}.pem"), self.path(f"{name}-key.pem")

    def _key(self, name):
        curve = ["-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes"]
        return [*curve, "-subj", f"/CN={name}", "-keyout", self.path(f"{name}-key.pem")]

    def _openssl(self, *arguments):
        subprocess.run(["openssl", *arguments], check=True, capture_output=True, timeout=60)


class Certificates(unittest.TestCase):
    def lab(self):
        return Lab(self.enterContext(TemporaryDirectory()))

    def serve(self, certificate, key, clients=None):
        """The address of a server with this certificate, which may ask clients for one of this authority."""
        pair = [(Path(key).read_bytes(), Path(certificate).read_bytes())]
        authority = clients and Path(clients).read_bytes()
        pool = self.enterContext(ThreadPoolExecutor())
        server = grpc.server(pool)
        port = server.add_secure_port("127.0.0.1:0", grpc.ssl_server_credentials(pair, authority, clients is not None))
        server.start()
        self.addCleanup(lambda: server.stop(None).wait())
        return f"https://127.0.0.1:{port}"

    def error(self, address, **variables):
        """The error of a call with this environment."""
        with environment(**variables), baudbot.Client(address) as client, self.assertRaises(baudbot.Error) as caught:
            client.worlds()
        return caught.exception

    def untrusted(self, text, address, **variables):
        error = self.error(address, **variables)
        self.assertIsInstance(error, baudbot.Untrusted, error)
        self.assertEqual(str(error).replace(address, "ADDRESS"), text)
        self.assertFalse(error.may_pass)

    def test_of_a_server_are_known_by_authority_and_name(self):
        lab, others = self.lab(), self.lab()
        address = self.serve(*lab.sign("server", "subjectAltName=IP:127.0.0.1"))
        served = self.error(address, BAUDBOT_CA=lab.path("ca.pem"))
        self.assertIn("UNIMPLEMENTED", str(served), "it is reached")
        of = "the certificate of the server at ADDRESS"
        self.untrusted(f"{of} is not trusted: name the authority that signed it with BAUDBOT_CA", address)
        ca = others.path("ca.pem")
        signed = f"the authority in {ca} has not signed it; name the one that has with BAUDBOT_CA"
        self.untrusted(f"{of} is not trusted: {signed}", address, BAUDBOT_CA=ca)
        elsewhere = self.serve(*lab.sign("elsewhere", "subjectAltName=DNS:robots.lab"))
        name = "is not valid for the name `127.0.0.1`: connect by a name that it has, or give the server one for this name"
        self.untrusted(f"{of} {name}", elsewhere, BAUDBOT_CA=lab.path("ca.pem"))

    def test_of_a_client_may_be_wanted(self):
        lab, others = self.lab(), self.lab()
        certificate, key = lab.sign("server", "subjectAltName=IP:127.0.0.1")
        ca, folder = lab.path("ca.pem"), self.enterContext(TemporaryDirectory())
        server = Server(folder, "wander", "--paused", "--tls", f"{certificate},{key}", "--client-ca", ca)
        self.addCleanup(server.kill)
        address = f"https://{server.tcp}"
        wanted = "asks for a client certificate: set BAUDBOT_CERTIFICATE and BAUDBOT_KEY"
        self.untrusted(f"the server at ADDRESS {wanted}", address, BAUDBOT_CA=ca)
        certificate, key = others.sign("strange", "extendedKeyUsage=clientAuth")
        own = {"BAUDBOT_CERTIFICATE": certificate, "BAUDBOT_KEY": key}
        self.untrusted(f"the server at ADDRESS {of_client(certificate)}", address, BAUDBOT_CA=ca, **own)
        certificate, key = lab.sign("client", "extendedKeyUsage=clientAuth")
        with environment(BAUDBOT_CA=ca, BAUDBOT_CERTIFICATE=certificate, BAUDBOT_KEY=key), baudbot.Client(address) as client:
            self.assertEqual([world.name for world in client.worlds()], ["wander"])

    def test_that_are_no_pair_are_refused(self):
        lab = self.lab()
        address = self.serve(*lab.sign("server", "subjectAltName=IP:127.0.0.1"), lab.path("ca.pem"))
        certificate, key = lab.sign("client", "extendedKeyUsage=clientAuth")[0], lab.path("ca-key.pem")
        error = self.error(address, BAUDBOT_CA=lab.path("ca.pem"), BAUDBOT_CERTIFICATE=certificate, BAUDBOT_KEY=key)
        self.assertIn(f"BAUDBOT_CERTIFICATE={certificate} and BAUDBOT_KEY={key}: are no certificate and its key", str(error))

    def test_have_their_time(self):
        self.assertEqual(of_server(10, "", "a", None), "has expired: the server needs a new one")
        self.assertEqual(of_server(9, "", "a", None), "is not valid yet: is the clock of this machine right?")
        self.assertEqual(of_server(24, "bad\n", "a", None), r"cannot be trusted (bad\u{a})")

    def test_are_not_the_reason_if_nobody_listens_or_tls_is_not_spoken(self):
        self.assertRegex(str(self.error("https://127.0.0.1:1")), r"^no server answers at https://127.0.0.1:1 \((?!.*certificate:)")
        server = grpc.server(self.enterContext(ThreadPoolExecutor()))
        address = f"https://127.0.0.1:{server.add_insecure_port('127.0.0.1:0')}"
        server.start()
        self.addCleanup(lambda: server.stop(None).wait())
        self.assertIn("the program that listens there does not use TLS; write the address without https://", str(self.error(address)))


class Silence(unittest.TestCase):
    def test_may_be_for_want_of_a_certificate(self):
        import socket

        class Lost(grpc.RpcError):
            def __init__(self):
                self.code, self.details, self.trailing_metadata = lambda: grpc.StatusCode.UNAVAILABLE, lambda: "closed", lambda: ()

        with socket.create_server(("127.0.0.1", 0)) as listener, environment(), ThreadPoolExecutor() as pool:
            closes = pool.submit(lambda: listener.accept()[0].close())
            address = f"https://127.0.0.1:{listener.getsockname()[1]}"
            error = failed(Lost(), address)
            closes.result()
        hint = "a server there may ask for a client certificate: set BAUDBOT_CERTIFICATE and BAUDBOT_KEY"
        self.assertEqual(str(error), f"no server answers at {address} (closed; {hint}); is `baudbot serve` running there?")


if __name__ == "__main__":
    unittest.main(verbosity=2)
