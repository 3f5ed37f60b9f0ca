"""A network of its own for what is measured: loopback only, as on a machine without a network card."""

import os
import subprocess
import sys

IN_IT = "RB_BENCH_NETWORK"
WITH_ROUTE = 'ip link set lo up && ip route add 224.0.0.0/4 dev lo && exec "$@"'


def own():
    """Starts this program again in such a network, where the kernel allows it: what a datagram costs, and how long one
    may be, else depends on the card that the route to the bus leads over, though nothing leaves it."""
    if os.environ.get(IN_IT):
        return
    alone = ["unshare", "-Urn", "sh", "-c", WITH_ROUTE, "sh"]
    try:
        if subprocess.run([*alone, "true"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL).returncode != 0:
            return
    except OSError:
        return
    os.environ[IN_IT] = "1"
    sys.stdout.flush()
    os.execvp(alone[0], [*alone, sys.executable, *sys.argv])


def told():
    return "a network of its own" if os.environ.get(IN_IT) else "the network of this machine"
