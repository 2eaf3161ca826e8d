"""Several replicas: behind nginx and Caddy as docs/scale.md configures them, and in the manifests of Kubernetes."""

import os
import re
import shutil
import subprocess
import time
from collections.abc import Iterator
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import Any

import httpx
import pytest
import yaml
from harness import Running, Walker, run
from websockets.sync.client import connect

from server.http.shutdown import END_SECONDS
from server.settings import ServerSettings, load_settings
from tests.server.test_proxies import NGINX_HEAD, free_port

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "docs" / "scale.md").read_text()
COMPOSE = (ROOT / "docker" / "compose.yaml").read_text()
DOCUMENTS = list(yaml.safe_load_all((ROOT / "docker" / "kubernetes.yaml").read_text()))
CONNECTION = "map $http_upgrade $lumenwalk_connection { default upgrade; '' ''; }\n"
PLACES = ("127.0.0.1:8000", "127.0.0.1:8001")


def configured(proxy: str, folder: Path, port: int, replicas: list[Running]) -> list[str]:
    """The command of a proxy that has the configuration of the page, but for addresses and TLS."""
    language = {"nginx": "nginx", "caddy": "caddyfile"}[proxy]
    blocks = re.findall(rf"```{language}\n(.*?)```", PAGE, re.S)
    for n, replica in enumerate(replicas):
        blocks = [block.replace(PLACES[n], replica.http.base_url.netloc.decode()) for block in blocks]
    file = folder / "configuration"
    if proxy == "caddy":
        site = blocks[0].replace("example.org {", f"http://127.0.0.1:{port} {{")
        file.write_text("{\n\tadmin off\n}\n" + site)
        return ["caddy", "run", "--config", str(file), "--adapter", "caddyfile"]
    head = NGINX_HEAD.format(folder=folder, user="user root;" if os.geteuid() == 0 else "")
    server = f"server {{ listen 127.0.0.1:{port}; {blocks[1]} }}\n"
    file.write_text(head + CONNECTION + blocks[0] + server + "}\n")
    return ["nginx", "-c", str(file), "-p", str(folder), "-e", str(folder / "error.log")]


@pytest.fixture(scope="module")
def replicas() -> Iterator[list[Running]]:
    with ExitStack() as stack:
        services = [stack.enter_context(run(ServerSettings(port=0, root_path=f"/r/{n}"))) for n in range(2)]
        for service in services:
            service.wait_ready()
        yield services


@pytest.fixture(params=["nginx", "caddy"])
def front(request: pytest.FixtureRequest, replicas: list[Running], tmp_path: Path) -> Iterator[httpx.Client]:
    """A client of the proxy before both replicas."""
    if shutil.which(request.param) is None:
        pytest.skip(f"needs {request.param}")
    port = free_port()
    command = configured(request.param, tmp_path, port, replicas)
    environment = os.environ | {"HOME": str(tmp_path), "XDG_DATA_HOME": str(tmp_path), "XDG_CONFIG_HOME": str(tmp_path)}
    with (
        (tmp_path / "log").open("wb") as log,
        subprocess.Popen(command, stdout=log, stderr=log, env=environment) as process,
        httpx.Client(base_url=f"http://127.0.0.1:{port}", timeout=20) as client,
    ):
        try:
            deadline = time.monotonic() + 60.0
            while True:
                with suppress(httpx.TransportError):
                    client.get("/r/0/healthz")
                    break
                assert process.poll() is None, (tmp_path / "log").read_text()
                assert time.monotonic() < deadline, (tmp_path / "log").read_text()
                time.sleep(0.05)  # the proxy and both services have the same cores
            yield client
        finally:
            process.terminate()


def test_pages_walks_and_jobs_stay_with_the_replica_of_their_path(front: httpx.Client, replicas: list[Running]) -> None:
    for n, replica in enumerate(replicas):
        assert front.get(f"/r/{n}", follow_redirects=True).url.path == f"/r/{n}/"
        assert front.get(f"/r/{n}/api/openapi.json").json()["servers"] == [{"url": f"/r/{n}"}]
        made = front.post(f"/r/{n}/api/v1/jobs", json={"size": [8, 8]})
        assert made.headers["Location"].startswith(f"/r/{n}/api/v1/jobs/")
        assert made.json()["id"] in replica.service.jobs._jobs
        before = replica.service.last_viewer
        with connect(f"ws://{front.base_url.netloc.decode()}/r/{n}/api/v1/stream", max_size=2**26) as socket:
            walker = Walker(socket)
            walker.hello()
            walker.pose(1)
            assert walker.frame()
            assert any(number > before for number in replica.service.viewers)
    # Answered by a replica, which has no list here.
    assert front.post("/api/v1/assign", json={"scene": "cornell-box"}).json()["code"] == "forbidden"
    assert front.get("/r/2/healthz").text != '{"status":"ok"}'


