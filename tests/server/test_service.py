import asyncio

import pytest
from engines import BOX, FakeEngine, order

from server.jobs import JobState
from server.places import asker
from server.render.engine_pool import EnginePool
from server.scenes.catalogue import Catalogue
from server.scenes.checker import Checker
from server.service import OTHERS_VIEWERS, Service
from server.settings import ServerSettings

SETTINGS = ServerSettings(max_viewers=2, max_scenes=3, device="cpu")


@pytest.fixture
def engine() -> FakeEngine:
    return FakeEngine()


@pytest.fixture
def service(engine: FakeEngine) -> Service:
    return Service(SETTINGS, Catalogue("cornell-box", None, None), EnginePool([engine]), Checker(SETTINGS, ()))


def test_viewers_are_admitted_while_there_is_room_each_by_a_number_of_its_own(service: Service) -> None:
    first, second = service.admit(), service.admit()
    assert first is not None
    assert second is not None
    assert service.full
    assert service.admit() is None
    service.dismiss(first)
    assert service.admit() not in (None, first, second)


def test_each_run_has_a_name_of_its_own(service: Service) -> None:
    assert service.run != Service(SETTINGS, service.catalogue, service.engines, service.checker).run


@pytest.mark.parametrize(("client", "most"), [("192.0.2.1", 7), ("127.0.0.1", 8)])
def test_one_client_leaves_places_for_others_unless_it_speaks_for_them(
    engine: FakeEngine, client: str, most: int
) -> None:
    settings = SETTINGS.model_copy(update={"max_viewers": OTHERS_VIEWERS})
    catalogue, checker = Catalogue("cornell-box", None, None), Checker(settings, ())
    service = Service(settings, catalogue, EnginePool([engine]), checker)

    async def come(client: str) -> int | None:
        asker.set(client)
        return service.admit()

    here = [asyncio.run(come(client)) for _ in range(8)]
    assert len(here) - here.count(None) == most
    assert (asyncio.run(come("192.0.2.2")) is None) == (most == 8)


def test_the_worker_is_told_of_every_viewer_that_leaves(service: Service, engine: FakeEngine) -> None:
    viewer, job = service.admit(), service.number()
    assert viewer is not None
    service.viewing[viewer] = BOX
    service.dismiss(viewer)
    service.dismiss(job)
    assert engine.left == [viewer, job]
    assert service.viewing == {}


def test_a_scene_is_in_use_while_a_viewer_looks_at_it_or_a_job_is_to_render_it(service: Service) -> None:
    assert not service.in_use(BOX.id)
    service.viewing[1] = BOX
    assert service.in_use(BOX.id)
    service.dismiss(1)
    job = service.jobs.add(order(), 4, "image/png")
    assert service.in_use(BOX.id)
    assert not service.in_use("another")
    job.state = JobState.DONE
    assert not service.in_use(BOX.id)


def test_a_scene_is_in_use_while_it_is_loaded(service: Service, engine: FakeEngine) -> None:
    async def main() -> None:
        engine.gate = asyncio.Event()
        loading = asyncio.create_task(service.residency.open(BOX))
        await asyncio.sleep(0)
        assert service.in_use(BOX.id)
        engine.gate.set()
        await loading
        assert not service.in_use(BOX.id)

    asyncio.run(main())
