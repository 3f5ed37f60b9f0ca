"""The devices of the computer that `boot` makes, and the car of which they measure the rear axle."""

import pathlib
import socket
import struct
import subprocess
import threading
import time

MODULE_ID, RATE_HZ = 0x200, 1000
# The rear node has real devices: a CAN accelerometer module and a GPIO chip.
REAR_WIRING = f"""front_end = ["can:vx0", "gpio:gpiochip0"]
[[node.can]]
interface = "vx0"
role = "sensor"
accelerometer_id = {MODULE_ID}
[[node.line]]
line = 0
tooth_gpio = 3
zero_mark_gpio = 4
[[node.line]]
line = 1
tooth_gpio = 5
zero_mark_gpio = 6
"""


class Module(threading.Thread):
    """The CAN accelerometer module at the other end of the cable: firmware/backends/socketcan/ACCELEROMETER.md, CAN FD."""

    def __init__(self):
        super().__init__(daemon=True)
        self.socket = socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW)
        self.socket.setsockopt(socket.SOL_CAN_RAW, socket.CAN_RAW_FD_FRAMES, 1)
        self.socket.bind(("vx1",))

    def run(self):
        number, due = 0, time.monotonic()
        while True:
            data = struct.pack("<BBHI12h", 0x10, 0, 0, number & 0xFFFFFFFF, *[(number + 1000 * k) % 30000 for k in range(12)])
            self.socket.send(struct.pack("<IBBxx", MODULE_ID, len(data), 0) + data.ljust(64, b"\0"))
            number += 1
            due += 1.0 / RATE_HZ
            time.sleep(max(0.0, due - time.monotonic()))


def call(*words):
    subprocess.run(words, check=True)


def plug_devices():
    call("modprobe", "vxcan")
    call("modprobe", "can-raw")
    call("insmod", "/results/gpio-pulse.ko")
    call("ip", "link", "add", "vx0", "type", "vxcan", "peer", "name", "vx1")
    for end in ("vx0", "vx1"):
        call("ip", "link", "set", end, "mtu", "72", "up")
    Module().start()


def lines_are_held():
    """By the rear node, those that its vehicle file names."""
    return pathlib.Path("/sys/kernel/debug/gpio").read_text(encoding="utf-8").count("|roadbalance") == REAR_WIRING.count("_gpio = ")


def car(text):
    """That of the demonstration with these devices at its rear node."""
    front, rear = text.replace("\nrate_hz = 2000", f"\nrate_hz = {RATE_HZ}").split('name = "rear"')
    rear = rear.replace("[[node.channel]]", REAR_WIRING + "[[node.channel]]", 1)
    return front + 'name = "rear"' + rear