def test_compose_makes_a_replica_of_a_project() -> None:
    command = PAGE.split("for n in 0 1; do")[1].split("done")[0]
    for name in re.findall(r"\b([A-Z_]+)=", command):
        assert f"${{{name}:-" in COMPOSE
    environment = yaml.safe_load(COMPOSE)["services"]["lumenwalk"]["environment"]
    assert {name.removeprefix("LUMENWALK_").lower() for name in environment} <= set(ServerSettings.model_fields)


def manifest(kind: str, name: str = "lumenwalk") -> Any:
    (found,) = (it for it in DOCUMENTS if (it["kind"], it["metadata"]["name"]) == (kind, name))
    return found["spec"]


def pod() -> Any:
    return manifest("StatefulSet")["template"]["spec"]


def test_each_pod_has_a_service_and_a_path() -> None:
    names = [f"lumenwalk-{n}" for n in range(manifest("StatefulSet")["replicas"])]
    (rule,) = manifest("Ingress")["rules"]
    assigning, *paths = rule["http"]["paths"]
    assert (assigning["path"], assigning["backend"]["service"]["name"]) == ("/api/v1/assign", "lumenwalk-assign")
    labels = manifest("StatefulSet")["template"]["metadata"]["labels"]
    assert manifest("Service", "lumenwalk-assign")["selector"] == labels
    assert [it["path"] for it in paths] == [f"/r/{name}" for name in names]
    assert [it["backend"]["service"]["name"] for it in paths] == names
    for name in names:
        service = manifest("Service", name)
        assert service["selector"] == {"statefulset.kubernetes.io/pod-name": name}
        assert service["publishNotReadyAddresses"]


def test_names_in_the_manifests_fit_each_other() -> None:
    (container,) = pod()["containers"]
    ports = {it["name"]: it["containerPort"] for it in container["ports"]}
    assert ports == {"http": ServerSettings().port}
    labels = manifest("StatefulSet")["template"]["metadata"]["labels"]
    assert manifest("StatefulSet")["selector"] == manifest("PodDisruptionBudget")["selector"] == {"matchLabels": labels}
    headless = manifest("Service", manifest("StatefulSet")["serviceName"])
    assert (headless["clusterIP"], headless["selector"]) == ("None", labels)
    volumes = {it["name"] for it in pod()["volumes"]}
    volumes |= {it["metadata"]["name"] for it in manifest("StatefulSet")["volumeClaimTemplates"]}
    assert {it["name"] for it in container["volumeMounts"]} == volumes
    probes = [container[f"{name}Probe"]["httpGet"] for name in ("startup", "readiness", "liveness")]
    assert [it["path"] for it in probes] == ["/readyz", "/readyz", "/healthz"]
    for it in [*probes, *(port for doc in DOCUMENTS if doc["kind"] == "Service" for port in doc["spec"]["ports"])]:
        assert it.get("targetPort", it["port"]) in ports


def test_the_pod_sets_settings_that_exist_and_no_others(monkeypatch: pytest.MonkeyPatch) -> None:
    assert pod()["enableServiceLinks"] is False
    (container,) = pod()["containers"]
    for variable in container["env"]:
        value = variable.get("value", "0123456789abcdef").replace("$(POD_NAME)", "lumenwalk-0")
        assert variable["name"].removeprefix("LUMENWALK_").lower() in {*ServerSettings.model_fields, "pod_name"}
        monkeypatch.setenv(variable["name"], value)
    settings = load_settings()
    assert settings.root_path == "/r/lumenwalk-0"
    assert settings.replicas == tuple(
        f"http://lumenwalk-{n}.lumenwalk:8000/r/lumenwalk-{n}" for n in range(manifest("StatefulSet")["replicas"])
    )
    assert settings.trusted_proxies == ("10.0.0.0/8",)


def test_the_pod_has_no_privileges_and_time_to_end() -> None:
    (container,) = pod()["containers"]
    assert container["securityContext"] == {
        "allowPrivilegeEscalation": False,
        "readOnlyRootFilesystem": True,
        "capabilities": {"drop": ["ALL"]},
    }
    assert pod()["securityContext"]["runAsNonRoot"]
    assert str(pod()["securityContext"]["runAsUser"]) in (ROOT / "docker" / "Dockerfile").read_text()
    assert not pod()["automountServiceAccountToken"]
    assert pod()["terminationGracePeriodSeconds"] > END_SECONDS
