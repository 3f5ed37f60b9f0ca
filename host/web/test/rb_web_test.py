"""Speaks to the real rb-web as strangers, crowds and sluggards do.  Needs $RB_BIN and
$RB_SOURCE.
"""

import base64
import contextlib
import http.client
import json
import os
import pathlib
import re
import select
import socket
import struct
import subprocess
import sys
import tempfile
import time
import unittest

sys.path.insert(0, str(pathlib.Path(os.environ["RB_SOURCE"], "common/test")))
from bus_url import bus_url  # noqa: E402

BIN = pathlib.Path(os.environ["RB_BIN"])
PROGRAM = BIN / "rb-web"
PATIENCE_S = 60  # for what must happen; sanitizers are slow


@contextlib.contextmanager
def rb_web(*arguments):
    """A running program, and the port it listens on."""
    with subprocess.Popen([PROGRAM, "--url", bus_url(), "--port", "0", *arguments], stdout=subprocess.PIPE,
                          stderr=subprocess.PIPE, text=True) as program:
        try:
            where = program.stdout.readline()
            found = re.fullmatch(r"http://(\S+):(\d+)/#token=(\S+)\n", where)
            if not found:
                raise AssertionError(where + program.stderr.read())
            program.port, program.token = int(found[2]), found[3]
            yield program
        finally:
            program.terminate()
            _, errors = program.communicate()
        # Whatever was said to it, it has lived until it was told to stop, and sanitizers found nothing.
        if program.returncode != 0 or errors:
            raise AssertionError(f"rb-web ended with {program.returncode}: {errors}")


class Ear:
    """Hears requests on the bus: LCM's datagrams, each "LC02", a number, the channel's name, a zero and the message."""

    def __enter__(self):
        group, port = re.fullmatch(r"udpm://([\d.]+):(\d+)\?ttl=0", bus_url()).groups()
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        self.socket.bind((group, int(port)))
        self.socket.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP,
                               socket.inet_aton(group) + socket.inet_aton("0.0.0.0"))
        self.socket.settimeout(PATIENCE_S)
        return self

    def __exit__(self, *_):
        self.socket.close()

    def next(self):
        while True:
            datagram = self.socket.recv(65536)
            if datagram.startswith(b"LC02") and datagram[8:].startswith(b"RB_REQUEST\0"):
                return datagram


def request(text):
    """A mark, asked for under a number of its own."""
    number = int.from_bytes(os.urandom(6), "big") + 1
    return json.dumps({"asker": 7, "request": number, "operation": "mark", "text": text}).encode()


def get(program, path="/", method="GET", host=None, body=None, **headers):
    """Status, headers and body."""
    with contextlib.closing(http.client.HTTPConnection("127.0.0.1", program.port, timeout=PATIENCE_S)) as connection:
        connection.putrequest(method, path, skip_host=True, skip_accept_encoding=True)
        if host != "":
            connection.putheader("Host", host or f"127.0.0.1:{program.port}")
        for name, value in headers.items():
            connection.putheader(name.replace("_", "-"), value)
        if body is not None:
            connection.putheader("Content-Length", str(len(body)))
        connection.endheaders(body)
        answer = connection.getresponse()
        return answer.status, answer.headers, answer.read()


def own(program):
    return f"http://127.0.0.1:{program.port}"


def raw(program, data=b""):
    stream = socket.create_connection(("127.0.0.1", program.port), timeout=PATIENCE_S)
    stream.sendall(data)
    return stream


def upgrade(program, origin=None, protocols="roadbalance", path="/feed", host=None):
    lines = [f"GET {path} HTTP/1.1", f"Host: {host or f'127.0.0.1:{program.port}'}", "Connection: Upgrade",
             "Upgrade: websocket", "Sec-WebSocket-Version: 13",
             "Sec-WebSocket-Key: " + base64.b64encode(os.urandom(16)).decode()]
    if origin != "":
        lines.append(f"Origin: {origin or own(program)}")
    if protocols:
        lines.append(f"Sec-WebSocket-Protocol: {protocols}")
    stream = raw(program, "\r\n".join(lines + ["", ""]).encode())
    return stream, read_head(stream)


