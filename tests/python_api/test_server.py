"""The local server: what it refuses and by which name, that it goes on answering, and when it ends."""

import contextlib
import http.client
import json
import queue
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import parse_qs, urlsplit

import pytest
from standfast.cli import main
from standfast.server import LIMITS, Limits, serve

PAGE = "<!doctype html><title>μ</title>"
#: Short, so that the tests are.
SHORT = Limits(request=0.4, beat=0.05, grace=0.2, unopened=20.0)


def answer(text: str) -> str:
    if text == "fail":
        raise ValueError("no such\nscene")
    if text == "panic":
        raise BaseException("broken invariant")
    if text == "surrogate":
        return "\ud800"
    return f'{{"asked": {text}}}'


class Running:
    """A server in a thread."""

    def __init__(self, limits: Limits = SHORT, answer=answer, **options):
        opened: queue.Queue[str] = queue.Queue()
        self.failure: BaseException | None = None

        def run():
            try:
                serve(PAGE, answer, opened=opened.put, limits=limits, **options)
            except BaseException as error:
                self.failure = error

        self.threads = set(threading.enumerate())
        self.thread = threading.Thread(target=run)
        self.thread.start()
        self.url = opened.get(timeout=5)
        address = urlsplit(self.url)
        self.port = address.port
        (self.token,) = parse_qs(address.query)["token"]
        self.host = f"127.0.0.1:{self.port}"

    def connect(self) -> socket.socket:
        return socket.create_connection(("127.0.0.1", self.port), timeout=5)

    def request(self, line="GET /?token={token}", body=b"", **headers) -> bytes:
        """A good request of the page, or one that differs in the headers given; None leaves one out."""
        if line.startswith("POST"):
            headers = {
                "X_Standfast_Token": self.token,
                "Content_Length": len(body),
            } | headers
        headers = {"Host": self.host} | headers
        lines = [f"{line.format(token=self.token)} HTTP/1.1"]
        for name, value in headers.items():
            if value is not None:
                lines.append(f"{name.replace('_', '-')}: {value}")
        return "\r\n".join([*lines, "", ""]).encode("latin-1") + body

    def send(self, data: bytes, end: bool = False) -> tuple[int, str, str]:
        """Status, headers and body of the reply to raw bytes, after which the connection is closed."""
        with self.connect() as client:
            # The server may refuse the request before it has been sent as a whole.
            with contextlib.suppress(ConnectionError):
                client.sendall(data)
                if end:
                    client.shutdown(socket.SHUT_WR)
            return reply(client)

    def ask(self, text: str, **headers) -> tuple[int, str, str]:
        return self.send(self.request("POST /ask", text.encode(), **headers))

    def answers(self) -> bool:
        """Whether the server does what it is there for."""
        page = self.send(self.request())
        asked = self.ask("[1]")
        return (page[0], page[2], asked[0], asked[2]) == (
            *(200, PAGE),
            *(200, '{"asked": [1]}'),
        )

    def alive(self) -> socket.socket:
        """A page that is open."""
        client = self.connect()
        client.sendall(self.request("GET /alive?token={token}"))
        head = b""
        while b"\r\n\r\n:\n\n" not in head:
            part = client.recv(4096)
            assert part, head
            head += part
        assert head.startswith(b"HTTP/1.1 200 ")
        return client

    def ended(self, within: float = 5.0) -> bool:
        self.thread.join(within)
        return not self.thread.is_alive()


def received(client: socket.socket) -> bytes:
    """All that comes until the server closes the connection."""
    parts = []
    with contextlib.suppress(ConnectionError):
        while part := client.recv(65536):
            parts.append(part)
    return b"".join(parts)


def reply(client: socket.socket) -> tuple[int, str, str]:
    head, _, body = received(client).partition(b"\r\n\r\n")
    status = head.split()[1] if head else b"0"
    return int(status), head.decode(), body.decode()


@pytest.fixture(scope="module")
def shared() -> Iterator[Running]:
    server = Running()
    yield server
    server.alive().close()
    assert server.ended()
    assert server.failure is None


@pytest.fixture
def server(shared: Running, capfd) -> Iterator[Running]:
    """The server of most tests. After each of them it answers, and it has written nothing."""
    yield shared
    assert shared.answers()
    assert capfd.readouterr() == ("", "")


