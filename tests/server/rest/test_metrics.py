import re
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

from glb_file import TRIANGLE_GLB
from gradient_worker import MEMORY, SLOW_SECONDS, SLOW_SEED
from harness import Running, wait_for
from prometheus_client.parser import text_string_to_metric_families


def scrape(running: Running) -> dict[str, float]:
    """The samples without labels of /metrics."""
    response = running.http.get("/metrics")
    assert response.status_code == 200
    families = text_string_to_metric_families(response.text)
    return {sample.name: sample.value for family in families for sample in family.samples if not sample.labels}


def test_metrics_say_who_is_here_and_what_is_under_way(running: Running) -> None:
    before = scrape(running)
    with running.walker() as walker:
        walker.hello()
        running.service.metrics.windows[max(running.service.viewers)] = 3
        samples = scrape(running)
        assert samples["lumenwalk_viewers"] == before["lumenwalk_viewers"] + 1
        assert samples["lumenwalk_window_frames"] == before["lumenwalk_window_frames"] + 3
        assert samples["lumenwalk_ready"] == 1
        assert samples["lumenwalk_stills_waiting"] == 0
        assert samples["lumenwalk_engine_restarts_total"] == 0
        assert samples["process_resident_memory_bytes"] > 0
    wait_for(lambda: scrape(running)["lumenwalk_viewers"] <= before["lumenwalk_viewers"])
    assert scrape(running)["lumenwalk_window_frames"] == before["lumenwalk_window_frames"]


def test_metrics_say_what_the_device_is_used_for(running: Running) -> None:
    before = scrape(running)["lumenwalk_device_busy_seconds_total"]
    body = {"size": [8, 8], "settings": {"seed": SLOW_SEED}}
    assert running.http.post("/api/v1/render", json=body).status_code == 200
    samples = scrape(running)
    assert samples["lumenwalk_device_busy_seconds_total"] >= before + SLOW_SECONDS
    memory = samples["lumenwalk_device_memory_used_bytes"], samples["lumenwalk_device_memory_bytes"]
    assert memory == MEMORY
    text = running.http.get("/metrics").text
    assert 'lumenwalk_worker_ready{worker="0"} 1.0' in text
    assert f'lumenwalk_worker_memory_used_bytes{{worker="0"}} {MEMORY[0]:.0e}' in text
    assert 'lumenwalk_worker_restarts_total{worker="0"} 0.0' in text


def test_what_was_counted_is_in_it(running: Running) -> None:
    running.service.metrics.refused("test")
    assert 'lumenwalk_refused_total{reason="test"} 1.0' in running.http.get("/metrics").text


def test_the_queue_is_counted_by_urgency(running: Running) -> None:
    slow = {"size": [8, 8], "settings": {"seed": SLOW_SEED}}
    with ThreadPoolExecutor(3) as pool:
        stills = [pool.submit(running.http.post, "/api/v1/render", json=slow) for _ in range(3)]
        while not re.search(r'lumenwalk_queue_jobs{urgency="still"} [12]', text := running.http.get("/metrics").text):
            assert not all(still.done() for still in stills)
    assert 'lumenwalk_queue_jobs{urgency="moving"} 0.0' in text
    assert 'lumenwalk_queue_jobs{urgency="still"} 0.0' in running.http.get("/metrics").text


def test_jobs_uploads_and_checks_are_counted(serve: Callable[..., Running]) -> None:
    running = serve()
    job = running.http.post("/api/v1/jobs", json={"size": [8, 8]}).json()
    assert running.http.get(f"{job['url']}/events").text.count("event: end") == 1
    assert running.http.post("/api/v1/scenes", params={"name": "house.glb"}, content=TRIANGLE_GLB).status_code == 201
    assert running.http.post("/api/v1/scenes", params={"name": "house.txt"}, content=b"").status_code == 422
    samples, text = scrape(running), running.http.get("/metrics").text
    assert (samples["lumenwalk_uploads_total"], samples["lumenwalk_jobs_waiting"]) == (1, 0)
    assert samples["lumenwalk_uploads_bytes"] == len(TRIANGLE_GLB)
    assert 'lumenwalk_jobs_total{state="done"} 1.0' in text
    assert 'lumenwalk_scene_checks_total{outcome="sound"} 1.0' in text
    assert 'lumenwalk_scene_checks_total{outcome="refused"} 0.0' in text
