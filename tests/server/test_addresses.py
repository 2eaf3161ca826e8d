from collections.abc import Callable
from time import thread_time

import pytest

from server.addresses import (
    check_host,
    check_network,
    check_origin,
    check_prefix,
    check_replica,
    client_network,
    host_of,
    is_loopback,
    origin_of,
    plain_address,
)


@pytest.mark.parametrize(
    ("host", "expected"),
    [
        *[(host, True) for host in ("localhost", "a.localhost", "127.8.9.1", "::1", "::ffff:127.0.0.1")],
        *[(host, False) for host in ("0.0.0.0", "::", "pc", "127.0.0.1.example", "::ffff:192.0.2.1")],
    ],
)
def test_loopback(host: str, expected: bool) -> None:
    assert is_loopback(host) is expected


def test_an_address_has_one_spelling() -> None:
    assert plain_address("::ffff:192.0.2.7") == "192.0.2.7"  # as a socket for IPv6 and IPv4 says it
    assert plain_address("2001:0DB8::0007") == "2001:db8::7"
    assert plain_address("unix:") == "unix:"


def test_what_is_too_long_for_a_name_is_none_whatever_it_takes_to_spell() -> None:
    began = thread_time()
    for text in ("ü" * 50_000, "ü." * 25_000, "http://" + "ü" * 50_000):
        assert host_of(text) is origin_of(text) is None
    assert thread_time() - began < 0.1  # one alone would take longer


def test_clients_of_ipv6_are_counted_by_their_network() -> None:
    assert client_network("2001:db8::7") == client_network("2001:db8::ffff:1:2") == "2001:db8::/64"
    assert client_network("2001:db8:0:1::7") != client_network("2001:db8::7")
    assert client_network("192.0.2.7") == client_network("::ffff:192.0.2.7") == "192.0.2.7"
    assert client_network("") == ""


@pytest.mark.parametrize(
    ("text", "host"),
    [
        ("Walk.example.org:8443", "walk.example.org"),
        ("192.0.2.7:80", "192.0.2.7"),
        ("[2001:DB8::7]:8000", "2001:db8::7"),
        ("2001:db8::7", "2001:db8::7"),
        ("bücher.example", "xn--bcher-kva.example"),
        *[(text, None) for text in ("", ":80", "[", "a:b", "a/b", "user@a", "a?b", "[::1]x:80")],
    ],
)
def test_hosts(text: str, host: str | None) -> None:
    assert host_of(text) == host


@pytest.mark.parametrize(
    ("text", "origin"),
    [
        ("HTTPS://Portal.example.org", "https://portal.example.org"),
        ("https://portal.example.org:443", "https://portal.example.org"),
        ("http://portal.example.org:443", "http://portal.example.org:443"),
        ("http://[::1]:8000", "http://[::1]:8000"),
        ("http://[0:0::1]:80", "http://[::1]"),
        *[(text, None) for text in ("null", "", "*", "portal.example.org", "file://", "https://a/b", "http://::1")],
        *[(text, None) for text in ("ftp://a", "https://a:x", "https://u@a", "https://a:999999")],
    ],
)
def test_origins(text: str, origin: str | None) -> None:
    assert origin_of(text) == origin


@pytest.mark.parametrize(
    ("check", "text", "expected"),
    [
        (check_host, "walk.example.org:80", "walk.example.org"),
        (check_origin, "https://portal.example.org/", "https://portal.example.org"),
        (check_network, "172.16.0.1/12", "172.16.0.0/12"),
        (check_network, "2001:0db8::7", "2001:db8::7"),
        (check_replica, "HTTP://10.0.0.2:80/r/0/", "http://10.0.0.2/r/0"),
        (check_replica, "https://lumenwalk-0.walk:8000/r/a", "https://lumenwalk-0.walk:8000/r/a"),
        (check_prefix, "/walk/", "/walk"),
        (check_prefix, "/a/b-c_d.e", "/a/b-c_d.e"),
        (check_prefix, "/", ""),
        (check_prefix, "", ""),
    ],
)
def test_what_an_operator_writes(check: Callable[[str], str], text: str, expected: str) -> None:
    assert check(text) == expected


@pytest.mark.parametrize(
    ("check", "texts", "words"),
    [
        (check_host, ("https://walk.example.org", "a b", ""), "no name of a host"),
        (
            check_replica,
            ("http://10.0.0.2:8000", "http://10.0.0.2:8000/", "10.0.0.2/r/0", "file:///r/0", "http://me:key@a/r/0"),
            "no replica",
        ),
        (check_replica, ("http://a/r/0?x", "http://a/r/../0", "http://a/r/0#x"), "no path prefix"),
        (check_origin, ("portal.example.org", "*", "https://portal.example.org/page"), "no origin"),
        (check_network, ("*", "proxy.example.org", "10.0.0.0/40"), "no address"),
        (
            check_prefix,
            ("walk", "//evil.example", "/a/../b", "/a b", "/ä", '/"x', "/a//b", "https://a/b"),
            "no path prefix",
        ),
    ],
)
def test_what_makes_no_sense_is_said(check: Callable[[str], str], texts: tuple[str, ...], words: str) -> None:
    for text in texts:
        with pytest.raises(ValueError, match=words):
            check(text)
