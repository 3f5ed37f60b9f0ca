"""Whole programs that tools/bench/run measures."""

import json
import subprocess

from row import BIN, ROOT


def demo(seconds, vehicle, *more):
    told = subprocess.run(
        [BIN / "rb", "demo", "--headless", "--json", "--seed", "1", "--drive-seconds", str(seconds), "--rate", "max",
         "--vehicle", ROOT / vehicle, *more], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, check=False)
    if told.returncode not in (0, 1):  # 1: no wheel was identified, on a short drive
        raise RuntimeError(f"rb demo ends with {told.returncode}")
    return json.loads(told.stdout)
