import json
import signal
import subprocess
import sys
from pathlib import Path

import warp as wp

import gpu.core.compiler_process as compiler_process

JOB = {
    "architecture": 90,
    "suffix": "",
    "debug": False,
    "level": 3,
    "verify_fp": False,
    "fast_math": True,
    "fuse_fp": True,
    "lineinfo": False,
    "precompiled_headers": True,
}


def test_jobs_are_done_until_there_are_no_more_whatever_the_terminal_says(tmp_path: Path) -> None:
    source, out = tmp_path / "one.cu", tmp_path / "one.cubin"
    source.write_text('extern "C" __global__ void one(float* found) { found[0] = 1.0f; }')
    job = json.dumps(JOB | {"source": str(source), "out": str(out)}) + "\n"
    wp.init()
    library, headers = wp._src.context.runtime.core._name, Path(wp.__file__).parent / "native"
    command = (sys.executable, "-I", "-S", compiler_process.__file__, library, str(headers))
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdin is not None
        assert process.stdout is not None
        for _ in range(2):
            process.stdin.write(job)
            process.stdin.flush()
            assert process.stdout.readline() == "0\n"
            process.send_signal(signal.SIGINT)
        process.stdin.close()
        assert process.wait(30) == 0
    assert out.stat().st_size > 0
