"""A server for the people of one address: token, host, origin and size of every request.

Every address begins with a random token, which only the printed address has. Requests must name
the server as their host: a name of another site that resolves to it is refused. Whatever is posted
must come from the server's own page.
"""

import hmac
import json
import secrets
from http import HTTPStatus
from typing import Any

from mobilegs.errors import InputError
from mobilegs.view.serve import BoundedServer, Handler, names_this_machine


class PrivateServer(BoundedServer):
    """A server whose addresses begin with a token.

    Attributes:
        token: what every address begins with.
        posted_max: bytes that a page may post.
    """

    posted_max = 1 << 20

    def __init__(self, *values: Any, **options: Any) -> None:
        super().__init__(*values, **options)
        self.token = secrets.token_urlsafe(24)

    @property
    def path(self) -> str:
        """The page's URL path, which has the token."""
        return f"/{self.token}/"


class PrivateHandler(Handler):
    """Answers the requests that have the token, and refuses all others."""

    server: PrivateServer  # pyright: ignore[reportIncompatibleVariableOverride]

    def do_GET(self) -> None:
        asked = self._asked()
        if asked is not None:
            self.get(asked)

    def do_POST(self) -> None:
        # what was posted is not always read: then the connection cannot be used again
        reusable, self.close_connection = not self.close_connection, True
        asked = self._asked()
        if asked is None:
            return
        if self.headers.get("Origin") != f"http://{self.headers.get('Host')}":
            self.send_error(HTTPStatus.FORBIDDEN, "only the server's own page may post")
            return
        if self.headers.get("Content-Type", "").split(";")[0] != "application/json":
            self.send_error(HTTPStatus.UNSUPPORTED_MEDIA_TYPE, "JSON is needed")
            return
        length = self.headers.get("Content-Length", "")
        if "Transfer-Encoding" in self.headers or not (length.isascii() and length.isdecimal()):
            self.send_error(HTTPStatus.LENGTH_REQUIRED, "the length is not known")
            return
        if len(length) > 12 or int(length) > self.server.posted_max:
            self.send_error(HTTPStatus.REQUEST_ENTITY_TOO_LARGE, "this is too much")
            return
        body = self.rfile.read(int(length))
        self.close_connection = not reusable
        try:
            posted = json.loads(body)
        except (RecursionError, ValueError):
            self.answer_json({"error": "this is not JSON"}, HTTPStatus.BAD_REQUEST)
            return
        try:
            self.post(asked, posted)
        except InputError as error:
            self.answer_json({"error": str(error)}, HTTPStatus.BAD_REQUEST)

    def get(self, asked: str) -> None:
        """Answer a request for what follows the token."""
        raise NotImplementedError

    def post(self, asked: str, posted: Any) -> None:
        """Answer what was posted; raises InputError with the sentence that the page shows."""
        raise NotImplementedError

    def answer_missing(self) -> None:
        """Answer that there is nothing at this address."""
        self.send_error(HTTPStatus.NOT_FOUND, "there is no such file here")

    def answer_json(self, content: Any, status: HTTPStatus = HTTPStatus.OK) -> None:
        """Answer with JSON."""
        self.answer_bytes("application/json", json.dumps(content).encode(), status=status)

    def answer_bytes(
        self,
        kind: str,
        body: bytes,
        headers: dict[str, str] | None = None,
        *,
        status: HTTPStatus = HTTPStatus.OK,
    ) -> None:
        """Answer with bytes that nobody stores."""
        self._answer(kind, body, {"Cache-Control": "no-store", **(headers or {})}, status)

    def end_headers(self) -> None:
        self.send_header("Cross-Origin-Opener-Policy", "same-origin")
        super().end_headers()

    def _asked(self) -> str | None:
        """Return what follows the token, or None after an answer that refuses the request."""
        if not names_this_machine(self.headers.get("Host", "")):
            self.send_error(HTTPStatus.FORBIDDEN, "use the address that is printed, with numbers")
            return None
        _, token, *rest = [*self.path.partition("?")[0].split("/", 2), ""]
        if not hmac.compare_digest(token.encode(), self.server.token.encode()):
            self.answer_missing()
            return None
        return rest[0]
