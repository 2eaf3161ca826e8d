from multiprocessing import Pipe
from pathlib import Path
from threading import Thread

from server.worker.compiler_process import work


def test_each_request_is_answered_and_the_end_of_the_connection_is_the_end(tmp_path: Path) -> None:
    ours, theirs = Pipe()
    working = Thread(target=work, args=(theirs,))
    working.start()
    (tmp_path / "right.cpp").write_text("int answer() { return 42; }\n")
    (tmp_path / "wrong.cpp").write_text("no code\n")
    for number, name in enumerate(("right", "wrong", "missing")):
        files = str(tmp_path / f"{name}.o"), str(tmp_path / f"{name}.cpp")
        ours.send((number, "build_cpu", files, {"use_precompiled_headers": False}))
    answers = dict(ours.recv() for _ in range(3))
    assert answers[0] is None
    assert (tmp_path / "right.o").exists()
    assert "build failed" in answers[1]
    assert "missing.cpp" in answers[2]
    ours.close()
    working.join(10.0)
    assert not working.is_alive()
