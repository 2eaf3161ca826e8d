"""GET /metrics: what `Metrics` has counted, and the state of the service at that moment, as Prometheus reads it."""

from collections.abc import Iterator

from fastapi import APIRouter, Response
from fastapi.responses import PlainTextResponse
from prometheus_client import CONTENT_TYPE_LATEST, generate_latest
from prometheus_client.metrics_core import CounterMetricFamily, GaugeMetricFamily, Metric
from prometheus_client.registry import Collector

from server.errors import refusals
from server.jobs import ENDED
from server.render.schedule import Urgency
from server.service import Service, TheService

router = APIRouter()


class State(Collector):
    """What is not counted but read when asked for."""

    def __init__(self, service: Service) -> None:
        self._service = service

    def collect(self) -> Iterator[Metric]:
        """The gauges, and the engine's own counts."""
        service = self._service
        windows = service.metrics.windows
        yield GaugeMetricFamily("lumenwalk_viewers", "Viewers here.", len(service.viewers))
        yield GaugeMetricFamily("lumenwalk_stills_waiting", "Stills that wait for a turn.", service.stills.total)
        yield GaugeMetricFamily(
            "lumenwalk_window_frames", "Frames that all viewers together may have under way.", sum(windows.values())
        )
        queue = GaugeMetricFamily("lumenwalk_queue_jobs", "Jobs that wait for the device.", labels=["urgency"])
        for urgency in Urgency:
            queue.add_metric([urgency.name.lower()], service.engines.waiting[urgency])
        yield queue
        jobs = CounterMetricFamily("lumenwalk_jobs", "Render jobs that have ended.", labels=["state"])
        for state, ended in service.jobs.ended.items():
            jobs.add_metric([state], ended)
        yield jobs
        waiting = sum(job.state not in ENDED for job in service.jobs.all)
        yield GaugeMetricFamily("lumenwalk_jobs_waiting", "Render jobs that wait or run.", waiting)
        checks = CounterMetricFamily("lumenwalk_scene_checks", "Scene files that were read.", labels=["outcome"])
        for outcome, count in service.checker.outcomes.items():
            checks.add_metric([outcome], count)
        yield checks
        if (uploads := service.catalogue.uploads) is not None:
            yield CounterMetricFamily("lumenwalk_uploads", "Scenes that clients brought.", uploads.kept)
            held = sum(upload.bytes for upload in uploads.all.values())
            yield GaugeMetricFamily("lumenwalk_uploads_bytes", "Of uploads kept.", held)
        yield GaugeMetricFamily("lumenwalk_ready", "Whether frames can be had, 1 or 0.", float(service.engines.ready))
        yield CounterMetricFamily(
            "lumenwalk_engine_restarts", "Times that the renderer was started again.", service.engines.restarts
        )
        yield CounterMetricFamily(
            "lumenwalk_device_busy_seconds", "Device time used, heartbeats included.", service.engines.busy_seconds
        )
        yield from self._workers()
        used, total = service.engines.memory
        yield GaugeMetricFamily("lumenwalk_device_memory_used_bytes", "Memory of the devices in use.", used)
        yield GaugeMetricFamily("lumenwalk_device_memory_bytes", "All memory of the devices.", total)

    def _workers(self) -> Iterator[Metric]:
        """What of it is a worker's own, by its number in the settings, from 0."""
        label = ["worker"]
        ready = GaugeMetricFamily("lumenwalk_worker_ready", "Whether a worker takes jobs, 1 or 0.", labels=label)
        viewers = GaugeMetricFamily("lumenwalk_worker_viewers", "Viewers that a worker renders for.", labels=label)
        restarts = CounterMetricFamily("lumenwalk_worker_restarts", "Times that it was started again.", labels=label)
        busy = CounterMetricFamily("lumenwalk_worker_busy_seconds", "Device time that it used.", labels=label)
        memory = GaugeMetricFamily(
            "lumenwalk_worker_memory_used_bytes", "Memory of its device in use, by whomever.", labels=label
        )
        engines = self._service.engines
        for number, engine in enumerate(engines.engines):
            labels = [str(number)]
            ready.add_metric(labels, float(engine.ready))
            viewers.add_metric(labels, len(engines.clients_of(engine) & self._service.viewers.keys()))
            restarts.add_metric(labels, engine.restarts)
            busy.add_metric(labels, engine.busy_seconds)
            memory.add_metric(labels, engine.memory[0])
        yield from (ready, viewers, restarts, busy, memory)


@router.get(
    "/metrics",
    operation_id="readMetrics",
    response_class=PlainTextResponse,
    responses=refusals() | {200: {"description": "each metric with its type, a line of help and its values"}},
)
async def metrics(service: TheService) -> Response:
    """Counters, gauges and histograms in the text format of Prometheus."""
    return Response(generate_latest(service.metrics.registry), media_type=CONTENT_TYPE_LATEST)
