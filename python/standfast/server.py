"""A page shown in the browser, and the answers to what it asks: an HTTP server for this machine and this page alone.

| request                                | reply                                                                |
| -------------------------------------- | -------------------------------------------------------------------- |
| `GET /?token=…`                        | the page                                                             |
| `POST /ask` with `X-Standfast-Token`   | what `answer` says to the body                                       |
| `GET /alive?token=…`                   | a stream without end; the page holds it open for as long as it lives |

All else is refused, with a line that names the reason. Nothing on disk can be reached. Another site that is open in the same
browser fails by the header Host (its name points to this machine), by Origin or Sec-Fetch-Site (its scripts ask), and by the token.
Each connection carries one request and ends.
"""

import asyncio
import re
import secrets
import webbrowser
from collections.abc import AsyncIterator, Callable
from concurrent.futures import Future
from contextlib import asynccontextmanager, suppress
from dataclasses import dataclass
from hmac import compare_digest
from http import HTTPStatus
from threading import Thread
from typing import TypeVar
from urllib.parse import parse_qs

Value = TypeVar("Value")
Result = TypeVar("Result")


@dataclass(frozen=True)
class Limits:
    """What the server puts up with. Times are in s, sizes in bytes."""

    #: Time for a request to arrive as a whole, and for a reply to be taken.
    request: float = 10.0
    #: From one line of an `alive` stream to the next.
    beat: float = 3.0
    #: From the end of the last page to the end of the server. A page that is loaded again is back sooner.
    grace: float = 5.0
    #: From the start to the end of a server whose page never came.
    unopened: float = 300.0
    #: Number of connections at a time, `alive` streams among them.
    connections: int = 32
    #: Request line and headers.
    head: int = 16 << 10
    #: Body of a question.
    body: int = 1 << 20


LIMITS = Limits()
#: Time between two looks for Ctrl-C, s.
LOOK = 0.25

#: The only method of each path.
ROUTES = {"/": "GET", "/ask": "POST", "/alive": "GET"}

#: Sent with every reply. The page may run what it contains and ask this server; it can load nothing from elsewhere.
HEADERS = """\
Cache-Control: no-store
Connection: close
Content-Security-Policy: default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src blob: data:; \
worker-src blob:; connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'
Referrer-Policy: no-referrer
X-Content-Type-Options: nosniff
X-Frame-Options: DENY
"""

REQUEST_LINE = re.compile(r"([A-Z]{1,16}) ([!-~]+) HTTP/1\.[01]")
HEADER = re.compile(r"([!#$%&'*+.^_`|~0-9A-Za-z-]+):[ \t]*([^\x00-\x08\x0a-\x1f\x7f]*)")


def serve(
    page: str,
    answer: Callable[[str], str],
    *,
    port: int = 0,
    opened: Callable[[str], object] = webbrowser.open,
    limits: Limits = LIMITS,
) -> None:
    """Show `page` in the browser and answer what it asks, until it has been closed.

    Parameters
    ----------
    page
        HTML text, all in one.
    answer
        JSON text to JSON text. It is called in threads, several at a time.
    port
        On 127.0.0.1. 0: one that is free.
    opened
        Called with the address of the page once it can be loaded.
    limits
        Times and sizes.

    Raises
    ------
    KeyboardInterrupt
        Ctrl-C. An answer that is being computed is not waited for.
    OSError
        The port is in use.
    """
    server = _Server(page.encode(), answer, limits)
    asyncio.run(server.run(port, opened))
    for thread in server.answering:
        thread.join()


class _Refused(Exception):
    """A request that gets a status and a reason instead of a reply."""

    def __init__(self, status: int, reason: str, *headers: str):
        self.reply = _reply(status, "text/plain", f"{reason}\n".encode(), *headers)


