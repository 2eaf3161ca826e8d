"""What is imported at once is not looked through for garbage."""

import gc

from server.importing import kept_imports


def test_nothing_imported_is_looked_through_for_garbage() -> None:
    before = gc.get_freeze_count()
    try:
        with kept_imports():
            assert not gc.isenabled()
            made = [[] for _ in range(1000)]
        assert gc.isenabled()
        assert gc.get_freeze_count() >= before + len(made)
    finally:
        gc.unfreeze()
