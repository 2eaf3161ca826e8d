import asyncio
from time import perf_counter

from server.wire.frame_header import Codec, FrameHeader
from tests.load.slow_line import line, report
from tests.load.viewer import Seen

WAY, RATE, ASKED = 0.02, 50_000.0, 5000


async def answer(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
    """Repeats what it is asked, ASKED times."""
    writer.write(ASKED * await reader.read(100))
    writer.close()


def test_bytes_take_their_time_and_their_way_and_all_come() -> None:
    async def ask() -> tuple[bytes, float]:
        server = await asyncio.start_server(answer, "127.0.0.1", 0)
        async with server, line(server.sockets[0].getsockname(), RATE, WAY) as url:
            reader, writer = await asyncio.open_connection("127.0.0.1", int(url.rpartition(":")[2]))
            began = perf_counter()
            writer.write(b"x")
            came = await reader.readexactly(ASKED)
            seconds = perf_counter() - began
            writer.close()
            return came, seconds

    came, seconds = asyncio.run(ask())
    assert came == ASKED * b"x"
    assert seconds > 2.0 * WAY + 0.9 * ASKED / RATE


def test_a_line_of_the_table_says_what_came() -> None:
    seen = [
        Seen(float(number), FrameHeader(8, 4, 1, number, 0, 0.0, 0.0, 0.0, {}, codec), 1000, 50.0 + number, None, None)
        for number, codec in enumerate((Codec.JPEG, Codec.H264_KEY, Codec.H264))
    ]
    assert report("both", seen, 2.0).split()[1:] == (
        ["1.5", "frames/s,", "2", "of", "3", "video,", "0.01", "Mbit/s,", "age", "51", "ms,", "p95", "52", "ms"]
    )
    assert "nan" in report("none", [], 2.0)