def read_head(stream):
    """Status line and headers of an answer; empty if the other side hung up."""
    head = b""
    with contextlib.suppress(ConnectionResetError):
        while not head.endswith(b"\r\n\r\n"):
            byte = stream.recv(1)
            if not byte:
                break
            head += byte
    return head.decode()


def status(head):
    return int(head.split()[1]) if head else None


def is_hung_up(stream, seconds=PATIENCE_S):
    """True once nothing can be read any more."""
    stream.settimeout(seconds)
    try:
        while stream.recv(65536):
            pass
        return True
    except ConnectionResetError:
        return True
    except TimeoutError:
        return False


def frame(opcode, payload):
    """Of a client: masked, with a mask of zeros."""
    length = len(payload)
    size = bytes([0x80 | length]) if length < 126 else b"\xfe" + struct.pack(">H", length)
    return bytes([0x80 | opcode]) + size + bytes(4) + payload


def read_exactly(stream, count):
    data = b""
    while len(data) < count:
        part = stream.recv(count - len(data))
        if not part:
            raise AssertionError("hung up")
        data += part
    return data


def read_frame(stream):
    """Payload of the next binary frame."""
    while True:
        first, size = read_exactly(stream, 2)
        if size in (126, 127):
            size = int.from_bytes(read_exactly(stream, 2 if size == 126 else 8), "big")
        payload = read_exactly(stream, size)
        if first == 0x82:
            return payload


def fingerprint(message):
    """The first eight bytes of a message of numbers, of its .lcm file as LCM computes them."""
    text = pathlib.Path(os.environ["RB_SOURCE"], f"common/wire/{message}.lcm").read_text(encoding="utf-8")
    value = 0x12345678

    def add(number):
        nonlocal value
        signed = value - (1 << 64) if value >> 63 else value
        value = (((value << 8) & (1 << 64) - 1 ^ (signed >> 55) & (1 << 64) - 1) + number) & (1 << 64) - 1

    def add_text(word):
        for number in (len(word), *word.encode()):
            add(number)

    for kind, name, extents in re.findall(r"^\s+(\w+)\s+(\w+)((?:\[\d+\])*);", text, re.MULTILINE):
        add_text(name)
        add_text(kind)
        sizes = re.findall(r"\d+", extents)
        add(len(sizes))
        for size in sizes:
            add(0)
            add_text(size)
    return ((value << 1) + (value >> 63)) & (1 << 64) - 1


def view(viewer, segment=4096, pairs=0):
    """A view_t that wants nothing but itself to be known."""
    numbers = struct.pack(">Qqiiii", fingerprint("view_t"), viewer, segment, 1, 20, 0) + struct.pack(">ddi", 0.5, 250.0, pairs)
    return numbers + bytes(4 * (64 + 1 + 32 + 1 + 32 + 1 + 12))


