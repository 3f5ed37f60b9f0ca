#!/usr/bin/env python3
"""Checks a recording without any of the product's code:  check_record.py DIR [--truth truth.json] [--json]

Reads the segments as LCM event logs and the messages by common/wire/*.lcm; proves block numbers, scan indices,
CRCs, totals, gaps and journal of each node epoch.  With --truth each sample is held against what was produced.

Exit codes: 0 complete, 3 incomplete but declared, 1 damaged, 2 usage, 4 cannot be read.
"""

import argparse
import json
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))

from record_check.description import read_recorded_types  # noqa: E402
from record_check.event_log import split_events  # noqa: E402
from record_check.record import UNREADABLE, WORDS, Checker  # noqa: E402
from record_check.truth import Truth  # noqa: E402
from record_check.wire_types import read_wire_types  # noqa: E402

WIRE = pathlib.Path(__file__).resolve().parent.parent / "common" / "wire"


def report(checker):
    """What was found, as one object."""
    epochs = []
    for key, epoch in sorted(checker.epochs.items()):
        journal = checker.journals.get(key)
        epochs.append(epoch.report() | {"journal_entries": journal.entries if journal else 0,
                                        "journal_contradictions": journal.contradictions if journal else [],
                                        "losses": journal.losses if journal else {}})
    return {"verdict": WORDS[checker.verdict()], "exit_code": checker.verdict(), "events": checker.events,
            "bytes": checker.bytes, "notes": checker.notes, "messages_refused": checker.refused,
            "damaged_bytes": checker.damaged_bytes, "torn_bytes": checker.torn_bytes,
            "altered_headers": checker.altered_headers,
            "missing_segments": checker.missing_segments,
            "deleted_segments": sorted(checker.segments.deleted), "damage": checker.damage, "lost": checker.lost,
            "elsewhere": checker.elsewhere,
            "description": checker.description.report(), "nodes": epochs}


def blocks_of(gap):
    first, last = gap["first_block"], gap["last_block"]
    return f"block {last}" if first == last else f"blocks {first} to {last}"


def scans_of(gap):
    if gap["scans"] > 0:
        return f'from scan {gap["first_scan"]} on {gap["scans"]} scans'
    if gap["scans_known"]:
        return "no scans: edges, signals or description"
    return f'from scan {gap["first_scan"]} on, how many is not known'


def losses_of(epoch):
    """Counters of the last journal entry that are not 0."""
    said = {name: sum(value) if isinstance(value, tuple) else value for name, value in epoch["losses"].items()}
    counted = [f"{name} {value}" for name, value in said.items() if value]
    return ["counted by then: " + ", ".join(counted)] if counted else []


def print_report(found):
    if found["description"]["program"]:
        print(f'written by {found["description"]["program"]}, format {found["description"]["format_version"]}')
    for epoch in found["nodes"]:
        print(f'node {epoch["node"]} epoch {epoch["epoch"]}: {epoch["blocks"]} blocks, {epoch["samples_recorded"]} samples, '
              f'{epoch["samples_missing"]} missing in {len(epoch["gaps"])} gaps, {epoch["journal_entries"]} journal entries'
              f'{"" if epoch["ended"] else ", crashed" if epoch["crashed"] else ", no end"}')
        for gap in epoch["gaps"]:
            print(f"  gap, {blocks_of(gap)}, {scans_of(gap)}: {gap['cause']}")
        for what in ("undeclared_blocks", "undeclared_scans"):
            for first, last in epoch[what]:
                print(f'  {what.split("_")[1]} {first} to {last} are missing, undeclared')
        for what in ("identical_repeats", "other_repeats", "overlaps"):
            if epoch[what]:
                print(f'  {epoch[what]} {what.replace("_", " ")}')
        for line in losses_of(epoch):
            print(f"  {line}")
        for line in epoch["contradictions"] + epoch["journal_contradictions"]:
            print(f"  {line}")
    for line in found["damage"] + found["lost"] + found["elsewhere"]:
        print(line)
    if found["messages_refused"]:
        print(f'{found["messages_refused"]} messages are altered')
    print(found["verdict"])


def types_in(folder):
    logs = (path.read_bytes() for path in sorted(pathlib.Path(folder).glob("seg-*.lcm")))
    return read_recorded_types((log, split_events(log)[0]) for log in logs)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("folder", help="the recording")
    parser.add_argument("--truth", help="truth.json of a run whose samples are hashes")
    parser.add_argument("--json", action="store_true", help="one JSON object on standard output")
    parser.add_argument("--wire", default=WIRE, help="folder of the .lcm files, or the word record: the texts that the "
                                                      "record itself holds (default: %(default)s)")
    arguments = parser.parse_args()
    try:
        types = types_in(arguments.folder) if arguments.wire == "record" else read_wire_types(arguments.wire)
        checker = Checker(arguments.folder, types, Truth(arguments.truth) if arguments.truth else None)
        checker.check()
    except (OSError, MemoryError, ValueError, KeyError) as error:
        print(f"check_record: {error}", file=sys.stderr)
        return UNREADABLE
    found = report(checker)
    print(json.dumps(found)) if arguments.json else print_report(found)
    return checker.verdict()


if __name__ == "__main__":
    sys.exit(main())
