"""The service behind nginx, Caddy and Traefik, as docs/proxies.md configures them: its text is what runs here.

What a machine of a test differs in is replaced: ports, files, certificates, and times of rest, which are to be short.
"""

import os
import re
import shutil
import socket
import ssl
import subprocess
import time
import tomllib
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import urljoin

import httpx
import pytest
from gradient_worker import IDENTITY
from harness import PATIENCE, Running, Walker, run
from websockets.sync.client import ClientConnection, connect

from gpu.settings import RenderSettings
from server.jobs import RenderJob
from server.settings import ServerSettings
from server.wire.worker import CameraMatrix, Render

PAGE = Path(__file__).parents[2] / "docs" / "proxies.md"
NAME, PREFIX, SERVICE = "example.org", "/walk", "127.0.0.1:8000"
TOKEN = "correct-horse-battery-staple"
BEARER = {"Authorization": f"Bearer {TOKEN}"}
KEEPALIVE_SECONDS, IDLE_SECONDS, REST_SECONDS = 0.4, 4, 5.0
NGINX_HEAD = """
{user}
daemon off; pid {folder}/nginx.pid; error_log {folder}/error.log;
events {{}}
http {{
    access_log off;
    client_body_temp_path {folder}; proxy_temp_path {folder}; fastcgi_temp_path {folder}; uwsgi_temp_path {folder};
    scgi_temp_path {folder};
"""
CADDY_HEAD = """{{
	admin off
	auto_https disable_redirects
	servers {{
		timeouts {{
			idle {idle}s
		}}
	}}
}}
"""


@dataclass
class Site:
    """A proxy that runs, the service behind it, and what trusts its certificate."""

    service: Running
    port: int
    plain_port: int
    trust: ssl.SSLContext

    @property
    def origin(self) -> str:
        return f"https://{NAME}:{self.port}"

    def ask(self, method: str, path: str, headers: Mapping[str, str] = BEARER, **kwargs: Any) -> httpx.Response:
        """The answer to a request for a path of the site, which is not followed further."""
        host = {"Host": f"{NAME}:{self.port}"}
        with httpx.Client(base_url=f"https://127.0.0.1:{self.port}", verify=self.trust, timeout=PATIENCE) as http:
            return http.request(method, path, headers={**host, **headers}, extensions={"sni_hostname": NAME}, **kwargs)

    def socket(self, headers: Mapping[str, str] = BEARER) -> ClientConnection:
        """A WebSocket over TLS."""
        plain = socket.create_connection(("127.0.0.1", self.port), 10.0)
        url = f"wss://{NAME}:{self.port}{PREFIX}/api/v1/stream"
        return connect(url, sock=plain, ssl=self.trust, additional_headers=headers, ping_interval=None, max_size=2**26)


def blocks(language: str) -> list[str]:
    """The blocks of the page in this language."""
    return re.findall(rf"```{language}\n(.*?)```", PAGE.read_text(), re.S)


def replaced(text: str, changes: Mapping[str, str]) -> str:
    """A text with what this machine differs in; each change must have a place."""
    for old, new in changes.items():
        assert old in text, f"docs/proxies.md has no {old!r} any more"
        text = text.replace(old, new)
    return text


def nginx(folder: Path, place: str, ports: tuple[int, int], certificate: tuple[Path, Path]) -> list[str]:
    plain, port = ports
    (text,) = blocks("nginx")
    changes = {
        "listen [::]:80;": "",
        "listen [::]:443 ssl;": "",
        "listen 80;": f"listen 127.0.0.1:{plain};",
        "listen 443 ssl;": f"listen 127.0.0.1:{port} ssl;",
        "/etc/ssl/certs/example.org.pem": str(certificate[0]),
        "/etc/ssl/private/example.org.key": str(certificate[1]),
        SERVICE: place,
        "proxy_read_timeout 300s;": f"proxy_read_timeout {IDLE_SECONDS}s;",
    }
    file = folder / "nginx.conf"
    head = NGINX_HEAD.format(folder=folder, user="user root;" if os.geteuid() == 0 else "")
    file.write_text(head + replaced(text, changes) + "}\n")
    return ["nginx", "-c", str(file), "-p", str(folder), "-e", str(folder / "error.log")]


def caddy(folder: Path, place: str, ports: tuple[int, int], certificate: tuple[Path, Path]) -> list[str]:
    (text,) = blocks("caddyfile")
    site = f"{NAME}:{ports[1]} {{\n\tbind 127.0.0.1\n\ttls {certificate[0]} {certificate[1]}\n"
    file = folder / "Caddyfile"
    file.write_text(CADDY_HEAD.format(idle=IDLE_SECONDS) + replaced(text, {f"{NAME} {{\n": site, SERVICE: place}))
    return ["caddy", "run", "--config", str(file), "--adapter", "caddyfile"]