class Local(unittest.TestCase):
    """As it runs by itself: on this machine's loopback."""

    @classmethod
    def setUpClass(cls):
        cls.stack = contextlib.ExitStack()
        cls.program = cls.stack.enter_context(rb_web())

    @classmethod
    def tearDownClass(cls):
        cls.stack.close()

    def test_listens_on_loopback_only(self):
        wanted = f"{self.program.port:04X}"
        addresses = [line.split()[1] for table in ("tcp", "tcp6")
                     for line in pathlib.Path("/proc/net", table).read_text(encoding="ascii").splitlines()[1:]
                     if line.split()[3] == "0A" and line.split()[1].endswith(":" + wanted)]
        self.assertEqual(addresses, ["0100007F:" + wanted])

    def test_serves_the_page_and_nothing_else(self):
        for path, kind in (("/", "text/html"), ("/page.js", "text/javascript"), ("/page.css", "text/css"),
                           ("/favicon.ico", "image/svg+xml")):
            code, headers, body = get(self.program, path)
            self.assertEqual((code, headers["Content-Type"].split(";")[0]), (200, kind))
            self.assertEqual(len(body), int(headers["Content-Length"]))
            self.assertGreater(len(body), 100)
        for path in ("/index.html", "/../../etc/passwd", "/%2e%2e/etc/passwd", "//etc/passwd", "/page.js/", "/proc/self/environ",
                     "/page.js%00", "*", "/?/etc/passwd"):
            self.assertEqual(get(self.program, path)[0], 404, path)

    def test_head_says_what_get_would(self):
        code, headers, body = get(self.program, "/page.js", method="HEAD")
        self.assertEqual((code, body), (200, b""))
        self.assertEqual(headers["Content-Length"], get(self.program, "/page.js")[1]["Content-Length"])

    def test_refuses_hosts_that_are_not_us(self):
        for host in ("", "evil.example", f"evil.example:{self.program.port}", "127.0.0.1",
                     f"127.0.0.1:{self.program.port + 1}", f"127.0.0.1:{self.program.port}.evil.example"):
            self.assertEqual(get(self.program, host=host)[0], 421, host)
        self.assertEqual(get(self.program, host=f"localhost:{self.program.port}")[0], 200)

    def test_refuses_two_hosts(self):
        host = f"Host: 127.0.0.1:{self.program.port}\r\n"
        with raw(self.program, f"GET / HTTP/1.1\r\n{host}{host}\r\n".encode()) as stream:
            self.assertIn(status(read_head(stream)), (400, 421))

    def test_says_nothing_to_pages_of_others(self):
        for path in ("/", "/page.js", "/nothing"):
            _, headers, _ = get(self.program, path)
            self.assertFalse([name for name in headers if name.lower().startswith("access-control")])
        self.assertEqual(get(self.program, Origin="http://evil.example")[0], 403)
        code, headers, _ = get(self.program, method="OPTIONS", Origin="http://evil.example",
                               Access_Control_Request_Method="POST")
        self.assertEqual(code, 405)
        self.assertFalse([name for name in headers if name.lower().startswith("access-control")])

    def test_every_answer_forbids_what_the_page_does_not_need(self):
        for path, host in (("/", None), ("/nothing", None), ("/", "evil.example")):
            _, headers, _ = get(self.program, path, host=host)
            policy = dict(rule.strip().split(" ", 1) for rule in headers["Content-Security-Policy"].split(";"))
            self.assertEqual(policy["default-src"], "'none'")
            for rule in ("script-src", "style-src", "connect-src", "img-src"):
                self.assertEqual(policy[rule], "'self'")
            for rule in ("frame-ancestors", "base-uri", "form-action"):
                self.assertEqual(policy[rule], "'none'")
            self.assertEqual(headers["X-Content-Type-Options"], "nosniff")
            self.assertEqual(headers["Cross-Origin-Resource-Policy"], "same-origin")
            self.assertEqual(headers["Referrer-Policy"], "no-referrer")
            self.assertEqual(headers["Cache-Control"], "no-store")

    def test_the_page_has_nothing_inline_and_nothing_from_elsewhere(self):
        _, _, body = get(self.program)
        html = body.decode()
        self.assertNotRegex(html, r"<script(?![^>]*\bsrc=\"/[^/])")
        self.assertNotRegex(html, r"<style|\bstyle=|\bon\w+=|javascript:")
        for path in ("/", "/page.js", "/page.css"):
            text = get(self.program, path)[2].decode()
            urls = set(re.findall(r"(?:https?|wss?):?//[\w.]*", text)) - {"http://www.w3.org", "ws://"}
            self.assertEqual(urls, set(), path)

    def test_the_feed_is_for_our_own_page_only(self):
        stream, head = upgrade(self.program)
        self.assertEqual(status(head), 101)
        self.assertIn("Sec-WebSocket-Protocol: roadbalance\r\n", head)
        stream.close()
        for origin in ("", "null", "http://evil.example", f"https://127.0.0.1:{self.program.port}",
                       f"http://localhost:{self.program.port}"):
            stream, head = upgrade(self.program, origin=origin)
            self.assertEqual(status(head), 403, origin)
            stream.close()
        stream, head = upgrade(self.program, host="evil.example", origin="http://evil.example")
        self.assertEqual(status(head), 421)
        stream.close()
        stream, head = upgrade(self.program, path="/elsewhere")
        self.assertEqual(status(head), 404)
        stream.close()

    def test_a_change_of_state_needs_origin_token_and_its_type(self):
        right = {"Origin": own(self.program), "X_Roadbalance_Token": self.program.token, "Content_Type": "application/json"}
        body = request("origin-and-token")
        wrongs = [({"Origin": "http://evil.example"}, 403), ({"Origin": "null"}, 403),
                  ({"X_Roadbalance_Token": "0" * 32}, 401), ({"X_Roadbalance_Token": ""}, 401),
                  ({"X_Roadbalance_Token": self.program.token[:-1]}, 401),
                  # A page of somebody else's may send these without asking first.
                  ({"Content_Type": "text/plain"}, 415), ({"Content_Type": "application/x-www-form-urlencoded"}, 415)]
        with Ear() as ear:
            for wrong, code in wrongs:
                self.assertEqual(get(self.program, "/request", method="POST", body=body, **{**right, **wrong})[0], code, wrong)
            for missing, code in (("Origin", 403), ("X_Roadbalance_Token", 401), ("Content_Type", 415)):
                rest = {name: value for name, value in right.items() if name != missing}
                self.assertEqual(get(self.program, "/request", method="POST", body=body, **rest)[0], code, missing)
            self.assertEqual(get(self.program, "/request", method="POST", host="evil.example", body=body, **right)[0], 421)
            # This one is right: what came before it on the bus would be heard, too.
            last = request("the right one")
            self.assertEqual(get(self.program, "/request", method="POST", body=last, **right)[0], 202)
            self.assertIn(b"the right one", ear.next())
        self.assertEqual(get(self.program, "/", method="POST", body=b"{}", **right)[0], 405)
        self.assertEqual(get(self.program, "/elsewhere", method="POST", body=b"{}", **right)[0], 404)
        self.assertEqual(get(self.program, "/request")[0], 404)

    def post(self, body):
        return get(self.program, "/request", method="POST", body=body, Origin=own(self.program),
                   X_Roadbalance_Token=self.program.token, Content_Type="application/json")

    def test_a_request_that_is_none_is_refused_with_the_reason(self):
        good = {"asker": 1, "request": 2, "operation": "mark"}
        for body, reason in ((b"", b"no JSON object"), (b"[" * 16000, b""), (b"\xff\xfe{}", b"no JSON object"),
                             (json.dumps({**good, "file": "../../x"}).encode(), b"unknown key"),
                             (json.dumps({**good, "operation": "delete"}).encode(), b"operation is none of"),
                             (json.dumps({**good, "request": 2 ** 53}).encode(), b"request is too large"),
                             (json.dumps({**good, "text": "x" * 401}).encode(), b"at most 400 bytes"),
                             (json.dumps({**good, "text": "\x1b[2J"}).encode(), b"control characters")):
            code, headers, said = self.post(body)
            self.assertEqual(code, 400, body[:80])
            self.assertIn(reason, said)
            self.assertEqual(headers["Content-Type"], "text/plain; charset=utf-8")
        self.assertEqual(self.post(b'{"text": "' + b"x" * 20_000 + b'"}')[0], 413)

    def test_a_request_is_said_again_under_the_same_number_until_it_is_answered(self):
        with Ear() as ear:
            body = request("said again")
            for _ in range(3):
                self.assertEqual(self.post(body)[0], 202)
            heard = []
            while len(heard) < 4:
                if b"said again" in (datagram := ear.next()):
                    heard.append(datagram)
            # All the same: one number, so that it acts once.
            self.assertEqual(len({datagram[8:] for datagram in heard}), 1)

    def test_many_requests_at_once_are_bounded(self):
        codes = [self.post(request(f"many {k}"))[0] for k in range(200)]
        self.assertLessEqual(set(codes), {202, 503})
        self.assertEqual(get(self.program)[0], 200)

    def test_a_page_may_ask_for_a_view_without_a_token_but_only_our_own(self):
        for origin, code in ((own(self.program), 400), ("http://evil.example", 403), ("null", 403),
                             (f"http://localhost:{self.program.port}", 403)):
            # 400: admitted, but what it says is no view.
            for body in (b"", b"{}", bytes(700), os.urandom(16_000)):
                self.assertEqual(get(self.program, "/view", method="POST", body=body, Origin=origin)[0], code, origin)
        self.assertEqual(get(self.program, "/view", method="POST", body=b"")[0], 403)
        self.assertEqual(get(self.program, "/view", method="POST", body=bytes(20_000), Origin=own(self.program))[0], 413)
        self.assertEqual(get(self.program, "/view")[0], 404)

    def test_other_methods_are_refused(self):
        for method in ("PUT", "DELETE", "PATCH", "TRACE", "FROBNICATE"):
            self.assertEqual(get(self.program, method=method)[0], 405, method)

    def test_headers_are_bounded(self):
        self.assertEqual(get(self.program, X_Long="x" * 9000)[0], 431)
        with raw(self.program, b"GET /" + b"a" * 100_000) as stream:
            self.assertTrue(is_hung_up(stream))
        self.assertEqual(get(self.program)[0], 200)

    def test_bodies_are_bounded(self):
        host = f"Host: 127.0.0.1:{self.program.port}\r\nOrigin: {own(self.program)}\r\n"
        token = f"X-Roadbalance-Token: {self.program.token}\r\n"
        head = f"POST /request HTTP/1.1\r\n{host}{token}"
        with raw(self.program, f"{head}Content-Length: 100000000\r\n\r\n".encode()) as stream:
            self.assertEqual(status(read_head(stream)), 413)
        with raw(self.program, f"{head}Transfer-Encoding: chunked\r\n\r\n".encode()) as stream:
            with contextlib.suppress(ConnectionError):
                for _ in range(100):
                    stream.sendall(b"1000\r\n" + b"x" * 4096 + b"\r\n")
            self.assertIn(status(read_head(stream)), (413, None))

    def test_what_is_no_request_is_refused(self):
        for garbage in (b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03" + bytes(64), b"GET\r\n\r\n",
                        b"GET / HTTP/9.9\r\n\r\n", b"\r\n\r\n\x00\xff" * 100):
            with raw(self.program, garbage) as stream:
                with contextlib.suppress(OSError):  # it may have hung up already
                    stream.shutdown(socket.SHUT_WR)
                self.assertTrue(is_hung_up(stream))
        self.assertEqual(get(self.program)[0], 200)

    def test_the_page_may_say_nothing_on_the_feed(self):
        for payload in (frame(1, b"hello"), frame(2, b"x" * 60_000)):
            stream, _ = upgrade(self.program)
            stream.sendall(payload)
            self.assertTrue(is_hung_up(stream))
            stream.close()

    def test_who_never_ends_a_request_is_dropped(self):
        with raw(self.program, b"GET / HTTP/1.1\r\nHost: ") as stream:
            self.assertTrue(is_hung_up(stream))


