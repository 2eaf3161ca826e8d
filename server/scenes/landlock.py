"""Landlock: this process and its children open nothing but the files that it names (man landlock, Linux 5.13)."""

import ctypes
import os
from collections.abc import Iterable
from pathlib import Path
from stat import S_ISDIR

from server.scenes.kernel import PR_SET_NO_NEW_PRIVS, machine, process_control, system_call

_CREATE_RULESET, _ADD_RULE, _RESTRICT_SELF = 444, 445, 446  # on every kind of machine
_VERSION, _PATH_BENEATH = 1, 1
_EXECUTE, _WRITE_FILE, _READ_FILE, _READ_DIR, _TRUNCATE, _IOCTL = 1 << 0, 1 << 1, 1 << 2, 1 << 3, 1 << 14, 1 << 15
_OF_FILES = _EXECUTE | _WRITE_FILE | _READ_FILE | _TRUNCATE | _IOCTL
READ = _READ_FILE | _READ_DIR
LIST = _READ_DIR
RUN = READ | _EXECUTE
# Of what is done to files, the last right that each version knows, from 1; from 5 on none was added.
_LAST_RIGHT = {1: 12, 2: 13, 3: 14, 4: 14}
_LAST_RIGHT_NOW = 15
_TCP, _TCP_VERSION = 0b11, 4  # bind and connect
_SCOPES, _SCOPES_VERSION = 0b11, 6  # abstract sockets and signals


class _Ruleset(ctypes.Structure):
    _fields_ = (("files", ctypes.c_uint64), ("net", ctypes.c_uint64), ("scoped", ctypes.c_uint64))


class _PathBeneath(ctypes.Structure):
    _pack_ = 1
    _fields_ = (("allowed", ctypes.c_uint64), ("parent", ctypes.c_int32))


def version() -> int:
    """What this kernel knows of it; 0 where it does not."""
    try:
        return system_call(_CREATE_RULESET, None, 0, _VERSION) if machine() else 0
    except OSError:
        return 0


def restrict(paths: Iterable[tuple[Path, int]], everything: Iterable[Path] = ()) -> bool:
    """From now on this thread and what it starts may do to paths, and below them, only what is said, and use no TCP.

    paths: with READ, LIST or RUN; those that do not exist are left out. everything: folders in which all is allowed.
    False where the kernel cannot: nothing has changed then.
    """
    known = version()
    if not known:
        return False
    handled = (1 << (_LAST_RIGHT.get(known, _LAST_RIGHT_NOW) + 1)) - 1
    rules = _Ruleset(handled, _TCP if known >= _TCP_VERSION else 0, _SCOPES if known >= _SCOPES_VERSION else 0)
    size = 8 if known < _TCP_VERSION else 16 if known < _SCOPES_VERSION else 24
    try:
        ruleset = system_call(_CREATE_RULESET, ctypes.byref(rules), size, 0)
    except OSError:
        return False
    try:
        for path, allowed in (*paths, *((path, handled) for path in everything)):
            _allow(ruleset, path, allowed & handled)
        process_control(PR_SET_NO_NEW_PRIVS, 1)
        system_call(_RESTRICT_SELF, ruleset, 0)
    except OSError:
        return False
    finally:
        os.close(ruleset)
    return True


def _allow(ruleset: int, path: Path, allowed: int) -> None:
    try:
        parent = os.open(path, os.O_PATH | os.O_CLOEXEC)
    except (OSError, ValueError):
        return
    try:
        if not S_ISDIR(os.fstat(parent).st_mode):
            allowed &= _OF_FILES
        if allowed:
            system_call(_ADD_RULE, ruleset, _PATH_BENEATH, ctypes.byref(_PathBeneath(allowed, parent)), 0)
    finally:
        os.close(parent)
