import shutil
from pathlib import Path

import pytest

from gpu.errors import UserError
from server.worker.kernel_cache import LEAST_BYTES, check_kernel_cache, needs_kernel_cache


def test_a_folder_that_can_be_written_is_used(tmp_path: Path) -> None:
    check_kernel_cache(str(tmp_path))
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_cannot_be_written_is_named_in_one_sentence(tmp_path: Path) -> None:
    with pytest.raises(UserError, match=r"^kernel cache .*missing: cannot be written: No such file.*WARP_CACHE_PATH"):
        check_kernel_cache(str(tmp_path / "missing"))
    with pytest.raises(UserError, match=r"^kernel cache /proc/nope: cannot be made: "), needs_kernel_cache():
        Path("/proc/nope").mkdir()


@pytest.mark.parametrize(("free", "kernels", "enough"), [(0, 0, True), (1, 0, False), (1, 1, True)])
def test_a_full_folder_is_refused_unless_the_kernels_are_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, free: int, kernels: int, enough: bool
) -> None:
    usage = shutil.disk_usage(tmp_path)._replace(free=LEAST_BYTES - free)
    monkeypatch.setattr("server.worker.kernel_cache.shutil.disk_usage", lambda _: usage)
    for number in range(kernels):
        (tmp_path / f"{number}.meta").touch()
    if enough:
        check_kernel_cache(str(tmp_path))
        return
    with pytest.raises(UserError, match="67 MB free, 67 MB are needed"):
        check_kernel_cache(str(tmp_path))