def test_the_page_is_shown_with_headers_that_keep_it_to_itself(server):
    status, head, body = server.send(server.request())
    assert (status, body) == (200, PAGE)
    for line in [
        "Content-Type: text/html; charset=utf-8",
        f"Content-Length: {len(PAGE.encode())}",
        "Cache-Control: no-store",
        "Referrer-Policy: no-referrer",
        "X-Content-Type-Options: nosniff",
        "X-Frame-Options: DENY",
    ]:
        assert line in head.split("\r\n")
    (policy,) = (x for x in head.split("\r\n") if x.startswith("Content-Security-"))
    for directive in [
        "default-src 'none'",
        "script-src 'unsafe-inline'",
        "style-src 'unsafe-inline'",
        "img-src blob: data:",
        "worker-src blob:",
        "connect-src 'self'",
    ]:
        assert directive in policy.partition(": ")[2].split("; ")


def test_a_client_of_http_gets_answers_under_both_names(server):
    for host in ["127.0.0.1", "localhost"]:
        client = http.client.HTTPConnection("127.0.0.1", server.port, timeout=5)
        origin = f"http://{host}:{server.port}"
        client.request(
            *("POST", "/ask", '"ψ"'.encode()),
            {
                "Host": f"{host}:{server.port}",
                "Origin": origin,
                "Sec-Fetch-Site": "same-origin",
                "X-Standfast-Token": server.token,
            },
        )
        got = client.getresponse()
        assert (got.status, got.getheader("Content-Type")) == (200, "application/json")
        assert got.read().decode() == '{"asked": "ψ"}'
        client.close()


def test_the_token_is_new_each_time_and_long(server):
    other = Running()
    assert other.token != server.token
    assert min(len(other.token), len(server.token)) == 43  # 32 bytes
    other.alive().close()
    assert other.ended()


# What differs from a good request, the status, and the start of the reason. HOST, PORT and TOKEN stand for those of the server.
REFUSED_HEADERS = {
    "Host of another site": ({"Host": "evil.example"}, 403, "Host is 'evil.example'"),
    "Host with another port": ({"Host": "127.0.0.1:1"}, 403, "Host is '127.0.0.1:1'"),
    "Host without port": ({"Host": "127.0.0.1"}, 403, "Host is '127.0.0.1'"),
    "Host of all interfaces": ({"Host": "0.0.0.0:PORT"}, 403, "Host is '0.0.0.0:"),
    "Host that goes on": ({"Host": "HOST.evil"}, 403, "Host is '127.0.0.1:"),
    "no Host": ({"Host": None}, 403, "Host is ''"),
    "Origin of another site": (
        {"Origin": "http://evil.example"},
        *(403, "Origin is 'http://evil.example'"),
    ),
    "Origin null": ({"Origin": "null"}, 403, "Origin is 'null'"),
    "Origin with another scheme": ({"Origin": "https://HOST"}, 403, "Origin is 'https"),
    "Origin with the other name": (
        {"Origin": "http://localhost:PORT"},
        *(403, "Origin is 'http://localhost"),
    ),
    "another site asks": (
        {"Sec_Fetch_Site": "cross-site"},
        *(403, "Sec-Fetch-Site is 'cross-site'"),
    ),
    "another port asks": (
        {"Sec_Fetch_Site": "same-site"},
        *(403, "Sec-Fetch-Site is 'same-site'"),
    ),
}
REFUSED_QUESTIONS = {
    "no token": (
        {"X_Standfast_Token": None},
        *(403, "X-Standfast-Token is missing"),
    ),
    "empty token": ({"X_Standfast_Token": ""}, 403, "X-Standfast-Token is not that"),
    "wrong token": (
        {"X_Standfast_Token": "A" * 43},
        *(403, "X-Standfast-Token is not that of this server"),
    ),
    "token with more": (
        {"X_Standfast_Token": "TOKENx"},
        *(403, "X-Standfast-Token is not that"),
    ),
    "token beyond ASCII": (
        {"X_Standfast_Token": "é" * 43},
        *(403, "X-Standfast-Token is not that"),
    ),
    "no length": ({"Content_Length": None}, 411, "Content-Length is missing"),
    "negative length": ({"Content_Length": -1}, 400, "Content-Length is '-1'"),
    "length in words": ({"Content_Length": "two"}, 400, "Content-Length is 'two'"),
    "length with sign": ({"Content_Length": "+2"}, 400, "Content-Length is '+2'"),
    "length of 5000 digits": ({"Content_Length": "9" * 5000}, 400, "Content-Length is"),
    "one byte too many": (
        {"Content_Length": LIMITS.body + 1},
        *(413, "Content-Length is 1048577; at most 1048576 is taken"),
    ),
    "chunks": (
        {"Transfer_Encoding": "chunked", "Content_Length": None},
        *(501, "Transfer-Encoding is not taken"),
    ),
    "chunks and length": ({"Transfer_Encoding": "chunked"}, 501, "Transfer-Encoding"),
}


