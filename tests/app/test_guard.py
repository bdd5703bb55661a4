"""Who may speak to the server of the bench."""

import os
import re
import socket
import time
from pathlib import Path

import httpx
import pytest
from app_server import TAB, Bench, running
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

from martensite.app.earlier_tokens import LONGEST_KEPT, TokenRecord, digest_token
from martensite.app.request_guard import NAMES
from martensite.app.server import bind_socket, make_folder
from martensite.base.errors import InputError

ELSEWHERE = ("http://evil.example", "null", "http://127.0.0.1:1", "https://127.0.0.1", "")
"""Origins of other pages; an empty one is none that a browser sends."""


def raw(bench: Bench, text: str) -> str:
    """The answer to bytes of one's own, headers included."""
    with socket.create_connection(("127.0.0.1", bench.port), timeout=10) as wire:
        wire.sendall(text.replace("\n", "\r\n").encode("latin-1"))
        parts: list[bytes] = []
        while part := wire.recv(65536):
            parts.append(part)
    return b"".join(parts).decode("utf-8", "replace")


def asked(bench: Bench, *headers: str, host: str = "", path: str = "/api/status") -> str:
    """First line of the answer to a request with the token and some more headers."""
    lines = [f"Host: {host or f'127.0.0.1:{bench.port}'}", f"Authorization: Bearer {bench.token}"]
    more = "\n".join([*lines, *headers, "Connection: close"])
    return raw(bench, f"GET {path} HTTP/1.1\n{more}\n\n").partition("\r\n")[0]


def test_who_holds_the_token_comes_in(bench: Bench) -> None:
    with bench.client() as client:
        assert client.get("/api/status").json()["name"] == "martensite"
    for host in (f"{name}:{bench.port}" for name in NAMES):
        assert " 200 " in asked(bench, f"Origin: http://{host}", host=host)


@pytest.mark.parametrize("origin", ELSEWHERE)
def test_pages_of_elsewhere_are_refused(bench: Bench, origin: str) -> None:
    with bench.client(Origin=origin) as client:
        answer = client.get("/api/status")
        assert answer.status_code == 403
        assert "may not use this server" in answer.json()["error"]
        assert client.post("/api/call/scenarios", json={}).status_code == 403
        preflight = client.options("/api/call/scenarios", headers={"Access-Control-Request-Method": "POST"})
    assert preflight.status_code == 403
    assert not [name for name in preflight.headers if name.startswith("access-control")]


@pytest.mark.parametrize("site", ["cross-site", "same-site", "nonsense"])
def test_requests_made_by_other_pages_are_refused(bench: Bench, site: str) -> None:
    with bench.client(**{"Sec-Fetch-Site": site}) as client:
        assert client.get("/api/status").status_code == 403
        assert client.get("/bench.js").status_code == 403
        moved = {"Sec-Fetch-Mode": "navigate"}
        assert client.get("/", headers=moved).status_code == 200
        assert client.get("/api/status", headers=moved).status_code == 403


@pytest.mark.parametrize("host", ["evil.example", "127.0.0.1", "127.0.0.1:1", "localhost.evil.example:{port}", "[::1]"])
def test_other_names_of_this_machine_are_refused(bench: Bench, host: str) -> None:
    assert " 421 " in asked(bench, host=host.format(port=bench.port))


@pytest.mark.parametrize(
    "headers",
    [
        ("Origin: http://evil.example", "Origin: http://127.0.0.1:{port}"),
        ("Origin: http://127.0.0.1:{port}", "Origin: http://evil.example"),
        ("Authorization: Bearer x",),
        ("Sec-Fetch-Site: none", "Sec-Fetch-Site: cross-site"),
        ("Cookie: a=1", "Cookie: b=2"),
        ("Host: evil.example",),
    ],
)
def test_doubled_headers_are_refused(bench: Bench, headers: tuple[str, ...]) -> None:
    line = asked(bench, *(header.format(port=bench.port) for header in headers))
    assert re.match(r"HTTP/1.1 (400|403) ", line), line


def test_a_page_of_another_name_of_this_machine_is_elsewhere(bench: Bench) -> None:
    assert " 403 " in asked(bench, f"Origin: http://localhost:{bench.port}")