class Crowd(unittest.TestCase):
    def test_connections_are_bounded_and_their_places_come_back(self):
        with rb_web() as program, contextlib.ExitStack() as stack:
            crowd = [stack.enter_context(raw(program)) for _ in range(100)]
            turned_away = []
            while len(turned_away) < 100 - 64:
                turned_away = select.select(crowd, [], [], PATIENCE_S)[0]
            self.assertEqual(len(turned_away), 100 - 64)
            for stream in crowd:
                stream.close()
            end = time.monotonic() + PATIENCE_S
            while time.monotonic() < end:
                with contextlib.suppress(OSError, http.client.HTTPException):
                    if get(program)[0] == 200:
                        return
            self.fail("nobody is served any more")

    def test_twenty_pages_get_every_frame_though_one_more_stalls(self):
        url = bus_url()
        with subprocess.Popen([PROGRAM.with_name("rb-web-scene"), url, "known"]) as car, rb_web() as program, \
                contextlib.ExitStack() as stack:
            stack.callback(car.terminate)
            pages = []
            for _ in range(21):
                stream, head = upgrade(program)
                stack.enter_context(stream)
                self.assertEqual(status(head), 101)
                pages.append(stream)
            # The first, with all there is, is the longest; no page waits for the last one, which reads nothing.
            for stream in pages[:-1]:
                for _ in range(30):
                    self.assertEqual(read_frame(stream)[:4], b"RBF1")
            self.assertEqual(get(program)[0], 200)


