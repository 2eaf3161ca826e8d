"""Worker processes that misbehave, each in the way that its first argument names."""

import os
import socket
import sys
import time

from server.wire.browser import Bounds, SceneInfo
from server.wire.worker import (
    Done,
    Free,
    FromWorker,
    Holdings,
    Leave,
    Opened,
    Progress,
    Ready,
    Render,
    Start,
    ToWorker,
    pack,
    read,
)

NOTHING = Holdings(0, 0, ())
NO_SCENE = SceneInfo(id="", name="", cameras=(), bounds=Bounds(min=(0.0, 0.0, 0.0), max=(0.0, 0.0, 0.0)), triangles=0)


def main(way: str, connection: socket.socket) -> None:
    def say(message: FromWorker | ToWorker, payload: bytes = b"") -> None:
        connection.sendall(pack(message, payload))

    pipe = connection.makefile("rb")
    start, _ = read(pipe)
    assert isinstance(start, Start)
    match way:
        case "mute":
            time.sleep(3600)
        case "early-death":
            os._exit(3)
        case "garbage":
            connection.sendall(os.urandom(2**16))
        case "huge":
            connection.sendall(b"\xff\xff\xff\x00\xff\xff\xff\xff")
            while True:
                connection.sendall(bytes(2**20))
        case "flood":
            while True:
                say(Progress("still here", 0.5))
        case "early-answer":
            say(Free(1, 0.0, NOTHING))
        case "wrong-side":
            say(Leave(1))
    say(Ready("rogue", NOTHING))
    job, _ = read(pipe)
    assert isinstance(job, Render)
    done = Done(job.request, job.size, 0.0, 0.0, 1, 1, {}, {}, {})
    match way:
        case "ready-again":
            say(Ready("rogue", NOTHING))
        case "wrong-answer":
            say(Opened(job.request, NO_SCENE))
        case "other-size":
            say(Done(job.request, (2, 2), 0.0, 0.0, 1, 1, {}, {}, {}))
        case "large-image":
            say(done, bytes(2**20))
        case "answer-again":
            say(done)
            say(done)
    time.sleep(3600)


if __name__ == "__main__":
    with socket.socket(fileno=int(sys.argv[2])) as theirs:
        main(sys.argv[1], theirs)