def traefik(folder: Path, place: str, ports: tuple[int, int], certificate: tuple[Path, Path]) -> list[str]:
    static, dynamic = blocks("toml")
    changes = {
        '":80"': f'"127.0.0.1:{ports[0]}"',
        '":443"': f'"127.0.0.1:{ports[1]}"',
        'readTimeout = "0s"': f'readTimeout = "0s"\nidleTimeout = "{IDLE_SECONDS}s"',
        "/var/lib/traefik/acme.json": str(folder / "acme.json"),
        "/etc/traefik/lumenwalk.toml": str(folder / "lumenwalk.toml"),
    }
    (folder / "traefik.toml").write_text(replaced(static, changes))
    own = '[[tls.certificates]]\ncertFile = "{}"\nkeyFile = "{}"\n'.format(*certificate)
    (folder / "lumenwalk.toml").write_text(
        replaced(dynamic, {'certResolver = "letsencrypt"': "", SERVICE: place}) + own
    )
    return ["traefik", f"--configFile={folder / 'traefik.toml'}"]


# What starts each, and what the service has to be told: Caddy and Traefik leave the prefix and say nothing of it.
PROXIES: dict[str, tuple[Callable[..., list[str]], str]] = {
    "nginx": (nginx, ""),
    "caddy": (caddy, PREFIX),
    "traefik": (traefik, PREFIX),
}


def free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as listener:
        return int(listener.getsockname()[1])


def wait_until_up(site: Site, process: "subprocess.Popen[bytes]", log: Path) -> None:
    deadline = time.monotonic() + PATIENCE
    while True:
        with suppress(httpx.TransportError):
            if site.ask("GET", f"{PREFIX}/healthz").status_code == 200:
                return
        assert process.poll() is None, log.read_text()
        assert time.monotonic() < deadline, log.read_text()
        time.sleep(0.05)