class _Server:
    def __init__(self, page: bytes, answer: Callable[[str], str], limits: Limits):
        self.page, self.answer, self.limits = page, answer, limits
        self.token = secrets.token_urlsafe(32)
        self.connections: set[asyncio.Task[None]] = set()
        self.answering: list[Thread] = []
        self.pages = 0

    async def run(self, port: int, opened: Callable[[str], object]) -> None:
        self.end: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        self._end_after(self.limits.unopened)
        listener = await asyncio.start_server(
            self.connect, "127.0.0.1", port, limit=self.limits.head, backlog=1024
        )
        port = listener.sockets[0].getsockname()[1]
        self.hosts = (f"127.0.0.1:{port}", f"localhost:{port}")
        # In a thread, because a browser in the terminal returns only when it is left.
        _, opening = _in_thread(opened, f"http://{self.hosts[0]}/?token={self.token}")
        opening.add_done_callback(self.opened)
        try:
            # Ctrl-C that the system delivers to another thread does not wake the loop.
            while not self.end.done():
                await asyncio.wait([self.end], timeout=LOOK)
            self.end.result()
        finally:
            listener.close()
            opening.cancel()
            self.end.cancel()
            for connection in self.connections:
                connection.cancel()
            await asyncio.gather(*self.connections, return_exceptions=True)

    def _end_after(self, seconds: float) -> None:
        def end() -> None:
            if not self.end.done():
                self.end.set_result(None)

        self.timer = asyncio.get_running_loop().call_later(seconds, end)

    def opened(self, opening: asyncio.Future[object]) -> None:
        """A failure of `opened` ends the server and leaves `serve`."""
        if opening.cancelled() or self.end.done():
            return
        if (error := opening.exception()) is not None:
            self.end.set_exception(error)

    def connect(
        self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter
    ) -> None:
        if len(self.connections) >= self.limits.connections:
            most = f"more than {self.limits.connections} connections at a time"
            writer.write(_Refused(503, most).reply)
            writer.close()
            return
        task = asyncio.create_task(self.converse(reader, writer))
        self.connections.add(task)
        task.add_done_callback(self.connections.discard)

    async def converse(
        self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter
    ) -> None:
        """One request and its reply."""
        try:
            # Either error: the other side has gone, or does not take the reply.
            with suppress(OSError, TimeoutError):
                reply = await self.reply(reader, writer)
                async with _timeout(self.limits.request):
                    writer.write(reply)
                    writer.close()
                    await writer.wait_closed()
        finally:
            writer.transport.abort()

    async def reply(
        self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter
    ) -> bytes:
        seconds = self.limits.request
        try:
            async with _timeout(seconds):
                path, body = await self.request(reader)
        except TimeoutError:
            late = f"the request is not complete after {seconds:g} s"
            return _Refused(408, late).reply
        except asyncio.LimitOverrunError:
            most = f"request line and headers exceed {self.limits.head} bytes"
            return _Refused(431, most).reply
        except asyncio.IncompleteReadError:
            return _Refused(400, "the request is not complete").reply
        except _Refused as refused:
            return refused.reply
        if path == "/":
            return _reply(200, "text/html; charset=utf-8", self.page)
        if path == "/alive":
            await self.stay(reader, writer)
            return b""
        thread, reply = _in_thread(self.answered, body)
        self.answering = [t for t in self.answering if t.is_alive()] + [thread]
        return await reply

    async def request(self, reader: asyncio.StreamReader) -> tuple[str, bytes]:
        """Path and body of a request that may be answered."""
        head = (await reader.readuntil(b"\r\n\r\n")).decode("latin-1")
        line, *lines = head[:-4].split("\r\n")
        asked = REQUEST_LINE.fullmatch(line)
        if asked is None:
            raise _Refused(400, f"{line[:80]!a} is not a request line")
        headers: dict[str, str] = {}
        for text in lines:
            header = HEADER.fullmatch(text)
            if header is None:
                raise _Refused(400, f"{text[:80]!a} is not a header")
            name = header[1].lower()
            if name in headers:
                raise _Refused(400, f"the header {header[1]} is there twice")
            headers[name] = header[2].rstrip(" \t")
        host = headers.get("host", "")
        if host not in self.hosts:
            raise _Refused(403, f"Host is {host!a}, not {' or '.join(self.hosts)}")
        if (origin := headers.get("origin", f"http://{host}")) != f"http://{host}":
            raise _Refused(403, f"Origin is {origin!a}, not 'http://{host}'")
        site = headers.get("sec-fetch-site", "none")
        if site not in ("none", "same-origin"):
            raise _Refused(403, f"Sec-Fetch-Site is {site!a}: another site asks")

        method, target = asked.groups()
        path, _, query = target.partition("?")
        if path not in ROUTES:
            raise _Refused(404, f"there is no {path[:80]}")
        if method != ROUTES[path]:
            allow = f"Allow: {ROUTES[path]}"
            raise _Refused(405, f"{path} is for {ROUTES[path]}, not {method}", allow)
        if "transfer-encoding" in headers:
            raise _Refused(501, "Transfer-Encoding is not taken; send Content-Length")
        if path == "/ask":
            where, token = "X-Standfast-Token", headers.get("x-standfast-token")
        else:
            where, token = "token=", parse_qs(query).get("token", [None])[0]
        if token is None:
            raise _Refused(403, f"{where} is missing")
        if not compare_digest(token.encode(), self.token.encode()):
            raise _Refused(403, f"{where} is not that of this server")
        if path != "/ask":
            return path, b""

        length = headers.get("content-length")
        if length is None:
            raise _Refused(411, "Content-Length is missing")
        if not re.fullmatch(r"[0-9]{1,18}", length):
            raise _Refused(400, f"Content-Length is {length[:80]!a}, not an integer")
        if int(length) > self.limits.body:
            most = f"Content-Length is {length}; at most {self.limits.body} is taken"
            raise _Refused(413, most)
        return path, await reader.readexactly(int(length))

    def answered(self, body: bytes) -> bytes:
        try:
            question = body.decode()
        except UnicodeDecodeError as error:
            return _Refused(400, f"the body is not UTF-8: {error}").reply
        try:
            return _reply(200, "application/json", self.answer(question).encode())
        except BaseException as error:  # A panic of the core is no Exception.
            problem = " ".join(f"{type(error).__name__}: {error}".split())
            return _Refused(500, f"no answer: {problem[:200]}").reply

    async def stay(
        self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter
    ) -> None:
        """The stream of a page, until the page has gone. The last one to go ends the server unless another comes."""
        self.pages += 1
        self.timer.cancel()
        try:
            writer.write(_head(200, "text/event-stream") + b"\r\n:\n\n")
            while not self.end.done():
                try:
                    async with _timeout(self.limits.beat):
                        if not await reader.read(1024):
                            return
                except TimeoutError:
                    writer.write(b":\n\n")
                    await writer.drain()
        finally:
            self.pages -= 1
            if self.pages == 0:
                self._end_after(self.limits.grace)


