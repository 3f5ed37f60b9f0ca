"""Buses for programs that Python starts."""

import os


def bus_url():
    """A bus of this process's own, as process_port() has it (common/bus/process_port.hpp): only the port isolates."""
    return f"udpm://239.255.76.67:{12_000 + os.getpid() % 20_000}?ttl=0"