@pytest.mark.parametrize("path", ["/", "/bench.js", "/api/status", "/api/jobs", "/nothing"])
def test_strangers_are_refused_everywhere(bench: Bench, path: str) -> None:
    with httpx.Client(base_url=bench.origin) as stranger:
        answers = [
            stranger.get(path),
            stranger.get(path, headers={"Authorization": "Bearer wrong"}),
            stranger.get(path, headers={"Authorization": f"Basic {bench.token}"}),
            stranger.get(path, headers={"Authorization": bench.token}),
            stranger.get(path, headers={"X-Token": bench.token}),
            stranger.get(path, headers={"Cookie": f"martensite-{bench.port}=wrong"}),
            stranger.get(path, headers={"Cookie": f"martensite-{bench.port + 1}={bench.token}"}),
            stranger.get(path, headers={"Cookie": 'a="; martensite'}),
            stranger.get(path, params={"token": "wrong"}),
        ]
        if path != "/":
            answers.append(stranger.get(path, params={"token": bench.token}))
    assert {answer.status_code for answer in answers} == {401}
    assert all("open the address that `martensite app` printed" in a.text for a in answers)


def test_the_token_is_left_in_no_address(bench: Bench) -> None:
    with httpx.Client(base_url=bench.origin) as client:
        entered = client.get("/", params={"token": bench.token})
        assert (entered.status_code, entered.headers["location"]) == (303, "/")
        cookie = entered.headers["set-cookie"]
        assert "HttpOnly" in cookie
        assert "samesite=lax" in cookie.lower()
        page = client.get("/")
        assert page.status_code == 200
        assert page.headers["referrer-policy"] == "no-referrer"
        assert bench.token not in page.text
        assert client.get("/api/status").status_code == 200


@pytest.mark.parametrize(
    "headers",
    [{"Origin": "http://evil.example"}, {"Origin": "null"}, {"Sec-Fetch-Site": "cross-site"}, {"Host": "evil.example"}],
)
def test_sockets_of_elsewhere_are_refused(bench: Bench, headers: dict[str, str]) -> None:
    known = {"Authorization": f"Bearer {bench.token}"}
    with pytest.raises(InvalidStatus):
        connect(watched(bench), additional_headers={**known, **headers}, open_timeout=5)


def test_sockets_without_the_token_are_refused(bench: Bench) -> None:
    for headers in ({}, {"Authorization": "Bearer wrong"}):
        with pytest.raises(InvalidStatus, match="403"):
            connect(watched(bench), additional_headers=headers, open_timeout=5)


def watched(bench: Bench) -> str:
    return f"{bench.origin.replace('http', 'ws')}/api/jobs/{'0' * 16}/watch?tab={TAB}"


@pytest.mark.parametrize("method", ["HEAD", "PUT", "PATCH", "DELETE", "OPTIONS", "TRACE", "CONNECT", "BREW"])
def test_other_methods_are_refused_by_a_sentence(bench: Bench, method: str) -> None:
    with bench.client() as client:
        for path in ("/api/call/run", "/api/jobs", "/api/files", "/bench.js"):
            answer = client.request(method, path)
            refused = answer.status_code in (400, 404, 405)
            assert refused or method == "HEAD", f"{path}: {answer.status_code}"
            assert "Traceback" not in answer.text
        assert client.get("/api/status").status_code == 200


@pytest.mark.parametrize(
    "path",
    [
        "/../pyproject.toml",
        "/..%2fserver.py",
        "/%2e%2e/server.py",
        "/..%5cserver.py",
        "/%00",
        "//etc/passwd",
        "/%2fetc%2fpasswd",
        "/static/",
        "/.",
        "/api",
        "/api/",
        "/a" * 500,
        "/%ff",
        "/C:%5cwindows",
        "/bench.js%00.css",
    ],
)
def test_nothing_beside_the_page_is_served(bench: Bench, path: str) -> None:
    line = asked(bench, path=path)
    assert re.match(r"HTTP/1.1 (400|404|405|431) ", line), line


def test_browsers_keep_files_that_never_change(bench: Bench) -> None:
    """RFC 9111: the browser uses a fresh answer again without a request, but requests the page itself each time."""
    with bench.client() as client:
        page = client.get("/")
        module = re.search(r'href="([\w-]+-[0-9A-Z]{8}\.js)"', page.text)
        assert module
        kept = [client.get(f"/{name}").headers["cache-control"] for name in ("icon.svg", module[1])]
        asked_again = [client.get(path).headers["cache-control"] for path in ("/", "/bench.js", "/api/status")]
    assert all("max-age=31536000" in words for words in kept)
    assert asked_again == ["no-cache"] * 3


