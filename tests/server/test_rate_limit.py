import pytest

from server.rate_limit import MAX_REMEMBERED, Bucket, Buckets


class Clock:
    """Time that a test lets pass."""

    def __init__(self) -> None:
        self.seconds = 0.0

    def __call__(self) -> float:
        return self.seconds


def test_a_burst_then_the_rate() -> None:
    clock = Clock()
    bucket = Bucket(rate=10.0, burst=3.0, now=clock)
    assert [bucket.take() for _ in range(3)] == [0.0, 0.0, 0.0]
    assert [bucket.take(), bucket.take()] == pytest.approx([0.1, 0.2])
    clock.seconds = 0.2
    assert bucket.take() == pytest.approx(0.1)


def test_it_holds_no_more_than_the_burst() -> None:
    clock = Clock()
    bucket = Bucket(rate=10.0, burst=2.0, now=clock)
    clock.seconds = 100.0
    assert [bucket.spend(), bucket.spend(), bucket.spend()] == [True, True, False]
    clock.seconds += 0.125
    assert bucket.spend()
    assert not bucket.spend()


def test_each_key_has_a_bucket() -> None:
    clock = Clock()
    buckets = Buckets(rate=1.0, burst=2.0, now=clock)
    buckets.take("a")
    buckets.take("a")
    assert buckets.empty("a")
    assert not buckets.empty("b")
    clock.seconds = 1.0
    assert not buckets.empty("a")


def test_an_attack_from_everywhere_takes_no_memory_nor_looks_at_all_of_it_each_time() -> None:
    looks = 0

    def clock() -> float:
        nonlocal looks
        looks += 1
        return 0.0

    buckets = Buckets(rate=1.0, burst=1.0, now=clock)
    for number in range(MAX_REMEMBERED):
        buckets.take(number)
    buckets.take(0)
    looks = 0
    for number in range(MAX_REMEMBERED, MAX_REMEMBERED + 5):
        buckets.take(number)
    assert looks < 50
    assert len(buckets._buckets) == MAX_REMEMBERED
    assert buckets.empty(MAX_REMEMBERED + 4)
    assert buckets.empty(0)  # of which something was taken since
    assert not buckets.empty(1)