class Views(unittest.TestCase):
    """What pages want to see."""

    def test_go_to_the_bus_as_they_are(self):
        address, port = re.match(r"udpm://([\d.]+):(\d+)", bus_url()).groups()
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as bus, rb_web() as program:
            bus.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            bus.bind((address, int(port)))
            bus.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, socket.inet_aton(address) + bytes(4))
            bus.settimeout(PATIENCE_S)
            wanted = view(2**52 - 7)
            self.assertEqual(get(program, "/view", method="POST", body=wanted, Origin=own(program))[0], 200)
            datagram = b""
            while not datagram[8:].startswith(b"RB_VIEW\0"):  # LCM tests the way to itself first
                datagram = bus.recv(65536)
            self.assertEqual((datagram[:4], datagram[8:]), (b"LC02", b"RB_VIEW\0" + wanted))

    def test_of_nobody_or_beyond_bounds_are_refused(self):
        with rb_web() as program:
            for wrong in (view(0), view(1, segment=512), view(1, segment=2**20), view(1, pairs=17), view(1) + b"\0", view(1)[:-1]):
                self.assertEqual(get(program, "/view", method="POST", body=wrong, Origin=own(program))[0], 400)

    def test_are_of_so_many_pages_at_the_most(self):
        with rb_web() as program:
            codes = [get(program, "/view", method="POST", body=view(viewer), Origin=own(program))[0] for viewer in range(1, 41)]
            self.assertEqual(codes, 32 * [200] + 8 * [503])
            # Its page shows this above the plots.
            refused = get(program, "/view", method="POST", body=view(33), Origin=own(program))[2]
            self.assertEqual(refused, b"Too many pages show plots: close one of them.\n")
            self.assertEqual(get(program, "/view", method="POST", body=view(1), Origin=own(program))[0], 200)


