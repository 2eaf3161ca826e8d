"""Child processes that run none of the code in the current folder, in PYTHONPATH or in the user's own packages.

`python -m` looks for modules in the current folder first, which may be a folder of scenes that others fill.
"""

import os
import sys
from pathlib import Path

# Isolated (-I), Python looks in its own folders only; this package may be elsewhere, and comes after them.
_RUN = (
    "import runpy, sys; root, module = sys.argv[1:3]; del sys.argv[1:3]; sys.path.append(root); "
    "runpy.run_module(module, run_name='__main__', alter_sys=True)"
)
_ROOT = Path(__file__).resolve().parents[1]
# What a child needs of its parent's environment; what is not here, such as a token, is not its business.
_KEPT = ("PATH", "HOME", "USER", "LANG", "LANGUAGE", "TZ", "TMPDIR", "LD_LIBRARY_PATH", "XDG_CACHE_HOME")
_KEPT_PREFIXES = ("LC_", "CUDA_", "NVIDIA_", "WARP_", "OMP_", "MALLOC_")


def module_command(module: str) -> tuple[str, ...]:
    """The command that runs a module of this project; arguments may follow."""
    return (sys.executable, "-I", "-c", _RUN, str(_ROOT), module)


def clean_environment() -> dict[str, str]:
    """What a child gets of this process's environment: where things are and how devices are used, and no secrets."""
    return {name: it for name, it in os.environ.items() if name in _KEPT or name.startswith(_KEPT_PREFIXES)}
