"""What the tests of rb import share: recordings made of somebody else's files."""

import h5py

from recorded import Exports, rb


class Imports(Exports):
    def import_as(self, form, name, samples, vehicle, *more):
        folder = self.root / name
        done = rb("import", form, "--samples", samples, "--vehicle", vehicle, "-o", folder, *more)
        return folder, done

    def write_hdf5(self, name, time_s, **channels):
        with h5py.File(self.root / name, "w") as file:
            group = file.create_group("mine")
            group["time_s"] = time_s
            for channel, (values, unit) in channels.items():
                group[channel] = values
                group[channel].attrs["units"] = unit
        return self.root / name