class Elsewhere(unittest.TestCase):
    """On an address that others reach."""

    def test_needs_a_token(self):
        done = subprocess.run([PROGRAM, "--url", bus_url(), "--port", "0", "--listen", "0.0.0.0"], capture_output=True,
                              text=True, check=False, timeout=PATIENCE_S)
        self.assertEqual((done.returncode, done.stdout), (2, ""))
        self.assertIn("--token-file", done.stderr)

    def test_a_token_that_is_short_or_that_no_browser_can_send_is_none(self):
        for token, fault in (("short", "shorter than 16"), ("c3RhcGxl/battery+horse==", "a browser cannot send")):
            with tempfile.NamedTemporaryFile("w") as file:
                file.write(token + "\n")
                file.flush()
                done = subprocess.run([PROGRAM, "--url", bus_url(), "--port", "0", "--token-file", file.name],
                                      capture_output=True, text=True, check=False, timeout=PATIENCE_S)
                self.assertIn(file.name, done.stderr)
            self.assertEqual(done.returncode, 2)
            self.assertIn(fault, done.stderr)

    def test_watching_needs_the_token_and_the_program_does_not_repeat_it(self):
        secret = "correct-horse-battery"
        with tempfile.NamedTemporaryFile("w") as file:
            file.write(secret + "\n")
            file.flush()
            with rb_web("--listen", "0.0.0.0", "--token-file", file.name, "--host", "car.lan") as program:
                self.assertEqual(program.token, "...")
                for protocols, code in (("roadbalance", 401), ("roadbalance, token.wrong-horse-battery", 401),
                                        (f"roadbalance, token.{secret}", 101)):
                    stream, head = upgrade(program, protocols=protocols)
                    self.assertEqual(status(head), code, protocols)
                    stream.close()
                for token, code in ((None, 401), ("wrong-horse-battery", 401), (secret, 400)):
                    headers = {"X_Roadbalance_Token": token} if token else {}
                    self.assertEqual(get(program, "/view", method="POST", body=b"", Origin=own(program), **headers)[0], code)
                self.assertEqual(get(program, host=f"car.lan:{program.port}")[0], 200)
                for host in ("localhost", "0.0.0.0", "other.lan"):
                    self.assertEqual(get(program, host=f"{host}:{program.port}")[0], 421, host)


