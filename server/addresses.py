"""Addresses of the web, each in one spelling, so that they can be compared: hosts, origins, networks, path prefixes."""

import re
from collections.abc import Collection
from ipaddress import IPv4Address, IPv6Address, ip_address, ip_network

DEFAULT_PORTS = {"http": 80, "https": 443}
# Of one viewer's network: with IPv6 a customer has at least that to choose addresses from (RFC 6177).
CLIENT_BITS = 64
MAX_PLACE = 300  # characters of host and port: names have up to 253 (RFC 1035), and the rest takes long to understand
_PLACE = re.compile(r"(?:\[([^\[\]]+)\]|([^\s/?#@:\[\]\\]+))(?::(\d{1,5}))?")
# Unreserved characters of RFC 3986, which mean the same in a path, a header, a cookie and HTML.
_PREFIX = re.compile(r"(/[A-Za-z0-9._~-]+)+")


def _address(text: str) -> IPv4Address | IPv6Address | None:
    """An IP address; the IPv4 one where IPv6 only carries it, as sockets for both kinds say it. None for a name."""
    try:
        address = ip_address(text)
    except ValueError:
        return None
    return getattr(address, "ipv4_mapped", None) or address


def plain_address(text: str) -> str:
    """An IP address in its usual spelling; what is none stays as it is."""
    return str(_address(text) or text)


def is_loopback(host: str) -> bool:
    """Whether a host name or address, without port, can only mean this machine."""
    address = _address(host)
    return address.is_loopback if address else host == "localhost" or host.endswith(".localhost")


def client_network(address: str) -> str:
    """What stands for one client where clients are counted: its address, or the network that it has of IPv6."""
    known = _address(address)
    if isinstance(known, IPv6Address):
        return str(ip_network(f"{known}/{CLIENT_BITS}", strict=False))
    return str(known or address)


def is_within(address: str, networks: Collection[str]) -> bool:
    """Whether an address is one of these, or of these networks, as `check_network` writes them."""
    known = _address(address)
    return known is not None and any(known in ip_network(network) for network in networks)


def _place(text: str) -> tuple[str, int | None] | None:
    """Host and port of `name:port` or `[IPv6]:port`; None when it is none."""
    match = _PLACE.fullmatch(text.lower()) if len(text) <= MAX_PLACE else None
    if match is None:
        return None
    address, name, port = match.groups()
    if address is not None:
        return (plain_address(address), int(port) if port else None) if _address(address) else None
    try:
        host = name if name.isascii() else name.encode("idna").decode()  # as browsers say it
    except UnicodeError:
        return None
    return plain_address(host), int(port) if port else None


def host_of(text: str) -> str | None:
    """The host of `name`, `name:port`, `[IPv6]:port` or a bare IPv6 address, in lower case; None when it is none."""
    if _address(text):
        return plain_address(text)
    place = _place(text)
    return place[0] if place else None


def origin_of(text: str) -> str | None:
    """`scheme://host[:port]` of an origin of HTTP, without its scheme's own port; None when it is none."""
    scheme, _, rest = text.partition("://")
    scheme, place = scheme.lower(), _place(rest)
    if scheme not in DEFAULT_PORTS or place is None:
        return None
    host, port = place
    shown = f"[{host}]" if ":" in host else host
    return f"{scheme}://{shown}" if port in (None, DEFAULT_PORTS[scheme]) else f"{scheme}://{shown}:{port}"


def check_host(text: str) -> str:
    """A host that this service is called by; ValueError when it is none."""
    host = host_of(text)
    if host is None:
        raise ValueError(f"{text!r} is no name of a host: write it as walk.example.org, 192.0.2.7 or 2001:db8::7")
    return host


def check_origin(text: str) -> str:
    """An origin that may use this service; ValueError when it is none."""
    origin = origin_of(text.removesuffix("/"))
    if origin is None:
        raise ValueError(f"{text!r} is no origin: write scheme, host and port of a page, as https://portal.example.org")
    return origin


def check_network(text: str) -> str:
    """An address, or a network of them; ValueError when it is none."""
    try:
        return str(ip_network(text, strict=False)) if "/" in text else str(ip_address(text))
    except ValueError:
        raise ValueError(f"{text!r} is no address: write it as 192.0.2.7, or a network as 172.16.0.0/12") from None


def replica_prefix(url: str) -> str:
    """The path prefix of a replica's address, as `check_replica` writes it."""
    return "/" + url.partition("://")[2].partition("/")[2]


def check_replica(text: str) -> str:
    """The address of a replica, `origin/prefix`; ValueError when it is none."""
    scheme, _, rest = text.partition("://")
    place, slash, path = rest.partition("/")
    origin = origin_of(f"{scheme}://{place}")
    prefix = check_prefix(slash + path)
    if origin is None or not prefix:
        raise ValueError(f"{text!r} is no replica: write its address with its path prefix, as http://10.0.0.2:8000/r/0")
    return origin + prefix


def check_prefix(text: str) -> str:
    """A path prefix as /walk, nothing for none; ValueError when it is none."""
    prefix = text.rstrip("/")
    if prefix and not (_PREFIX.fullmatch(prefix) and {".", ".."}.isdisjoint(prefix.split("/"))):
        raise ValueError(f"{text!r} is no path prefix: write it as /walk, of letters, digits and - . _ ~")
    return prefix