def filled(server: Running, headers: dict) -> dict:
    """With the port and the token of this server."""
    for name, text in [
        ("HOST", server.host),
        ("PORT", str(server.port)),
        ("TOKEN", server.token),
    ]:
        headers = {
            key: value.replace(name, text) if isinstance(value, str) else value
            for key, value in headers.items()
        }
    return headers


def refused(got: tuple[int, str, str], status: int, reason: str) -> None:
    """The reply is one line of plain text that names the reason."""
    assert got[0] == status, got
    assert "Content-Type: text/plain" in got[1].split("\r\n")
    assert got[2].startswith(reason)
    assert got[2].endswith("\n")
    assert got[2].count("\n") == 1


@pytest.mark.parametrize("line", ["GET /?token={token}", "POST /ask", "GET /alive"])
@pytest.mark.parametrize("case", REFUSED_HEADERS)
def test_another_site_is_refused(server, case, line):
    headers, status, reason = REFUSED_HEADERS[case]
    got = server.send(server.request(line, **filled(server, headers)))
    refused(got, status, reason)


@pytest.mark.parametrize("case", REFUSED_QUESTIONS)
def test_a_question_that_cannot_be_taken_is_refused(server, case):
    headers, status, reason = REFUSED_QUESTIONS[case]
    refused(server.ask("{}", **filled(server, headers)), status, reason)


@pytest.mark.parametrize("path", ["/", "/alive"])
@pytest.mark.parametrize(
    ("query", "reason"),
    [
        ("", "token= is missing"),
        ("?token=", "token= is missing"),
        ("?token=" + "A" * 43, "token= is not that of this server"),
        ("?token=%C3%A9", "token= is not that of this server"),
        ("?Token={token}", "token= is missing"),
        ("?token={token}x", "token= is not that of this server"),
        ("?token=x&token={token}", "token= is not that of this server"),
    ],
)
def test_a_page_without_the_token_is_refused(server, path, query, reason):
    refused(server.send(server.request(f"GET {path}{query}")), 403, reason)


@pytest.mark.parametrize(
    "path",
    [
        "/../../../../etc/passwd",
        "/..%2f..%2fetc/passwd",
        "/%2e%2e/etc/passwd",
        "/..\\..\\windows",
        "//etc/passwd",
        "/./",
        "/ask/../",
        "/ask/",
        "/%61sk",
        "/favicon.ico",
        "/index.html",
        "http://127.0.0.1/",
        "*",
    ],
)
def test_there_are_no_other_paths(server, path):
    got = server.send(server.request(f"GET {path}?token={{token}}"))
    refused(got, 404, f"there is no {path}")


@pytest.mark.parametrize(
    ("line", "allowed"),
    [
        *((f"{x} /?token={{token}}", "GET") for x in ["HEAD", "PUT", "OPTIONS"]),
        *((f"{x} /?token={{token}}", "GET") for x in ["POST", "DELETE", "TRACE"]),
        *((f"{x} /ask", "POST") for x in ["GET", "HEAD", "PUT", "OPTIONS"]),
        ("POST /alive?token={token}", "GET"),
    ],
)
def test_other_methods_are_refused(server, line, allowed):
    got = server.send(server.request(line))
    method, path = line.partition("?")[0].split()
    refused(got, 405, f"{path} is for {allowed}, not {method}")
    assert f"Allow: {allowed}" in got[1].split("\r\n")


