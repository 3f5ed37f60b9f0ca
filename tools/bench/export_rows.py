"""What verifying, exporting and importing a recording takes."""

import pathlib
import tempfile

from row import BIN
from taken import measured

ASKED_MB_S = {"verify": 400, "csv": 60, "hdf5": 200, "mdf4": 200}
FORMATS = ("candump", "csv", "hdf5", "mat", "mcap", "mdf4", "uff58", "wav")
IMPORTED = ("candump", "csv", "hdf5", "uff58", "wav")


def rows(recording, scratch):
    """(what, MB of the file written or read or of the recording verified, Taken, that file), one after another: a file
    is there until the next is asked for."""
    segments = sorted(recording.glob("seg-*.lcm"))
    size_mb = sum(segment.stat().st_size for segment in segments) * 1e-6
    yield "verify", size_mb, measured(BIN / "rb", "verify", recording), segments
    for form in FORMATS:
        with tempfile.TemporaryDirectory(prefix="rb-exports-", dir=scratch) as folder:
            file, vehicle, dbc = (pathlib.Path(folder, name) for name in (form, "vehicle.toml", "dbc"))
            beside = ("--dbc", dbc) if form == "candump" else ()
            took = measured(BIN / "rb", "export", "--format", form, recording, "-o", file, "--vehicle", vehicle, *beside)
            size_mb = file.stat().st_size * 1e-6
            yield form, size_mb, took, [file]
            if form in IMPORTED:
                took = measured(BIN / "rb", "import", form, "--samples", file, "--vehicle", vehicle, "-o",
                                pathlib.Path(folder, "back"), *beside)
                yield f"import {form}", size_mb, took, [file]