@pytest.fixture(scope="module")
def certificate(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """A certificate for the site's name, signed by itself, and its key."""
    if shutil.which("openssl") is None:
        pytest.skip("needs openssl")
    folder = tmp_path_factory.mktemp("certificate")
    files = folder / "site.pem", folder / "site.key"
    kind = ("-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes", "-days", "2")
    name = ("-subj", f"/CN={NAME}", "-addext", f"subjectAltName=DNS:{NAME}")
    command = ("openssl", "req", *kind, *name, "-out", str(files[0]), "-keyout", str(files[1]))
    subprocess.run(command, check=True, capture_output=True)
    return files


@pytest.fixture(scope="module", params=PROXIES)
def site(
    request: pytest.FixtureRequest, certificate: tuple[Path, Path], tmp_path_factory: pytest.TempPathFactory
) -> Iterator[Site]:
    """The service behind one proxy."""
    configure, root_path = PROXIES[request.param]
    if shutil.which(request.param) is None:
        pytest.skip(f"needs {request.param}")
    folder = tmp_path_factory.mktemp(request.param)
    plain, port = ports = free_port(), free_port()
    told = {"allowed_hosts": NAME, "root_path": root_path, "keepalive_seconds": KEEPALIVE_SECONDS}
    with ExitStack() as stack:
        service = stack.enter_context(run(ServerSettings(port=0, token=TOKEN, **told)))
        service.wait_ready()
        command = configure(folder, service.http.base_url.netloc.decode(), ports, certificate)
        log = folder / "log"
        environment = os.environ | {"HOME": str(folder), "XDG_DATA_HOME": str(folder), "XDG_CONFIG_HOME": str(folder)}
        with log.open("wb") as output:
            process = stack.enter_context(subprocess.Popen(command, stdout=output, stderr=output, env=environment))
        stack.callback(process.terminate)
        site = Site(service, port, plain, ssl.create_default_context(cafile=str(certificate[0])))
        wait_until_up(site, process, log)
        yield site


def test_the_page_and_all_that_it_loads(site: Site) -> None:
    bare = site.ask("GET", PREFIX, follow_redirects=False)
    assert bare.status_code in (301, 307, 308)
    assert urljoin(site.origin + PREFIX, bare.headers["Location"]) == f"{site.origin}{PREFIX}/"
    page = site.ask("GET", f"{PREFIX}/")
    for link in re.findall(r'(?:src|href)="([^"#:]+)"', page.text):
        assert site.ask("GET", urljoin(f"{PREFIX}/", link)).status_code == 200
    site.service.http.get("/api/openapi.json")  # made once, which on busy cores may take longer than proxies wait here
    assert site.ask("GET", f"{PREFIX}/api/openapi.json").json()["servers"] == [{"url": PREFIX}]
    assert "lumenwalk" not in site.ask("GET", "/").text  # another site's


def test_the_printed_link_leaves_a_cookie_for_https_below_the_prefix(site: Site) -> None:
    response = site.ask("GET", f"{PREFIX}/?token={TOKEN}", headers={})
    assert response.status_code == 303
    assert urljoin(f"{site.origin}{PREFIX}/?token=x", response.headers["Location"]) == f"{site.origin}{PREFIX}/"
    cookie = response.headers["Set-Cookie"]
    assert f"Path={PREFIX}/;" in cookie
    assert "Secure" in cookie
    assert site.ask("GET", f"{PREFIX}/", headers={"Cookie": cookie.split(";")[0]}).status_code == 200


def test_stills_jobs_and_large_bodies(site: Site) -> None:
    own = BEARER | {"Origin": site.origin}
    assert site.ask("POST", f"{PREFIX}/api/v1/render", own, json={"size": [32, 18]}).status_code == 200
    foreign = BEARER | {"Origin": f"http://{NAME}:{site.port}"}
    assert site.ask("POST", f"{PREFIX}/api/v1/render", foreign, json={"size": [32, 18]}).status_code == 403
    made = site.ask("POST", f"{PREFIX}/api/v1/jobs", own, json={"size": [32, 18]})
    assert "event: end" in site.ask("GET", f"{made.headers['Location']}/events").text
    assert site.ask("GET", f"{made.headers['Location']}/result").headers["Content-Type"] == "image/png"
    large = site.ask(
        "POST", f"{PREFIX}/api/v1/render", own, content=bytes(2 * 2**20)
    )  # nginx stops at 1 MiB unless told
    assert (large.status_code, large.json()["code"]) == (413, "too-large")


def test_a_walk_over_tls_gets_frames(site: Site) -> None:
    with site.socket(BEARER | {"Origin": site.origin}) as connection:
        walker = Walker(connection)
        walker.hello()
        for number in range(1, 4):
            walker.pose(number)
            header, image = walker.frame()
            walker.send("ack", frame=header.frame)
            assert image.startswith(b"\xff\xd8")


def test_walks_and_events_may_rest_longer_than_the_proxy_waits(site: Site) -> None:
    jobs = site.service.service.jobs
    still = Render(
        0, site.service.service.catalogue.served, CameraMatrix(IDENTITY, 1.0), (8, 8), RenderSettings(), ".png"
    )
    jobs._jobs["rests"] = RenderJob("rests", still, 1, "image/png")  # nobody is told of it, so that it waits
    url, host = f"https://127.0.0.1:{site.port}{PREFIX}/api/v1/jobs/rests", {"Host": f"{NAME}:{site.port}"}
    with site.socket() as connection, httpx.Client(verify=site.trust, timeout=PATIENCE) as http:
        walker = Walker(connection)
        walker.hello()
        told: dict[str, float] = {}
        began = time.monotonic()
        with http.stream("GET", f"{url}/events", headers=BEARER | host, extensions={"sni_hostname": NAME}) as answer:
            for line in answer.iter_lines():
                told.setdefault(line, time.monotonic() - began)
                if ":" in told and time.monotonic() - began > REST_SECONDS:
                    break
        assert told["event: progress"] < IDLE_SECONDS  # it came at once, not when a buffer was full
        walker.pose(1)
        assert walker.frame()
    assert site.ask("DELETE", f"{PREFIX}/api/v1/jobs/rests").json()["state"] == "cancelled"


def test_http_leads_to_https(site: Site) -> None:
    try:
        answer = httpx.get(f"http://127.0.0.1:{site.plain_port}{PREFIX}/", headers={"Host": NAME})
    except httpx.ConnectError:
        pytest.skip("Caddy does so by itself, on port 80 only")
    assert answer.status_code in (301, 302, 307, 308)
    assert answer.headers["Location"].startswith(f"https://{NAME}")


def test_traefik_is_told_what_belongs_together() -> None:
    static, dynamic = (tomllib.loads(text) for text in blocks("toml"))
    (router,) = dynamic["http"]["routers"].values()
    (service,) = dynamic["http"]["services"].values()
    assert router["service"] in dynamic["http"]["services"]
    assert set(router["entryPoints"]) <= set(static["entryPoints"])
    assert router["tls"]["certResolver"] in static["certificatesResolvers"]
    assert f"Path(`{PREFIX}`)" in router["rule"]
    assert service["loadBalancer"]["servers"] == [{"url": f"http://{SERVICE}"}]


def test_the_page_starts_the_service_as_it_is_here() -> None:
    text = PAGE.read_text()
    assert f"--allowed-hosts {NAME} --root-path {PREFIX}" in text
    assert f"{ServerSettings().keepalive_seconds:.0f} s of rest" in text
    assert ServerSettings().max_upload_bytes == 512 * 2**20  # as nginx is told
