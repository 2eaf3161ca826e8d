"""How long the page of a service takes to its first picture, on a line of so many Mbit/s and latencies [ms]:

python -m tests.browser.loading URL 20 0 60
"""

import sys
from collections.abc import Iterator
from contextlib import closing
from statistics import median
from typing import Any

from playwright.sync_api import Browser, BrowserContext, sync_playwright

from tests.browser.chromium import CHROMIUM, FLAGS

VISITS = 5


def loads(browser: Browser, url: str, rate: float, latency_ms: float) -> Iterator[tuple[str, float, int]]:
    """Of browsers that know nothing, on a line of `rate` [bytes/s]: which visit, its time [ms], its answers that were
    not kept.
    """
    for _ in range(VISITS):
        with closing(browser.new_context()) as context:
            for visit in ("first", "second"):
                yield visit, *_load(context, url, rate, latency_ms)


def _load(context: BrowserContext, url: str, rate: float, latency_ms: float) -> tuple[float, int]:
    page, answers, kept = context.new_page(), list[str](), set[str]()
    line = {"offline": False, "latency": latency_ms}
    line |= {"downloadThroughput": rate, "uploadThroughput": rate}
    session = context.new_cdp_session(page)
    session.send("Network.enable")
    session.send("Network.emulateNetworkConditions", line)
    session.on("Network.requestServedFromCache", lambda event: kept.add(event["requestId"]))
    session.on("Network.responseReceived", lambda event: answers.append(_came(event)))
    page.goto(url, wait_until="commit")
    page.locator("body[data-picture]").wait_for(state="attached")
    milliseconds: float = page.evaluate("performance.now()")
    page.close()
    return milliseconds, len({answer for answer in answers if answer} - kept)


def _came(event: dict[str, Any]) -> str:
    """The id of a request that a service has answered; "" where the browser had that itself."""
    answer = event["response"]
    return "" if answer.get("fromDiskCache") or not answer["url"].startswith("http") else event["requestId"]


def main() -> None:
    """Print a line for each latency [ms] and visit."""
    url, rate, *latencies = sys.argv[1:]
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=list(FLAGS))
        for latency in map(float, latencies):
            found = [*loads(browser, url, float(rate) * 1e6 / 8, latency)]
            for visit in ("first", "second"):
                times = [time for name, time, _ in found if name == visit]
                answers = max(count for name, _, count in found if name == visit)
                print(f"{latency:g} ms, {visit} visit: {median(times):.0f} ms, {answers} answers")
        browser.close()


if __name__ == "__main__":
    main()