class Port(unittest.TestCase):
    def test_a_port_in_use_is_named(self):
        with socket.socket() as taken:
            taken.bind(("127.0.0.1", 0))
            taken.listen()
            port = taken.getsockname()[1]
            done = subprocess.run([PROGRAM, "--url", bus_url(), "--port", str(port)], capture_output=True, text=True,
                                  check=False, timeout=PATIENCE_S)
        self.assertEqual(done.returncode, 4)
        self.assertIn(f"127.0.0.1 port {port}", done.stderr)


class Sources(unittest.TestCase):
    def test_packages_are_exact_and_name_no_registry(self):
        page = pathlib.Path(os.environ["RB_SOURCE"], "host/web/page")
        self.assertNotRegex((page / "package-lock.json").read_text(encoding="utf-8"), r"://|\"resolved\"")
        wanted = json.loads((page / "package.json").read_text(encoding="utf-8"))
        for version in (*wanted["dependencies"].values(), *wanted["devDependencies"].values()):
            self.assertRegex(version, r"^\d+\.\d+\.\d+$")


class Unit(unittest.TestCase):
    def test_asks_systemd_for_a_sandbox_and_hears_nodes_of_private_networks(self):
        lines = pathlib.Path(os.environ["RB_SOURCE"], "host/web/rb-web.service").read_text(encoding="ascii").splitlines()
        for needed in ("DynamicUser=yes", "CapabilityBoundingSet=", "NoNewPrivileges=yes", "ProtectSystem=strict",
                       "ProtectHome=yes", "PrivateDevices=yes", "RestrictAddressFamilies=AF_INET AF_INET6",
                       "MemoryDenyWriteExecute=yes", "SystemCallFilter=@system-service", "IPAddressDeny=any",
                       "IPAddressAllow=localhost link-local multicast 10.0.0.0/8 172.16.0.0/12 192.168.0.0/16"):
            self.assertIn(needed, lines)
        self.assertIn("ExecStart=rb-web", lines)

    UNITS = [path for folder in ("host", "firmware")
             for path in pathlib.Path(os.environ["RB_SOURCE"], folder).rglob("*.service")]

    def test_every_unit_may_do_only_what_its_program_needs(self):
        self.assertGreaterEqual(len(self.UNITS), 5)
        for unit in self.UNITS:
            lines = unit.read_text(encoding="ascii").splitlines()
            for needed in ("NoNewPrivileges=yes", "ProtectSystem=strict", "ProtectHome=yes", "PrivateTmp=yes",
                           "ProtectControlGroups=yes", "ProtectKernelModules=yes", "RestrictNamespaces=yes",
                           "ProtectKernelTunables=yes", "ProtectClock=yes", "MemoryDenyWriteExecute=yes",
                           "RestrictSUIDSGID=yes", "LockPersonality=yes", "SystemCallArchitectures=native",
                           "SystemCallFilter=@system-service", "IPAddressDeny=any"):
                self.assertIn(needed, lines, unit.name)
            for setting in ("CapabilityBoundingSet=", "RestrictAddressFamilies="):
                self.assertTrue(any(line.startswith(setting) for line in lines), f"{unit.name}: {setting}")

    def test_systemd_finds_little_that_a_unit_could_do_without(self):
        for unit in self.UNITS:
            done = subprocess.run(["systemd-analyze", "security", "--no-pager", "--offline=true", "--threshold=30", unit],
                                  capture_output=True, text=True, check=False)
            self.assertEqual(done.returncode, 0, f"{unit.name}: {done.stdout[-200:]}{done.stderr}")

    def test_what_samples_may_have_the_priority_that_it_asks_for(self):
        priorities = pathlib.Path(os.environ["RB_SOURCE"], "common/process/realtime.hpp").read_text(encoding="utf-8")
        highest = max(int(number) for number in re.findall(r"k(?:Acquire|Device)Priority = (\d+);", priorities))
        lines = pathlib.Path(os.environ["RB_SOURCE"], "firmware/rb-node@.service").read_text(encoding="ascii").splitlines()
        limit = next(int(line.removeprefix("LimitRTPRIO=")) for line in lines if line.startswith("LimitRTPRIO="))
        self.assertGreaterEqual(limit, highest)
        self.assertIn("LimitMEMLOCK=infinity", lines)
        self.assertNotIn("RestrictRealtime=yes", lines)

    def test_every_unit_starts_its_program_as_that_wants_and_again_for_ever_but_after_a_wrong_command_line(self):
        for unit in self.UNITS:
            lines = unit.read_text(encoding="ascii").splitlines()
            command = next(line for line in lines if line.startswith("ExecStart="))
            program, *options = command.removeprefix("ExecStart=").split()
            told = subprocess.run([BIN / pathlib.Path(program).name, "--help"], capture_output=True, text=True, check=True)
            for option in options:
                if option.startswith("--"):
                    self.assertRegex(told.stdout, rf"(?m)^ +(-\w,)?{option}\b", unit.name)
            for needed in ("Restart=always", "RestartPreventExitStatus=2", "StartLimitIntervalSec=0",
                           "EnvironmentFile=-/etc/environment"):
                self.assertIn(needed, lines, unit.name)

    def test_a_node_has_the_devices_of_its_vehicle_unless_it_is_told_others(self):
        lines = pathlib.Path(os.environ["RB_SOURCE"], "firmware/rb-node@.service").read_text(encoding="ascii").splitlines()
        command = next(line for line in lines if line.startswith("ExecStart="))
        self.assertNotIn("--front-end", command)
        # Unquoted and a word of its own: as many arguments as it has words, and none if it is not set.
        self.assertEqual(command.split()[-1], "$RB_NODE_OPTIONS")
        self.assertIn("EnvironmentFile=-/etc/roadbalance/node-%i.conf", lines)

    def test_what_is_done_with_recordings_gives_way_to_recording(self):
        lines = pathlib.Path(os.environ["RB_SOURCE"], "host/recordings/rb-recordings.service").read_text(encoding="ascii").splitlines()
        for needed in ("Nice=19", "IOSchedulingClass=idle", "MemoryHigh=1G", "DynamicUser=yes", "CapabilityBoundingSet=",
                       "SystemCallFilter=@system-service", "IPAddressDeny=any",
                       "ExecStart=rb-recordings --folder /var/lib/roadbalance/recordings --results /var/lib/roadbalance-results",
                       "StateDirectory=roadbalance-results"):
            self.assertIn(needed, lines)
        recorder = pathlib.Path(os.environ["RB_SOURCE"], "host/recorder/rb-recorder.service").read_text(encoding="ascii")
        self.assertIn("--recordings /var/lib/roadbalance/recordings ", recorder, "the folder that the recorder writes")

    def test_systemd_knows_every_line(self):
        with tempfile.TemporaryDirectory() as folder:
            for unit in self.UNITS:
                here = pathlib.Path(folder, unit.name.replace("@", "@front"))
                here.write_text(unit.read_text(encoding="ascii").replace("ExecStart=", f"ExecStart={BIN}/"), encoding="ascii")
                said = subprocess.run(["systemd-analyze", "verify", "--man=no", "--recursive-errors=no", here],
                                      capture_output=True, text=True, check=False)
                self.assertEqual((said.returncode, said.stderr), (0, ""), unit.name)


if __name__ == "__main__":
    unittest.main()