@pytest.mark.parametrize(
    "line",
    [
        b"",
        b"GET",
        b"GET /",
        b"GET / HTTP/2.0",
        b"GET / HTTP/1.1 ",
        b"GET  / HTTP/1.1",
        b"get / HTTP/1.1",
        b" GET / HTTP/1.1",
        b"GET /\x00 HTTP/1.1",
        b"GET /\n HTTP/1.1",
        b"GET /\xff HTTP/1.1",
        b"\x16\x03\x01\x02\x00\x01\x00",
        bytes(range(14, 256)),
    ],
)
def test_garbage_is_not_a_request(server, line):
    got = server.send(line + b"\r\n\r\n")
    refused(got, 400, ascii(line.decode("latin-1")[:80]) + " is not a request line")


@pytest.mark.parametrize(
    "line",
    [
        b"no colon",
        b": no name",
        b"space : before the colon",
        b" continued: line",
        b"line: feed\nHost: evil.example",
        b"null: \x00",
        b"carriage: \rreturn",
        b"n\xe4me: x",
    ],
)
def test_garbage_is_not_a_header(server, line):
    request = server.request().replace(b"\r\n\r\n", b"\r\n" + line + b"\r\n\r\n")
    reason = ascii(line.decode("latin-1")) + " is not a header"
    refused(server.send(request), 400, reason)


@pytest.mark.parametrize("name", [b"Host", b"hOST", b"X-Other"])
def test_a_header_that_is_there_twice_is_refused(server, name):
    twice = b"\r\nX-Other: 1\r\n" + name + b": 2\r\n\r\n"
    got = server.send(server.request().replace(b"\r\n\r\n", twice))
    refused(got, 400, f"the header {name.decode()} is there twice")


@pytest.mark.parametrize(
    "data",
    [
        b"GET /" + b"a" * 100_000,
        b"GET / HTTP/1.1\r\nHost: " + b"a" * 100_000,
        b"GET / HTTP/1.1\r\n" + b"".join(b"X-%d: y\r\n" % k for k in range(10_000)),
        b"GET / HTTP/1.1\r\nX: " + b"a" * (LIMITS.head + 1) + b"\r\n\r\n",
    ],
    ids=["line", "header", "headers", "complete"],
)
def test_a_head_without_end_is_refused(server, data):
    refused(server.send(data), 431, "request line and headers exceed 16384 bytes")


def test_a_large_head_is_taken_up_to_its_limit(server):
    request = server.request(X_Other="")
    padding = b"a" * (LIMITS.head - len(request))
    request = request.replace(b"X-Other: ", b"X-Other: " + padding)
    assert server.send(request)[0] == 200


@pytest.mark.parametrize(
    "data",
    [b"GET / HT", b"GET / HTTP/1.1\r\nHost: x\r\n", b"", "POST"],
    ids=["line", "headers", "nothing", "body"],
)
def test_a_request_that_ends_early_is_refused(server, data):
    if data == "POST":
        data = server.request("POST /ask", b"{}", Content_Length=3)
    refused(server.send(data, end=True), 400, "the request is not complete")


def test_a_body_is_taken_up_to_its_limit_and_none_beyond_is_read(server):
    text = " " * (LIMITS.body - 2) + "[]"
    assert server.ask(text)[2] == f'{{"asked": {text}}}'
    announced = server.request("POST /ask", Content_Length=100_000_000)
    refused(server.send(announced), 413, "Content-Length is 100000000; at most")
    with server.connect() as client:
        client.sendall(announced)
        sent = 0
        with contextlib.suppress(ConnectionError):
            while sent < 100_000_000:
                sent += client.send(b" " * 65536)
        assert sent < 20_000_000  # what the buffers of two sockets hold
        refused(reply(client), 413, "Content-Length is 100000000; at most")


@pytest.mark.parametrize("part", ["line", "headers", "body"])
def test_a_request_that_comes_byte_by_byte_is_ended(server, part):
    request = {
        "line": b"GET /" + b"a" * 1000,
        "headers": b"GET / HTTP/1.1\r\nX: " + b"a" * 1000,
        "body": server.request("POST /ask", Content_Length=1000) + b"a" * 999,
    }[part]
    start = time.monotonic()
    with server.connect() as client:
        client.sendall(request[:-990])
        client.settimeout(0.02)
        for k in range(len(request) - 990, len(request)):
            with contextlib.suppress(TimeoutError, ConnectionError):
                client.send(request[k : k + 1])
                if client.recv(1, socket.MSG_PEEK):
                    break
        refused(reply(client), 408, "the request is not complete after 0.4 s")
    assert 0.35 < time.monotonic() - start < 2.0


