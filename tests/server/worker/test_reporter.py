import time

from harness import wait_for

from server.worker.reporter import Reporter


def test_quick_work_says_nothing() -> None:
    said: list[tuple[str, float]] = []
    report = Reporter(lambda *words: said.append(words), 0.05)
    report("reading", 0.0)
    report.end()
    time.sleep(0.1)
    assert said == []


def test_what_goes_on_when_the_quiet_time_is_over_is_said_then() -> None:
    said: list[tuple[str, float]] = []
    report = Reporter(lambda *words: said.append(words), 0.3)
    report("reading", 0.5)
    report("compiling", 2.0)
    wait_for(lambda: len(said) > 0)
    assert said == [("compiling", 1.0)]
    report("tracing", 0.5)
    wait_for(lambda: said[-1] == ("tracing", 0.5))
    report.end()


def test_what_was_said_when_the_quiet_time_was_over_is_not_said_again() -> None:
    said: list[tuple[str, float]] = []
    report = Reporter(lambda *words: said.append(words), 0.05)
    report("reading", 0.5)
    report._due = 0.0  # the next words come before the timer does
    report("compiling", 1.0)
    time.sleep(0.2)
    assert said == [("compiling", 1.0)]
    report.end()


def test_words_come_not_too_often_and_the_last_ones_come() -> None:
    said: list[tuple[str, float]] = []
    report = Reporter(lambda *words: said.append(words), 0.0)
    for step in range(1000):
        report("tracing", step / 1000)
    assert len(said) < 50
    wait_for(lambda: said[-1] == ("tracing", 0.999))
    report.end()
