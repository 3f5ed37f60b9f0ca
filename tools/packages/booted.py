#!/usr/bin/env python3
"""Tries the units where systemd is the first process, as they were installed; `boot` starts it in the computer it makes."""

import glob
import json
import os
import pathlib
import re
import signal
import subprocess
import sys
import threading
import time

from devices import RATE_HZ, car, lines_are_held, plug_devices

RESULTS = pathlib.Path("/results")
RECORDINGS = pathlib.Path("/var/lib/roadbalance/recordings")
SHARE = pathlib.Path("/usr/share/doc/roadbalance-tools")
VEHICLE = pathlib.Path("/etc/roadbalance/vehicle.toml")
HOST_UNITS = ("rb-recorder", "rb-analyser", "rb-recordings", "rb-web")
NODE_UNITS = ("rb-node@front", "rb-node@rear")
UNITS = HOST_UNITS + NODE_UNITS
BLOCK_SCANS = 20


def step(text):
    print(f"packages: booted: {time.monotonic():.0f} s: {text}", flush=True)


def run(*words, check=True):
    done = subprocess.run(words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if check and done.returncode:
        raise AssertionError(f"{' '.join(words)}: exit code {done.returncode}\n{done.stdout}")
    return done


def wait_for(what, condition, seconds=120.0):
    ends = time.monotonic() + seconds
    while not (found := condition()):
        assert time.monotonic() < ends, f"waited {seconds:.0f} s for: {what}"
        time.sleep(0.1)
    return found


def hand(does):
    """Has the host do what takes hands."""
    part = RESULTS / "hand.part"
    part.write_text(does)
    part.rename(RESULTS / "hand")
    wait_for(f"the hand that should {does}", lambda: not (RESULTS / "hand").exists())


def shown(unit, what):
    return run("systemctl", "show", "--value", "-p", what, unit).stdout.strip()


def main_pid(unit):
    return int(shown(unit, "MainPID"))


def journal(unit):
    return run("journalctl", "-q", "-o", "cat", "-b", "-u", unit).stdout


def all_active(units):
    return all(shown(unit, "ActiveState") == "active" for unit in units)


class Watch:
    """The last object that `rb watch --json` printed."""

    def __init__(self):
        self.last = {}
        self.process = subprocess.Popen(["rb", "watch", "--json"], stdout=subprocess.PIPE, text=True)
        threading.Thread(target=self.read, daemon=True).start()

    def read(self):
        for line in self.process.stdout:
            self.last = json.loads(line)

    def acknowledged(self):
        """At least so many samples of each node in its epoch it need not hold any more; the parts of what it tells may be
        some blocks apart."""
        return {(node["node"], node["epoch"]):
                node["samples"] - node["samples_missing"] - (node["blocks_held"] + 10) * BLOCK_SCANS
                for node in self.last.get("nodes", [])}

    def state(self):
        """Of the recorder that is there now."""
        recorders = self.last.get("recorders", [])
        return max(recorders, key=lambda each: each["incarnation"])["state"] if recorders else None


def typed(step_number):
    """What the guide has people type as root in that step."""
    page = (SHARE / "tools/guide/README.md").read_text(encoding="utf-8")
    part = re.search(rf"^## {step_number}\. .*?(?=^## )", page, re.M | re.S)[0]
    return re.findall(r"^    (sudo .*)$", part, re.M)


def opened(unit, path):
    """Whether a process of the unit may open a device: the kernel's filter is that of its control group."""
    group = "/sys/fs/cgroup" + shown(unit, "ControlGroup") + "/cgroup.procs"
    return run("sh", "-c", f"echo $$ >'{group}' && exec 3<'{path}'", check=False).returncode == 0


def devices_are_filtered():
    chip = glob.glob("/dev/gpiochip*")[0]
    usb = glob.glob("/dev/bus/usb/*/*")[0]
    disk = "/dev/vda"
    for unit, allowed, refused in ((NODE_UNITS[0], (chip, usb, "/dev/null"), (disk, "/dev/kmsg")),
                                   ("rb-recorder", (chip, "/dev/null"), (disk, usb, "/dev/kmsg")),
                                   ("rb-web", ("/dev/null",), (disk, usb, chip, "/dev/kmsg"))):
        for path in allowed + refused:
            assert opened(unit, path) == (path in allowed), f"{unit}: {path} is {'not ' * (path in allowed)}let in"


def types_step_5():
    text = (SHARE / "sim/demo/vehicle.toml").read_text(encoding="utf-8")
    pathlib.Path("car.toml").write_text(car(text), encoding="utf-8")
    VEHICLE.with_name("node-front.conf").write_text("RB_NODE_OPTIONS=--front-end sim:?seed=1\n")
    commands = "\n".join(typed(5) + ["sudo systemctl enable --now rb-node@rear"])
    run("bash", "-e", "-c", 'sudo() { "$@"; }\n' + commands)
    wait_for("all units to be active", lambda: all_active(UNITS))


def is_recorded(watch, seconds=2.0):
    """Waits until samples of both nodes are acknowledged that were measured from now on for so long."""
    begin = watch.acknowledged()

    def more():
        now = watch.acknowledged()
        return len(now) == 2 and all(samples - begin.get(key, 0) >= seconds * RATE_HZ for key, samples in now.items())

    wait_for("samples of both nodes to be acknowledged", more)


def start(name):
    wait_for(f"rb start {name}", lambda: run("rb", "start", name, check=False).returncode == 0)
    watch = Watch()
    is_recorded(watch)
    return watch


def stop(name, watch):
    """Ends a recording; what it holds is judged by `boot`.  The CAN module's frames may not all come: where a processor is
    emulated it is the kernel that has no time for them, and the node says so."""
    is_recorded(watch)
    watch.process.kill()
    stopped = run("rb", "stop", check=False)
    assert stopped.returncode in (0, 3), f"rb stop: exit code {stopped.returncode}\n{stopped.stdout}"
    verified = run("rb", "verify", str(RECORDINGS / name), check=False)
    assert verified.returncode == stopped.returncode, f"rb verify {name}: exit code {verified.returncode}\n{verified.stdout}"
    step(stopped.stdout.strip())


def kill_the_recorder():
    old = main_pid("rb-recorder")
    os.kill(old, signal.SIGKILL)
    begin = time.monotonic()
    wait_for("another recorder", lambda: main_pid("rb-recorder") not in (0, old))
    step(f"the recorder, killed, is there again after {time.monotonic() - begin:.1f} s")


def pull_the_stick(watch):
    stay = {unit: main_pid(unit) for unit in UNITS}
    hand("pull")
    wait_for("the recorder to miss its disk", lambda: watch.state() == "disk_failing")
    wait_for("the disk to be unmounted", lambda: not os.path.ismount(RECORDINGS))
    time.sleep(5.0)
    hand("plug")
    begin = time.monotonic()
    wait_for("the recorder to have its disk again", lambda: watch.state() == "recording")
    for unit, pid in stay.items():
        assert main_pid(unit) == pid, f"{unit} has ended\n{journal(unit)}"
    step(f"the stick, pulled, is recorded to again {time.monotonic() - begin:.1f} s after it was plugged in")


def upgrade():
    before = {unit: main_pid(unit) for unit in UNITS}
    said = run("sh", "-c", "dpkg -i /packages/next/*.deb").stdout
    wait_for("all units to be active", lambda: all_active(UNITS))
    for unit, pid in before.items():
        stays = unit == "rb-recorder" or unit in NODE_UNITS
        assert (main_pid(unit) == pid) == stays, f"{unit} {'began anew' if stays else 'is the old program'}"
    assert len(re.findall(r"^roadbalance-.*: .* go.* on as .*systemctl restart", said, re.M)) == 2, said
    step(run("dpkg-query", "-W", "-f", "${Package} ${Version}  ", "roadbalance-*").stdout)


def hang_the_node():
    unit = NODE_UNITS[0]
    old = main_pid(unit)
    os.kill(old, signal.SIGSTOP)
    begin = time.monotonic()
    wait_for("the watchdog", lambda: main_pid(unit) not in (0, old) and shown(unit, "ActiveState") == "active", 180.0)
    assert "watchdog" in journal(unit).lower(), journal(unit)
    step(f"a node that hangs is another one after {time.monotonic() - begin:.0f} s")


def first_time():
    assert run("systemctl", "is-system-running", "--wait", check=False).stdout.strip() == "running", run("systemctl", "--failed").stdout
    plug_devices()
    types_step_5()
    step("step 5 of the guide: all units are active")
    devices_are_filtered()
    wait_for("GPIO lines to be held", lines_are_held)
    step("each unit opens the devices that it is for, and no other")
    watch = start("killed_and_pulled")
    kill_the_recorder()
    is_recorded(watch)
    pull_the_stick(watch)
    stop("killed_and_pulled", watch)
    watch = start("upgraded")
    upgrade()
    stop("upgraded", watch)
    watch = start("hung")
    hang_the_node()
    stop("hung", watch)
    watch = start("cut")
    is_recorded(watch, 5.0)
    acknowledged = {f"{node} {epoch}": samples for (node, epoch), samples in watch.acknowledged().items()}
    (RESULTS / "acknowledged.json").write_text(json.dumps(acknowledged), encoding="utf-8")
    (RESULTS / "first_went_well").touch()
    step("the power is cut")
    hand("cut")


def second_time():
    wait_for("what needs no device to be active", lambda: all_active(HOST_UNITS + NODE_UNITS[:1]))
    plug_devices()
    wait_for("the node to find its devices", lambda: all_active(UNITS))
    watch = Watch()
    wait_for("the recording to go on", lambda: watch.state() == "recording")
    step("all units came with the computer, and go on with the recording")
    stop("cut", watch)
    begin = time.monotonic()
    run("systemctl", "stop", *UNITS)
    for unit in UNITS:
        assert shown(unit, "Result") == "success", f"{unit}: {shown(unit, 'Result')}\n{journal(unit)}"
    step(f"all units stop within {time.monotonic() - begin:.1f} s")
    run("systemctl", "start", *UNITS)
    removal()
    (RESULTS / "second_went_well").touch()


def removal():
    """Of packages whose units run."""
    run("dpkg", "--purge", *run("dpkg-query", "-W", "-f", "${Package} ", "roadbalance-*").stdout.split())
    left = [str(path) for folder in ("/usr", "/etc/systemd") for path in pathlib.Path(folder).rglob("*")
            if path.name.startswith("rb-") or "roadbalance" in path.name]
    assert not left, f"left behind: {left[:3]}"
    for unit in UNITS:
        assert shown(unit, "MainPID") in ("", "0"), f"{unit} is removed, and still runs"
    assert sorted(RECORDINGS.glob("*/seg-*.lcm")), "the recordings are gone"
    step("removed; the recordings stay")


def main():
    time_on = (RESULTS / "time_on").read_text(encoding="utf-8")
    up = float(pathlib.Path("/proc/uptime").read_text().split()[0])
    step(f"{run('systemctl', '--version').stdout.split(chr(10))[0]} is up after {up:.0f} s, the {time_on} time")
    {"first": first_time, "second": second_time}[time_on]()
    run("systemctl", "poweroff")


try:
    main()
except BaseException as error:
    print(f"packages: booted: {error}", run("journalctl", "-q", "-b", "-n", "80", "--no-hostname", "-u", "rb-*", check=False).stdout,
          run("systemctl", "--failed", "--no-legend", check=False).stdout, sep="\n", flush=True)
    run("systemctl", "poweroff", "--force")
    sys.exit(1)