def test_a_connection_that_says_nothing_is_ended(server):
    with server.connect() as client:
        refused(reply(client), 408, "the request is not complete after 0.4 s")


def test_a_thousand_connections_are_too_many(server):
    resource = pytest.importorskip("resource")
    files, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (min(hard, 4096), hard))
    try:
        before = threading.active_count()
        with contextlib.ExitStack() as stack:
            clients = [stack.enter_context(server.connect()) for _ in range(1000)]
            assert threading.active_count() == before
            got = [reply(client) for client in clients]
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, (files, hard))
    full = [reply for reply in got if reply[0] == 503]
    # Connections that say nothing make room for others after 0.4 s.
    late = [reply for reply in got if reply[0] == 408]
    assert len(full) + len(late) == 1000
    assert len(full) > 500
    assert len(late) >= LIMITS.connections
    for got in full:
        refused(got, 503, "more than 32 connections at a time")


def test_a_page_that_is_open_counts_as_a_connection():
    server = Running()
    with contextlib.ExitStack() as stack:
        for _ in range(LIMITS.connections):
            stack.enter_context(server.alive())
        refused(server.send(server.request()), 503, "more than 32 connections")
    assert server.ended()


def test_a_reply_that_is_not_taken_is_given_up():
    text = " " * 20_000_000
    server = Running(answer=lambda _: text)
    with contextlib.ExitStack() as stack:
        for _ in range(LIMITS.connections):
            client = stack.enter_context(server.connect())
            client.sendall(server.request("POST /ask", b"{}"))
        until = time.monotonic() + 5
        while server.send(server.request())[0] == 503:
            assert time.monotonic() < until
    server.alive().close()
    assert server.ended()


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("fail", "no answer: ValueError: no such scene"),
        ("panic", "no answer: BaseException: broken invariant"),
        ("surrogate", "no answer: UnicodeEncodeError: "),
    ],
)
def test_an_answer_that_fails_is_told(server, text, reason):
    refused(server.ask(text), 500, reason)


def test_a_question_that_is_not_text_is_refused(server):
    got = server.send(server.request("POST /ask", b"\xff"))
    refused(got, 400, "the body is not UTF-8")


def test_the_page_is_shown_while_an_answer_is_computed():
    asked, go = threading.Event(), threading.Event()

    def slow(text: str) -> str:
        asked.set()
        assert go.wait(5)
        return text

    server = Running(answer=slow)
    with server.connect() as client:
        client.sendall(server.request("POST /ask", b"1"))
        assert asked.wait(5)
        assert server.send(server.request())[2] == PAGE
        go.set()
        assert reply(client)[2] == "1"
    server.alive().close()
    assert server.ended()


def closed(server: Running) -> bool:
    """Whether the threads of the server have ended, and its port is free."""
    assert set(threading.enumerate()) <= server.threads
    with socket.socket() as again:
        # Connections that have ended hold the port for a minute otherwise.
        again.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        again.bind(("127.0.0.1", server.port))
        again.listen()
    with pytest.raises(ConnectionRefusedError):
        server.connect()
    return True


def test_the_server_ends_after_its_last_page():
    server = Running()
    first, second = server.alive(), server.alive()
    first.close()
    assert not server.ended(within=2 * SHORT.grace)
    assert server.answers()
    start = time.monotonic()
    second.close()
    assert server.ended()
    assert time.monotonic() - start > 0.9 * SHORT.grace
    assert server.failure is None
    assert closed(server)


def test_a_page_may_be_loaded_again():
    server = Running()
    server.alive().close()
    page = server.alive()
    assert not server.ended(within=2 * SHORT.grace)
    # It has heard from the server all the time.
    assert page.recv(4096).count(b":\n\n") >= 3
    page.close()
    assert server.ended()
    assert closed(server)


def test_connections_end_with_the_server():
    server = Running(Limits(grace=0.1))
    silent, page = server.connect(), server.alive()
    page.close()
    assert server.ended()
    assert received(silent) == b""
    silent.close()
    assert closed(server)


