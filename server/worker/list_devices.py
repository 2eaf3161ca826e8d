"""`python -m server.worker.list_devices`: the names of all GPUs, a line each, or of the CPU where there is none."""

import warp as wp

from gpu.core.device import choose_device


def names() -> list[str]:
    """Of the devices that are worth a worker each."""
    return [device.alias for device in wp.get_cuda_devices()] or [choose_device("cpu").alias]


if __name__ == "__main__":
    print("\n".join(names()))
