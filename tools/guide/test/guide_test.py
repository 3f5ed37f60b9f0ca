"""The guide, typed word by word by a new user on the simulated car, leads to balanced wheels."""

import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import tomllib
import unittest
from cmath import exp
from math import radians

SOURCE = pathlib.Path(os.environ["RB_SOURCE"])
BIN = pathlib.Path(os.environ["RB_BIN"])
GUIDE = SOURCE / "tools" / "guide"
SHOP_G = 7.0  # what vehicle.toml takes where it has no shop_g
VEHICLE = tomllib.loads((SOURCE / "sim" / "demo" / "vehicle.toml").read_text())
RADIUS_M = {wheel["name"]: wheel["weight_radius_m"] for wheel in VEHICLE["wheel"]}


def commands():
    """Every line to type, in the order of the page."""
    return "\n".join(re.findall(r"^```sh\n(.*?)^```$", (GUIDE / "README.md").read_text(), re.S | re.M))


def unbalance_g(scenario):
    """What the car has, weights on it included: grams at the weights' radius, complex, by wheel."""
    truth = {}
    for mass in tomllib.loads(scenario.read_text())["unbalance"]:
        radius_m = RADIUS_M[mass["wheel"]]
        moment = mass["mass_g"] * mass.get("radius_m", radius_m) / radius_m
        truth[mass["wheel"]] = truth.get(mass["wheel"], 0) + moment * exp(1j * radians(mass["angle_deg"]))
    return truth


class Guide(unittest.TestCase):
    def test_leads_to_balanced_wheels(self):
        with tempfile.TemporaryDirectory() as folder:
            folder = pathlib.Path(folder)
            # A network of its own, as a laptop's without cable: on the usual port nobody else is heard.
            script = ("ip link set lo up\nip route add 224.0.0.0/4 dev lo\n"
                      "trap 'echo \"ended with $?: $BASH_COMMAND\"' ERR\ntrap '[ ! -f car.pids ] || car off' EXIT\n" + commands())
            done = subprocess.run(["unshare", "--net", "bash", "-c", script], cwd=folder, capture_output=True, text=True,
                                  env=dict(os.environ, RB_SHARE=SOURCE / "sim" / "demo",
                                           PATH=f"{GUIDE}:{BIN}:{os.environ['PATH']}"))
            said = done.stdout + done.stderr
            self.assertEqual(re.findall("^ended with .*$", said, re.M), ["ended with 1: rb watch --seconds 4"], said)
            before = unbalance_g(SOURCE / "sim" / "demo" / "scenario.toml")
            after = unbalance_g(folder / "scenario.toml")
            for wheel, left in before.items():
                self.assertGreater(abs(left), SHOP_G, wheel)
                self.assertLess(abs(after[wheel]), 2.0, f"{wheel}: {said}")
            self.assertNotIn(" lost, ", said.replace(" 0 lost, ", ""))
            self.assertIn("http://127.0.0.1:", said)
            self.assertIn("</html>", (folder / "balance.html").read_text())
            plan = json.loads((folder / "plan.json").read_text())
            self.assertEqual({wheel["name"] for wheel in plan["compensation"]}, set(before))

    def test_the_car_says_what_is_wrong(self):
        with tempfile.TemporaryDirectory() as folder:
            plan = pathlib.Path(folder, "plan.json")
            step = {"action": "add", "mass_g": 5, "angle_deg": 0, "radius_m": 0.19}
            plan.write_text(json.dumps({"compensation": [{"name": "front_left", "steps": [step]},
                                                         {"name": "rear_left", "steps": [step | {"action": "move"}]}]}))
            pathlib.Path(folder, "scenario.toml").write_text("")
            pathlib.Path(folder, "car.toml").write_text("name = 3\n")
            for arguments, words in ((["off"], "not on"), (["weights"], "which plan"), (["fly"], "on | off"),
                                     (["weights", plan], "rear_left: move"), (["on"], "car.toml"),
                                     (["weights", "no.json"], "no.json: there is no such file")):
                done = subprocess.run(["unshare", "--net", "sh", "-c", 'ip link set lo up; ip route add 224.0.0.0/4 dev lo; "$@"',
                                       "sh", GUIDE / "car", *arguments], cwd=folder, capture_output=True, text=True,
                                      env=dict(os.environ, PATH=f"{BIN}:{os.environ['PATH']}"), timeout=60)
                self.assertNotEqual(done.returncode, 0)
                self.assertIn(words, done.stdout + done.stderr)
            self.assertEqual(pathlib.Path(folder, "scenario.toml").read_text(), "")
            self.assertFalse(pathlib.Path(folder, "car.pids").exists())

    def test_the_car_takes_weights_once(self):
        with tempfile.TemporaryDirectory() as folder:
            folder = pathlib.Path(folder)
            step = {"action": "add", "mass_g": 5, "angle_deg": 0, "radius_m": 0.19}
            (folder / "plan.json").write_text(json.dumps({"compensation": [{"name": "front_left", "steps": [step]}]}))
            (folder / "scenario.toml").write_text("")
            codes = [subprocess.run([GUIDE / "car", "weights", "plan.json"], cwd=folder, capture_output=True).returncode for _ in range(2)]
            self.assertEqual(codes, [0, 2])
            self.assertEqual(len(tomllib.loads((folder / "scenario.toml").read_text())["unbalance"]), 1)

    def test_its_commands_are_there_and_say_what_it_quotes(self):
        page = (GUIDE / "README.md").read_text()
        for command in set(re.findall(r"`(rb [a-z]+(?: [a-z]+)?)", page)):
            words = command.split()[1:]
            done = subprocess.run([BIN / "rb", *words, "--help"], capture_output=True, text=True)
            self.assertEqual(done.returncode, 0, command)
        sources = "".join(p.read_text() for p in (SOURCE / "host" / "analysis").rglob("*.cpp"))
        for words in re.findall(r'^\| "([^"]+)"', page, re.M):
            self.assertIn(words, sources)


if __name__ == "__main__":
    if os.geteuid() != 0:
        print("[  SKIPPED ] Guide (root makes a network of its own)")
        sys.exit(0)
    unittest.main()