def test_an_answer_is_waited_for_at_the_end():
    asked, answered = threading.Event(), threading.Event()

    def slow(text: str) -> str:
        asked.set()
        time.sleep(3 * SHORT.grace)
        answered.set()
        return text

    server = Running(answer=slow)
    with server.connect() as client:
        client.sendall(server.request("POST /ask", b"1"))
        assert asked.wait(5)
        server.alive().close()
        assert server.ended()
    assert answered.is_set()
    assert closed(server)


def test_a_page_that_never_comes_is_not_waited_for():
    start = time.monotonic()
    server = Running(Limits(unopened=0.3))
    assert server.answers()
    assert server.ended()
    assert 0.25 < time.monotonic() - start < 3.0
    assert closed(server)


def test_a_browser_that_cannot_be_opened_ends_the_server():
    def opened(url: str) -> None:
        raise OSError(f"no browser for {url.partition('?')[0]}")

    with pytest.raises(OSError, match=r"no browser for http://127\.0\.0\.1:"):
        serve(PAGE, answer, opened=opened, limits=SHORT)


def test_a_browser_that_is_left_later_is_no_failure(capfd):
    left, threads = threading.Event(), []

    def opened(url: str) -> None:
        threads.append(threading.current_thread())
        left.wait(5)

    serve(PAGE, answer, opened=opened, limits=Limits(unopened=0.1))
    left.set()
    threads[0].join(5)
    assert capfd.readouterr() == ("", "")


def test_a_port_in_use_is_named():
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        port = other.getsockname()[1]
        with pytest.raises(OSError, match=f"127.0.0.1.*{port}.*in use"):
            serve(PAGE, answer, port=port, opened=print, limits=SHORT)


def test_only_this_machine_is_served(server):
    with pytest.raises(ConnectionRefusedError):
        socket.create_connection(("127.0.0.2", server.port), timeout=5)


INTERRUPTED = """
import time
from standfast.server import serve

def opened(url):
    print(url, flush=True)
    time.sleep(60)

def answer(text):
    print("asked", flush=True)
    time.sleep(60)

try:
    serve("", answer, opened=opened)
except KeyboardInterrupt:
    print("interrupted", flush=True)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="has no signal for one process")
def test_ctrl_c_ends_the_server_at_once():
    with subprocess.Popen(
        [sys.executable, "-c", INTERRUPTED],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        url = urlsplit(process.stdout.readline())
        token = parse_qs(url.query)["token"][0].strip()
        client = http.client.HTTPConnection(url.hostname, url.port, timeout=5)
        headers = {"X-Standfast-Token": token}
        client.request("POST", "/ask", "{}", headers)
        assert process.stdout.readline() == "asked\n"
        start = time.monotonic()
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=5)
        assert (out, err, process.returncode) == ("interrupted\n", "", 0)
        assert time.monotonic() - start < 2.0
        client.close()


@pytest.mark.skipif(sys.platform == "win32", reason="has no signal for one process")
def test_the_command_shows_a_scene_until_ctrl_c():
    scene = Path(__file__).parents[2] / "examples" / "stairs.toml"
    with subprocess.Popen(
        [sys.executable, "-m", "standfast", "explore", str(scene), "--no-browser"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        url = urlsplit(process.stdout.readline().strip())
        assert "Ctrl-C" in process.stdout.readline()
        client = http.client.HTTPConnection(url.hostname, url.port, timeout=5)
        client.request("GET", f"/?{url.query}")
        page = client.getresponse().read().decode()
        # The scene as it is in the file.
        assert json.dumps(scene.read_text(encoding="utf-8"))[1:-1] in page
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=10)
        assert (out, err, process.returncode) == ("", "", 0)
        client.close()


def test_a_scene_that_is_wrong_opens_no_page(tmp_path, capsys):
    (tmp_path / "wrong.toml").write_text("gravity = -1", encoding="utf-8")
    assert main(["explore", str(tmp_path / "wrong.toml")]) == 2
    assert "wrong.toml" in capsys.readouterr().err
    assert main(["explore", "--port", "65536"]) == 2
    assert "--port 65536: at most 65535" in capsys.readouterr().err
