"""Plants violations into small trees and looks whether the checker finds them, and nothing else."""

import pathlib
import subprocess
import sys
import tempfile
import unittest

CHECKER = pathlib.Path(__file__).with_name("check_layering.py")


def run(files):
    """Exit code and output of the checker on a tree of {path: text}."""
    with tempfile.TemporaryDirectory() as root:
        for path, text in files.items():
            file = pathlib.Path(root, path)
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text, encoding="utf-8")
        done = subprocess.run([sys.executable, CHECKER, root], capture_output=True, text=True, check=False)
        return done.returncode, done.stdout


class CheckLayering(unittest.TestCase):
    def accepts(self, path, text):
        self.assertEqual(run({path: text}), (0, ""))

    def refuses(self, path, text, line, words):
        code, output = run({path: text})
        self.assertEqual(code, 1, output)
        self.assertIn(f"{path}:{line}: ", output)
        self.assertIn(words, output)
        self.assertEqual(output.count("\n"), 1, output)

    def test_rooms_do_not_know_each_other(self):
        for room, other in [("firmware", "host"), ("firmware", "sim"), ("host", "firmware"), ("host", "sim"),
                            ("sim", "host"), ("sim", "firmware"), ("common", "sim"), ("common", "host"),
                            ("common", "firmware"), ("host", "tools"), ("sim", "hil_tests")]:
            text = f'// first\n#include "{other}/car.hpp"\n'
            self.refuses(f"{room}/a/thing.cpp", text, 2, f"{room} must not know {other}")
            self.refuses(f"{room}/thing.hpp", text, 2, f"{room} must not know {other}")
            self.refuses(f"{room}/thing.cpp", f"# include <{other}/car.hpp>", 1, f"{room} must not know {other}")

    def test_all_know_common_and_themselves(self):
        for room in ("common", "firmware", "host", "sim"):
            self.accepts(f"{room}/thing.cpp", f'#include "common/x.hpp"\n#include "{room}/y.hpp"\n#include <vector>\n')

    def test_main_wires_and_tests_and_tools_include_all(self):
        self.accepts("firmware/main.cpp", '#include "sim/front_end.hpp"\n')
        self.accepts("host/identify/test/drive_test.cpp", '#include "sim/front_end.hpp"\n')
        self.accepts("tools/rb/demo.cpp", '#include "sim/front_end.hpp"\n#include "host/x.hpp"\n')
        self.accepts("hil_tests/demo_test.cpp", '#include "firmware/node.hpp"\n')
        self.refuses("firmware/domain.cpp", '#include "sim/front_end.hpp"\n', 1, "firmware must not know sim")

    def test_libraries_stay_in_their_place(self):
        for name, place in [("toml++/toml.h", "common/config/toml_library.hpp"), ("lcm/lcm-cpp.hpp", "common/bus/bus.cpp"),
                            ("wire/meta_t.hpp", "common/bus/codec.cpp"), ("fftw3.h", "common/dsp/fft.cpp"),
                            ("ginac/ginac.h", "common/multibody/algebra.cpp"),
                            ("boost/beast/core.hpp", "host/web/web_server.cpp")]:
            self.accepts(place, f"#include <{name}>\n")
            for elsewhere in ("common/dsp/psd.cpp", "host/analyser/main.cpp", "tools/rb/demo.cpp", "sim/test/t.cpp"):
                self.refuses(elsewhere, f"#include <{name}>\n", 1, f"<{name}> belongs in ")
        library = '#include "common/config/toml_library.hpp"\n'
        self.accepts("common/config/section.cpp", library)
        self.refuses("tools/rb/datum.cpp", library, 1, "belongs in common/config/ only")

    def test_interfaces_of_the_system_stay_in_one_file_of_the_product(self):
        for name, place in [("gpiod.h", "common/gpio/gpio_chip.cpp"),
                            ("libusb-1.0/libusb.h", "firmware/backends/usb/usb_device.cpp"),
                            ("libusb.h", "firmware/backends/usb/usb_device.cpp"),
                            ("linux/can.h", "firmware/backends/socketcan/can_socket.cpp"),
                            ("linux/can/raw.h", "firmware/backends/socketcan/can_socket.cpp"),
                            ("linux/can/netlink.h", "firmware/backends/socketcan/can_link.cpp")]:
            text = f"#include <{name}>\n"
            for accepted in (place, "hil_tests/guest/player.cpp", "firmware/backends/gpio/test/x_test.cpp"):
                self.accepts(accepted, text)
            for elsewhere in ("common/gpio/gpio_chip.hpp", "firmware/backends/usb/board_link.cpp", "firmware/main.cpp",
                              "host/recorder/power/gpio_line.cpp", "tools/rb/machine.cpp"):
                self.refuses(elsewhere, text, 1, f"<{name}> belongs in ")

    def test_includes_are_written_from_the_root(self):
        self.refuses("host/a/x.cpp", '#include "../../sim/car.hpp"\n', 1, "is not written from the root")
        self.refuses("host/a/x.cpp", '#include "x.hpp"\n', 1, "is not written from the root")
        self.accepts("host/a/x.cpp", '#include "embedded/vehicle.hpp"\n')
        self.accepts("host/a/x.cpp", '#include "derived/car.hpp"\n')

    def test_files_end_at_300_lines(self):
        self.accepts("sim/car.cpp", "\n" * 300)
        self.refuses("sim/car.cpp", "\n" * 301, 301, "301 lines; allowed: 300")

    def test_messages_have_one_size(self):
        begin = "package wire;\nstruct a_t\n{\n"
        self.accepts("common/wire/a_t.lcm", begin + "    byte text[20];  // string[n]\n    double x[2][3];\n}\n")
        self.accepts("common/wire/a_t.lcm", begin + "    const int32_t N = 5;\n    double x[N];\n}\n")
        self.refuses("common/wire/a_t.lcm", begin + "    string text;\n}\n", 4, "type string has no fixed size")
        self.refuses("common/wire/a_t.lcm", begin + "    int32_t n;\n    double x[n];\n}\n", 5, "extent [n] is not fixed")
        self.refuses("common/wire/a_t.lcm", begin + "    int32_t n;\n    double x[2][n];\n}\n", 5, "is not fixed")

    def test_a_type_has_one_definition(self):
        def header(kind, namespace="roadbalance"):
            return f"namespace {namespace} {{\n\n{kind} {{}};\n\n}}  // namespace {namespace}\n"

        for one, other in [("struct Answer", "struct Answer"), ("class Answer final", "struct Answer"),
                           ("struct Answer : Base", "struct Answer"), ("enum class Answer : int", "struct Answer")]:
            code, output = run({"common/bus/a.hpp": header(one), "host/identify/b.hpp": header(other)})
            self.assertEqual(code, 1, output)
            self.assertEqual(output, "host/identify/b.hpp:3: roadbalance::Answer is defined in "
                                     "common/bus/a.hpp:3, too; allowed: once\n")
        for one, other in [(header("struct A"), header("struct A", "roadbalance::sim")),  # of two namespaces
                           (header("struct A"), header("struct B")),
                           (header("struct A"), "namespace roadbalance {\nstruct A;\n}  // namespace roadbalance\n"),
                           (header("struct A"), header("struct B {\n  struct A {};\n} b; struct C"))]:
            code, output = run({"common/bus/a.hpp": one, "host/identify/b.hpp": other})
            self.assertEqual((code, output), (0, ""))
        # What only one file sees is its own.
        self.assertEqual(run({"common/a.hpp": header("struct A"), "common/a.cpp": header("struct A")}), (0, ""))

    def test_an_empty_tree_is_not_a_clean_one(self):
        code, output = run({"README.md": "nothing\n"})
        self.assertEqual(code, 1)
        self.assertIn("no sources here", output)


if __name__ == "__main__":
    unittest.main()
