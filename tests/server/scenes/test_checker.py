import asyncio
import sys
from pathlib import Path

import pytest
from glb_file import TRIANGLE_GLB

from gpu.errors import SceneError
from server.places import asker
from server.refusals import TooBusyError
from server.scenes.checker import AT_ONCE, MAX_WAITING, MAX_WAITING_OF_ONE, Checker
from server.settings import ServerSettings


def child(script: str) -> tuple[str, ...]:
    """A command that runs this instead of the checker."""
    return (sys.executable, "-c", script)


def refusal(checker: Checker) -> str:
    with pytest.raises(SceneError) as caught:
        asyncio.run(checker.check("/private/house.glb", "house.glb"))
    return str(caught.value)


def test_a_scene_is_read_by_a_child_and_has_its_name_not_its_path(tmp_path: Path) -> None:
    (tmp_path / "secret.glb").write_bytes(TRIANGLE_GLB)
    checked = asyncio.run(Checker(ServerSettings()).check(str(tmp_path / "secret.glb"), "rooms/house.glb"))
    assert (checked.info.id, checked.info.name, checked.info.triangles) == ("rooms/house.glb", "house", 1)


@pytest.mark.parametrize("environment", [None, Path("noon.hdr")])
def test_a_scene_is_described_in_the_environment_that_is_around_all_scenes(
    tmp_path: Path, environment: Path | None
) -> None:
    """Nothing is said to be added for want of light, and there is a sky that edits can name."""
    (tmp_path / "dark.glb").write_bytes(TRIANGLE_GLB)
    checker = Checker(ServerSettings(environment=environment))
    info = asyncio.run(checker.check(str(tmp_path / "dark.glb"), "dark.glb")).info
    assert [light.id for light in info.lights if not light.added] == ["sky"]
    assert any("soft sky" in note for note in info.notes) == (environment is None)


def test_what_is_wrong_is_said_of_the_name_not_of_the_path(tmp_path: Path) -> None:
    (tmp_path / "secret.glb").write_bytes(TRIANGLE_GLB[:-8])
    with pytest.raises(SceneError, match=r"^house\.glb: GLB header: the file has .* it is cut off$"):
        asyncio.run(Checker(ServerSettings()).check(str(tmp_path / "secret.glb"), "house.glb"))


def test_a_child_that_takes_too_long_is_killed() -> None:
    checker = Checker(ServerSettings(check_seconds=0.5), child("import time; time.sleep(60)"))
    assert refusal(checker) == (
        "house.glb: takes more than 0.5 s to read; simplify it, or raise check_seconds of this server"
    )


@pytest.mark.parametrize(
    ("script", "says"),
    [
        ("import os; os.abort()", "its reader ended with SIGABRT"),
        ("import os, signal; os.kill(os.getpid(), signal.SIGSEGV)", "its reader ended with SIGSEGV"),
        ("raise SystemExit(3)", "its reader ended with status 3"),
        ("print('not an answer')", "its reader ended with status 0"),
        ("import os; os.close(0); print('not an answer')", "its reader ended with status 0"),
        ("import sys\nwhile True: sys.stdout.write('{' * 65_536)", "its reader says more than there is"),
        ("import os, signal; os.kill(os.getpid(), signal.SIGXCPU)", "takes more than 25 s"),
        ("import os, signal; os.kill(os.getpid(), signal.SIGKILL)", "killed by the system, which ran out of memory"),
        ("import resource as r; r.setrlimit(r.RLIMIT_CPU, (1, 2))\nwhile True: pass", "takes more than 25 s"),
    ],
)
def test_a_child_that_dies_or_talks_nonsense_is_an_error(script: str, says: str) -> None:
    assert says in refusal(Checker(ServerSettings(), child(script)))


def test_a_child_that_has_far_more_to_say_is_no_longer_waited_for() -> None:
    script = "import fcntl as f\nf.fcntl(1, f.F_SETPIPE_SZ, 2**20)\nwhile True: print('{' * 2**20)"
    assert "its reader says more than there is" in refusal(Checker(ServerSettings(), child(script)))


@pytest.mark.parametrize("stays", ["os.fork()", "os.fork() and os._exit(0)"])
def test_what_a_child_has_started_ends_with_it(stays: str) -> None:
    script = f"import os, time\n{stays}\ntime.sleep(3600)"
    assert "takes more than 1 s" in refusal(Checker(ServerSettings(check_seconds=1), child(script)))


def test_a_child_knows_no_secrets_of_the_environment(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LUMENWALK_SECRET", "x")
    checker = Checker(ServerSettings(), child("import os; os.environ.get('LUMENWALK_SECRET') and exit(9)"))
    assert "status 0" in refusal(checker)


def test_few_run_at_once_and_too_many_are_turned_away(tmp_path: Path) -> None:
    script = "import os, sys, time; open(sys.argv[1] + str(os.getpid()), 'x').close(); time.sleep(60)"
    checker = Checker(ServerSettings(check_seconds=60), (*child(script), f"{tmp_path}/"))

    async def ask(client: str) -> None:
        asker.set(client)
        await checker.check("x", "x")

    async def running(count: int) -> None:
        while len(list(tmp_path.iterdir())) < count:
            await asyncio.sleep(0.01)

    async def crowd() -> None:
        checks = [asyncio.create_task(ask("a")) for _ in range(MAX_WAITING_OF_ONE)]
        await running(AT_ONCE)
        with pytest.raises(TooBusyError, match="too many scenes"):
            await asyncio.create_task(ask("a"))
        checks += [asyncio.create_task(ask("b")) for _ in range(MAX_WAITING - MAX_WAITING_OF_ONE)]
        await asyncio.sleep(0)
        with pytest.raises(TooBusyError, match="too many scenes"):
            await asyncio.create_task(ask("c"))
        assert len(list(tmp_path.iterdir())) == AT_ONCE == 2
        for check in checks:
            check.cancel()
        await asyncio.wait(checks)

    asyncio.run(crowd())
