"""The devices that a service was told to render on, by name, each of which gets a worker."""

import subprocess

from gpu.child_process import clean_environment, module_command
from gpu.errors import UserError

ALL = "all"
LIST = module_command("server.worker.list_devices")
LIST_SECONDS = 60.0  # that a list may take: what is asked has to be imported


def chosen_devices(device: str | None) -> tuple[str | None, ...]:
    """The names in `device`, comma-separated; "all": of every GPU, or of the CPU where there is none; None: the best.

    A name that is given twice is two workers on that device. UserError for a list with an empty name, and where the
    devices cannot be listed.
    """
    if device is None:
        return (None,)
    if device == ALL:
        return _all()
    names = tuple(name.strip() for name in device.split(","))
    if not all(names):
        raise UserError(f'device: {device!r} has an empty name; name devices as in "cuda:0,cuda:1", or say "{ALL}"')
    if ALL in names:
        raise UserError(f'device: {device!r} names devices beside "{ALL}", which has them all; leave one away')
    return names


def _all() -> tuple[str, ...]:
    # In a process of its own: this one never touches CUDA.
    try:
        said = subprocess.run(
            LIST, stdout=subprocess.PIPE, env=clean_environment(), timeout=LIST_SECONDS, check=True, text=True
        )
    except (OSError, subprocess.SubprocessError) as error:
        raise UserError(f"device: the devices of this machine cannot be listed: {error}; name them instead") from None
    return tuple(said.stdout.split())
