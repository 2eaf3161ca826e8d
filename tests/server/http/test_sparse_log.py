import logging

import pytest

from server.http import sparse_log
from server.http.sparse_log import BURST, SparseLog, make_sparse


def test_few_records_pass_and_the_next_says_how_many_did_not() -> None:
    sparse = SparseLog()
    records = [logging.makeLogRecord({}) for _ in range(100)]
    assert sum(sparse.filter(record) for record in records) == BURST
    sparse._bucket._level = 1.0
    last = logging.makeLogRecord({})
    assert sparse.filter(last)
    assert vars(last)["left_out"] == 90


def test_a_logger_is_made_sparse_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sparse_log, "LOGGERS", ("lumenwalk.sparse_test",))
    make_sparse()
    make_sparse()
    assert len(logging.getLogger("lumenwalk.sparse_test").filters) == 1