def test_every_answer_keeps_the_page_to_this_server(bench: Bench) -> None:
    with bench.client() as client:
        answers = [
            client.get("/"),
            client.get("/bench.js"),
            client.get("/nothing"),
            client.post("/api/call/run", content=b"["),
            client.get("/api/jobs"),
            client.get("/api/status", headers={"Authorization": "Bearer wrong"}),
            client.get("/api/status", headers={"Origin": "null"}),
        ]
    for answer in answers:
        policy = answer.headers["content-security-policy"]
        assert policy.startswith("default-src 'none'; script-src 'self' 'wasm-unsafe-eval';")
        assert f"connect-src 'self' ws://127.0.0.1:{bench.port};" in policy
        assert answer.headers["x-content-type-options"] == "nosniff"
        assert "server" not in answer.headers


@pytest.mark.parametrize("port", [-1, 65536])
def test_a_port_that_is_none(port: int) -> None:
    with pytest.raises(InputError, match="between 0 and 65535"):
        bind_socket(port)


def test_a_port_that_is_taken(bench: Bench) -> None:
    with pytest.raises(InputError, match=f"Port {bench.port} cannot be used"):
        bind_socket(bench.port)


# ---------------------------------------------------------------- a server that comes back


def cookie_of(bench: Bench) -> dict[str, str]:
    return {"Cookie": f"martensite-{bench.port}={bench.token}"}


def test_a_tab_goes_on_when_the_server_is_started_again_on_its_port(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    with running(tmp_path / "new" / "folder") as first:
        pass
    with running(tmp_path / "new" / "folder") as again:
        assert again.port == first.port  # the usual one, without being asked for
        assert again.token != first.token
        with httpx.Client(base_url=again.origin) as tab:
            answer = tab.get("/api/status", headers=cookie_of(first))
            assert answer.status_code == 200
            assert f"martensite-{again.port}={again.token};" in answer.headers["set-cookie"]
            assert "HttpOnly" in answer.headers["set-cookie"]
            assert "set-cookie" not in tab.get("/api/status", headers=cookie_of(again)).headers
            for stranger in (
                {"Authorization": f"Bearer {first.token}"},
                {"Cookie": f"martensite-{again.port}={digest_token(first.token)}"},
                {**cookie_of(first), "Origin": "http://evil.example"},
                {**cookie_of(first), "Sec-Fetch-Site": "cross-site"},
            ):
                refused = httpx.get(f"{again.origin}/api/status", headers=stranger)
                assert refused.status_code in (401, 403)
                assert "set-cookie" not in refused.headers
            assert httpx.get(f"{again.origin}/", params={"token": first.token}).status_code == 401
    kept = tmp_path / "cache/martensite/app" / f"{first.port}.json"
    assert first.token not in kept.read_text()
    if os.name == "posix":
        assert kept.stat().st_mode & 0o777 == 0o600
        assert kept.parent.stat().st_mode & 0o777 == 0o700


def test_what_others_could_have_written_and_what_is_old_opens_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    record = TokenRecord(tmp_path)
    record.add_start(8000, "a")
    record.add_start(8000, "b")
    assert record.list_earlier(8000) == {digest_token("a"), digest_token("b")}
    assert record.list_earlier(8001) == frozenset()
    assert record.find_port() == 8000
    record.add_start(1, "a")  # for the administrator, who has to name such a port each time
    assert record.find_port() == 0
    if os.name == "posix":
        (tmp_path / "8000.json").chmod(0o620)
        assert record.list_earlier(8000) == frozenset()
        (tmp_path / "8000.json").chmod(0o600)
    for broken in ("[1]", "{", '[["a"]]', '{"a": 1}', '[["a", "b"]]'):
        (tmp_path / "8000.json").write_text(broken)
        assert record.list_earlier(8000) == frozenset()
    record.add_start(8000, "c")
    later = time.time() + LONGEST_KEPT + 1
    monkeypatch.setattr(time, "time", lambda: later)
    assert record.list_earlier(8000) == frozenset()


def test_a_folder_that_cannot_be_made_is_said(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="cannot be the folder of the bench"):
        make_folder(tmp_path / "file" / "below")
