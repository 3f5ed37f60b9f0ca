#!/usr/bin/env python3
"""The manual pages and completions of every program, read by groff, lexgrog (of man-db) and bash."""

import os
import pathlib
import re
import subprocess
import unittest

BIN = pathlib.Path(os.environ["RB_BIN"])
MANUAL = BIN.parent / "manual"
# rb-mpi is built where there is MPI.
PROGRAMS = ("rb", "rb-analyser", "rb-node", "rb-recorder", "rb-recordings", "rb-study", "rb-web") + \
    (("rb-mpi",) if (BIN / "rb-mpi").exists() else ())
OF_THEIR_OWN = (["rb", "study"], ["rb", "mpi"])  # commands that are programs


def run(*words):
    done = subprocess.run(words, capture_output=True, text=True, env={**os.environ, "LC_ALL": "C.UTF-8", "MANWIDTH": "200"})
    return done.returncode, done.stdout, done.stderr


def help_of(words):
    return run(BIN / words[0], *words[1:], "--help")[1]


def commands_of(words):
    """The words of a command and of all below it, as --help lists them."""
    yield words
    groups = re.findall(r"^([A-Z][a-z ]*):\n((?: .*\n)+)", help_of(words), re.MULTILINE)
    for title, listed in groups:
        if title not in ("Positionals", "Options"):
            for name in re.findall(r"^  (\S+) ", listed, re.MULTILINE):
                if [*words, name] not in OF_THEIR_OWN:
                    yield from commands_of([*words, name])


class ManualPages(unittest.TestCase):
    def test_every_command_has_a_page_with_all_its_options(self):
        for program in PROGRAMS:
            for words in commands_of([program]):
                page = MANUAL / program / ("-".join(words) + ".1")
                code, text, trouble = run("groff", "-man", "-Tutf8", "-ww", "-P-cbou", "-rLL=200n", "-k", page)
                self.assertEqual((code, trouble), (0, ""), page)
                options = set(re.findall(r"^  (?:-\w,)?(--[\w-]+)", help_of(words), re.MULTILINE))
                self.assertIn("--help", options)
                missing = {option for option in options if not re.search(rf"{option}\b", text)}
                self.assertFalse(missing, page)

    def test_every_page_is_of_a_command(self):
        known = {"-".join(words) for program in PROGRAMS for words in commands_of([program])}
        self.assertEqual({page.stem for page in MANUAL.glob("*/*.1")}, known)

    def test_whatis_finds_name_and_purpose(self):
        for page in MANUAL.glob("*/*.1"):
            code, text, trouble = run("lexgrog", page)
            self.assertEqual(code, 0, trouble)
            self.assertIn(f'"{page.stem} - ', text)

    def test_bash_completes_the_names_of_each_option(self):
        for program in PROGRAMS:
            script = f'source "{MANUAL}/{program}/{program}.bash"; COMP_WORDS=({program} --he); COMP_CWORD=1; ' \
                     f'_{program.replace("-", "_")}; echo "${{COMPREPLY[@]}}"'
            self.assertEqual(run("bash", "--norc", "-c", script), (0, "--help\n", ""), program)

    def test_bash_completes_what_follows_a_program_that_is_called_as_a_command(self):
        script = f'source "{MANUAL}/rb/rb.bash"; source "{MANUAL}/rb-study/rb-study.bash"; ' \
                 'COMP_WORDS=(rb study fig3 --ru); COMP_CWORD=3; _rb; echo "${COMPREPLY[@]}"'
        self.assertEqual(run("bash", "--norc", "-c", script), (0, "--runs\n", ""))

    def test_every_program_says_its_version(self):
        for program in PROGRAMS:
            code, text, trouble = run(BIN / program, "--version")
            self.assertEqual((code, trouble), (0, ""), program)
            self.assertRegex(text, rf"^{program} \d+\.\d+\.\d+\n$")

    def test_bash_completes_what_an_option_takes(self):
        for words, expected in ((("rb", "export", "--format", ""), "candump csv hdf5 mat mcap mdf4 uff58 wav"),
                                (("rb", "export", "--format", "m"), "mat mcap mdf4"),
                                (("rb", "spectrum", "--average", "e"), "exponential")):
            script = f'source "{MANUAL}/rb/rb.bash"; COMP_WORDS=({" ".join(words[:-1])} "{words[-1]}"); ' \
                     f'COMP_CWORD={len(words) - 1}; _rb; echo "${{COMPREPLY[@]}}"'
            self.assertEqual(run("bash", "--norc", "-c", script), (0, expected + "\n", ""), words)


if __name__ == "__main__":
    unittest.main()
