"""Addresses to listen at: HOST:PORT, and sockets bound to them."""

import errno
import os
import socket

from facetlog.errors import DeviceError, InputError

__all__ = ["bound", "host_and_port", "listener"]


def host_and_port(address: str, option: str) -> tuple[str, int]:
    """Host and port of `HOST:PORT` (port 0: any free one); InputError names the `option`.

    >>> host_and_port("127.0.0.1:8101", "--listen")
    ('127.0.0.1', 8101)
    """
    host, colon, port = address.rpartition(":")
    if not (host and colon and port.isascii() and port.isdigit() and int(port) <= 0xFFFF):
        raise InputError(f"{option} {address}: give HOST:PORT, as 127.0.0.1:8101")
    return host.strip("[]"), int(port)


def bound(error: OSError, address: str, option: str) -> DeviceError:
    """What to say where nothing can listen at an address."""
    if error.errno == errno.EADDRINUSE:
        return DeviceError(f"{address} is in use: end what listens there, or give another {option}")
    reason = os.strerror(error.errno) if error.errno else str(error)
    return DeviceError(f"{address}: nothing can listen there ({reason}): give another {option}")


def listener(address: str, option: str) -> socket.socket:
    """A socket that listens there and does not block; DeviceError if that cannot be."""
    host, port = host_and_port(address, option)
    try:
        family = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0][0]
        made = socket.create_server((host, port), family=family, backlog=2)
    except OSError as error:
        raise bound(error, address, option) from error
    made.setblocking(False)
    return made
