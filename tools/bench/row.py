"""A row of the table of tools/bench/run."""

import dataclasses
import os
import pathlib

ROOT = pathlib.Path(__file__).resolve().parents[2]
BIN = pathlib.Path(os.environ.get("RB_BIN", ROOT / "build/release/bin"))


@dataclasses.dataclass
class Row:
    name: str
    ours: float
    unit: str
    peer: str
    peers: float
    ratio: float  # as it is asked: of speeds where ">=", of costs where "<="
    sign: str | None = None
    bound: float | None = None
    steady: bool = False  # what is asked holds on every machine, however busy: tools/check judges it, too

    def met(self):
        """None if nothing is asked."""
        if self.sign is None:
            return None
        return self.ratio >= self.bound if self.sign == ">=" else self.ratio <= self.bound

    @staticmethod
    def head():
        return f'{"what":36}{"ours":>9} {"unit":13}{"peer":32}{"its":>9}{"ratio":>8}  asked'

    def line(self):
        asked = "" if self.sign is None else f'{self.sign} {self.bound:g} {"met" if self.met() else "MISSED"}'
        return (f"{self.name:36}{self.ours:9.3g} {self.unit:13}{self.peer:32}{self.peers:9.3g}{self.ratio:8.2f}"
                f"  {asked}").rstrip()

    def told(self):
        return dataclasses.asdict(self) | {"met": self.met()}
