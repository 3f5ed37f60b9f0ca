"""Plants violations into small trees and looks whether the checker finds them, and nothing else."""

import contextlib
import io
import pathlib
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import check_layering  # noqa: E402

# A small house: a plan in which common/a knows nobody, and firmware and host know it.
PLAN = {
    "common/a": "", "common/b": "common/a", "common/bus": "common/wire", "common/config": "", "common/dsp": "common/wire", "common/gpio": "",
    "common/wire": "", "common/multibody": "", "firmware": "common/a", "firmware/backends/gpio": "",
    "firmware/backends/socketcan": "", "firmware/backends/usb": "", "host/a": "common/a common/b", "host/analyser": "",
    "host/recorder": "", "host/recorder/power": "", "host/web": "", "sim": "common/a", "tools/rb": "*", "hil_tests": "*",
    "hil_tests/guest": "*",
}
WORDS_OF_UNUSED = ("is no folder with sources", "and does not")


def plan(rooms):
    return "# comment\n\n" + "".join(f"{name} | what it is | {known}\n" for name, known in rooms.items())


def run(files, rooms=None, *arguments):
    """Exit code and output of the checker on a tree of {path: text}, without what a tree so small does not use."""
    with tempfile.TemporaryDirectory() as root:
        for path, text in {"tools/layering/rooms.txt": rooms or plan(PLAN), **files}.items():
            file = pathlib.Path(root, path)
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text, encoding="utf-8")
        with contextlib.redirect_stdout(io.StringIO()) as said:
            code = check_layering.main(["check_layering.py", root, *arguments])
        if rooms:
            return code, said.getvalue()
        lines = [line for line in said.getvalue().splitlines(True) if not line.rstrip().endswith(WORDS_OF_UNUSED)]
        return (1 if lines else 0), "".join(lines)


