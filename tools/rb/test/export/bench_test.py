"""tools/bench/exports measures every format that there is, and says what it cannot read."""

import os
import unittest

from recorded import RB, TOOLS, Exports, run


class Bench(Exports):
    def test_has_a_row_for_each_format_and_its_way_back(self):
        done = run(TOOLS / "bench" / "exports", self.drive())
        self.assertIn(done.returncode, (0, 1), done.stderr)  # how fast a small one is tells nothing
        rows = [line[:16].strip() for line in done.stdout.splitlines()[1:]]
        formats = run(RB, "export", "--help").stdout.partition("{")[2].partition("}")[0].split(",")
        self.assertGreater(len(formats), 7)
        self.assertEqual([row for row in rows if " " not in row], ["verify", *formats])
        backs = run(RB, "import", "--help").stdout.partition("Subcommands:\n")[2].splitlines()
        self.assertEqual(sorted(row.removeprefix("import ") for row in rows if " " in row),
                         sorted(line.split()[0] for line in backs if line.startswith("  ") and line[2] != " "))
        if not os.environ["RB_SANITIZE"]:  # sanitizers take more than a program may
            self.assertNotIn("TOO MUCH MEMORY", done.stdout)

    def test_names_what_ends_with_a_failure(self):
        done = run(TOOLS / "bench" / "exports", self.root / "none")
        self.assertEqual(done.returncode, 4)
        self.assertIn("none ends with 4", done.stderr)


if __name__ == "__main__":
    unittest.main()