@asynccontextmanager
async def _timeout(seconds: float) -> AsyncIterator[None]:
    """As asyncio.timeout, which Python 3.10 has not. Another cancellation at the same moment may be lost: loops ask whether to go on."""
    task, late = asyncio.current_task(), False

    def cancel() -> None:
        nonlocal late
        if task is not None:
            late = task.cancel()

    timer = asyncio.get_running_loop().call_later(seconds, cancel)
    try:
        yield
    except asyncio.CancelledError:
        if not late:
            raise
        raise TimeoutError from None
    finally:
        timer.cancel()


def _head(status: int, kind: str, *headers: str) -> bytes:
    lines = [
        f"HTTP/1.1 {status} {HTTPStatus(status).phrase}",
        *HEADERS.splitlines(),
        f"Content-Type: {kind}",
        *headers,
    ]
    return "".join(f"{line}\r\n" for line in lines).encode("ascii")


def _reply(status: int, kind: str, body: bytes, *headers: str) -> bytes:
    length = f"Content-Length: {len(body)}"
    return _head(status, kind, length, *headers) + b"\r\n" + body


def _in_thread(
    function: Callable[[Value], Result], value: Value
) -> tuple[Thread, asyncio.Future[Result]]:
    """The value of a function, computed in a thread of its own. Those of an executor would be waited for after Ctrl-C."""
    result: Future[Result] = Future()

    def work() -> None:
        if result.set_running_or_notify_cancel():
            try:
                result.set_result(function(value))
            except BaseException as error:
                result.set_exception(error)

    thread = Thread(target=work, daemon=True)
    thread.start()
    return thread, asyncio.wrap_future(result)
