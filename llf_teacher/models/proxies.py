"""The proxies in the environment, by which the client asks: whether they can be used."""

import ipaddress
import os
import socket
from importlib.util import find_spec
from urllib.parse import SplitResult, urlsplit
from urllib.request import getproxies, proxy_bypass

_SCHEMES = ("http", "https", "socks5", "socks5h")
_SECONDS = 5.0  # to reach a proxy


def is_here(base_url: str) -> bool:
    """Whether an address is of this machine."""
    host = urlsplit(base_url).hostname or ""
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost" or host.endswith(".localhost")


def passes_proxies(base_url: str) -> bool:
    """Whether requests go to an address directly, whatever proxies the environment has."""
    return base_url.startswith("http:") and is_here(base_url)


def check_proxies(base_url: str) -> None:
    """Check that the client can use the proxies in the environment. No message shows the user and password of one.

    Raises:
        ValueError: a proxy is no address, is of an unknown kind, or needs a package that is not installed.
    """
    for name, proxy in {} if passes_proxies(base_url) else _proxies().items():
        try:
            _ = proxy.port
        except ValueError as error:
            raise ValueError(f"{_of(name, proxy)} is no address: {error}; correct or unset it") from None
        if proxy.scheme not in _SCHEMES:
            raise ValueError(f"{_of(name, proxy)} must begin with one of {', '.join(_SCHEMES)}; correct or unset it")
        if proxy.scheme.startswith("socks") and find_spec("socksio") is None:
            raise ValueError(f"{_of(name, proxy)} needs the package 'socksio'; run: pip install socksio, or unset it")


def reach_proxy(base_url: str) -> None:
    """Check that the proxy of an address, if it has one, can be used and answers.

    Raises:
        ValueError: it does not.
    """
    check_proxies(base_url)
    parts, proxies = urlsplit(base_url), _proxies()
    name = parts.scheme if parts.scheme in proxies else "all"
    if name not in proxies or passes_proxies(base_url) or proxy_bypass(parts.hostname or ""):
        return
    proxy = proxies[name]
    try:
        port = proxy.port or (443 if proxy.scheme == "https" else 1080 if proxy.scheme.startswith("socks") else 80)
        with socket.create_connection((proxy.hostname or "", port), _SECONDS):
            pass
    except (OSError, ValueError) as error:
        raise ValueError(
            f"{_of(name, proxy)} cannot be reached: {error}; start it, unset the variable, or name the endpoint's host "
            "in NO_PROXY"
        ) from None


def _proxies() -> dict[str, SplitResult]:
    found = {name: getproxies().get(name) for name in ("http", "https", "all")}
    return {name: _parts(name, url if "://" in url else f"http://{url}") for name, url in found.items() if url}


def _parts(name: str, url: str) -> SplitResult:
    try:
        parts = urlsplit(url)
        if "@" not in f"{parts.path}{parts.query}{parts.fragment}":
            return parts
        problem = "a user or password has one of /, ? and #, which are written %2F, %3F and %23"
    except ValueError:  # the message may quote the password
        problem = "its host is malformed"
    raise ValueError(f"the proxy ({_variables(name)}) is no address: {problem}; correct or unset it")


def _of(name: str, proxy: SplitResult) -> str:
    return f"the proxy {proxy.scheme}://{proxy.netloc.rpartition('@')[2]} ({_variables(name)})"


def _variables(name: str) -> str:
    return ", ".join(each for each in os.environ if each.lower() == f"{name}_proxy") or "of this system"