class CheckLayering(unittest.TestCase):
    def accepts(self, path, text):
        self.assertEqual(run({path: text}), (0, ""))

    def refuses(self, path, text, line, words):
        code, output = run({path: text})
        self.assertEqual(code, 1, output)
        self.assertIn(f"{path}:{line}: ", output)
        self.assertIn(words, output)
        self.assertEqual(output.count("\n"), 1, output)

    def test_rooms_know_whom_the_plan_allows(self):
        for room, other in [("firmware", "host/a"), ("firmware", "sim"), ("host/a", "firmware"), ("host/a", "sim"),
                            ("sim", "host/a"), ("common/a", "common/b"), ("common/b", "host/a"), ("host/a", "tools/rb")]:
            text = f'// first\n#include "{other}/car.hpp"\n'
            self.refuses(f"{room}/thing.cpp", text, 2, f"{room} must not know {other}")
            self.refuses(f"{room}/thing.hpp", text, 2, f"{room} must not know {other}")
            self.refuses(f"{room}/thing.cpp", f"# include <{other}/car.hpp>", 1, f"{room} must not know {other}")
        self.accepts("host/a/thing.cpp", '#include "common/a/x.hpp"\n#include "common/b/x.hpp"\n#include <vector>\n')
        self.accepts("host/a/thing.cpp", '#include "host/a/y.hpp"\n')

    def test_main_wires_and_tests_and_tools_include_all(self):
        self.accepts("firmware/main.cpp", '#include "sim/front_end.hpp"\n')
        self.accepts("host/a/test/drive_test.cpp", '#include "sim/front_end.hpp"\n')
        self.accepts("tools/rb/demo.cpp", '#include "sim/front_end.hpp"\n#include "host/a/x.hpp"\n')
        self.accepts("hil_tests/demo_test.cpp", '#include "firmware/node.hpp"\n')

    def test_the_product_knows_no_tests(self):
        self.refuses("host/a/thing.cpp", '#include "common/a/test/x.hpp"\n', 1, "host/a must not know tests")

    def test_a_folder_is_a_room_or_an_error(self):
        self.refuses("host/b/thing.cpp", "\n", 1, "host/b is no room of tools/layering/rooms.txt")
        self.refuses("host/b/test/thing_test.cpp", "\n", 1, "host/b is no room of tools/layering/rooms.txt")

    def test_the_plan_is_what_is_there(self):
        source = {"common/a/x.hpp": "\n", "common/b/x.hpp": '#include "common/a/x.hpp"\n'}
        good = {"common/a": "", "common/b": "common/a"}
        self.assertEqual(run(source, plan(good)), (0, ""))
        for bad, words in [({**good, "common/c": ""}, "common/c is no folder with sources"),
                           ({**good, "common/a": "common/b"}, "circle of rooms: common/a > common/b > common/a"),
                           ({**good, "common/b": "common/a common/c"}, "common/b may know common/c, which is no room"),
                           ({"common/a": "", "common/b": ""}, "common/b must not know common/a")]:
            code, output = run(source, plan(bad))
            self.assertEqual(code, 1, output)
            self.assertIn(words, output)
        code, output = run({"common/a/x.hpp": "\n", "common/b/x.hpp": "\n"}, plan(good))
        self.assertIn("common/b may know common/a, and does not", output)
        for text, words in [("common/a | what\n", "not a line"), ("common/a | w |\ncommon/a | w |\n", "there twice")]:
            self.assertIn(words, run({"common/a/x.hpp": "\n"}, text)[1])

    def test_readmes_draw_the_plan(self):
        source = {"common/a/x.hpp": "\n", "common/b/x.hpp": '#include "common/a/x.hpp"\n'}
        rooms = plan({"common/a": "", "common/b": "common/a"})
        drawing = run(source, rooms, "--draw", "common")[1]
        self.assertEqual(drawing, "    b  ─▶ a\n    a\n")
        self.assertEqual(run({**source, "common/README.md": "# common\n\n" + drawing}, rooms), (0, ""))
        code, output = run({**source, "common/README.md": "# common\n\n    a\n    b\n"}, rooms)
        self.assertEqual(code, 1)
        self.assertIn("common/README.md:1: does not draw tools/layering/rooms.txt", output)

    def test_a_class_has_one_source(self):
        one = {"host/a/x.cpp": "void Thing::run() {\n  Thing::stop();\n}\n"}
        self.assertEqual(run({**one, "host/a/y.cpp": "  Thing::run();\nint Other::run() {}\n"}), (0, ""))
        code, output = run({**one, "host/a/y.cpp": "\nThing::Thing() {}\n"})
        self.assertEqual(code, 1)
        self.assertIn("host/a/y.cpp:2: Thing has members in host/a/x.cpp, too", output)
        for definition in ("bool Thing::operator==(const Thing& other) const {\n", "void Thing::Inner::run() {\n",
                           "const int Thing::kMost = 3;\n", "Thing::Inner Thing::inner() {\n",
                           "Thing& Thing::operator()() {\n"):
            output = run({**one, "host/a/y.cpp": definition})[1]
            self.assertIn("host/a/y.cpp:1: Thing has members in host/a/x.cpp, too", output, definition)

    def test_a_class_of_a_header_has_one_source_in_all_rooms(self):
        header = {"host/a/x.hpp": "namespace roadbalance {\n\nclass Thing {};\n\n}  // namespace roadbalance\n"}
        sources = {"host/a/x.cpp": "void Thing::run() {}\n", "host/web/y.cpp": "void Thing::stop() {}\n"}
        code, output = run({**header, **sources})
        self.assertEqual(code, 1)
        self.assertIn("host/web/y.cpp:1: Thing has members in host/a/x.cpp, too", output)
        self.assertEqual(run(sources), (0, ""), "two of one name, each its source's own")

    def test_libraries_stay_in_their_place(self):
        for name, place in [("toml++/toml.h", "common/config/toml_library.hpp"), ("lcm/lcm-cpp.hpp", "common/bus/bus.cpp"),
                            ("wire/meta_t.hpp", "common/bus/codec.cpp"), ("fftw3.h", "common/dsp/fft.cpp"),
                            ("ginac/ginac.h", "common/multibody/algebra.cpp"),
                            ("boost/beast/core.hpp", "host/web/web_server.cpp")]:
            self.accepts(place, f"#include <{name}>\n")
            for elsewhere in ("common/dsp/psd.cpp", "host/analyser/main.cpp", "tools/rb/demo.cpp"):
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
            code, output = run({"common/bus/a.hpp": header(one), "host/a/b.hpp": header(other)})
            self.assertEqual(code, 1, output)
            self.assertEqual(output, "host/a/b.hpp:3: roadbalance::Answer is defined in "
                                     "common/bus/a.hpp:3, too; allowed: once\n")
        for one, other in [(header("struct A"), header("struct A", "roadbalance::sim")),  # of two namespaces
                           (header("struct A"), header("struct B")),
                           (header("struct A"), "namespace roadbalance {\nstruct A;\n}  // namespace roadbalance\n"),
                           (header("struct A"), header("struct B {\n  struct A {};\n} b; struct C"))]:
            code, output = run({"common/bus/a.hpp": one, "host/a/b.hpp": other})
            self.assertEqual((code, output), (0, ""))
        # A definition that only one file sees is its own.
        self.assertEqual(run({"common/a/a.hpp": header("struct A"), "common/a/a.cpp": header("struct A")}), (0, ""))

    def test_an_empty_tree_is_not_a_clean_one(self):
        code, output = run({"README.md": "nothing\n"})
        self.assertEqual(code, 1)
        self.assertIn("no sources here", output)


if __name__ == "__main__":
    unittest.main()
