"""The texts beside a record's segments, which prove themselves."""

MOST_BYTES = 16 << 20  # what is longer is none of them


def read_small_file(path):
    """The bytes of a file; none if it is not there, cannot be read or is too long to be such a text."""
    try:
        with path.open("rb") as file:
            data = file.read(MOST_BYTES + 1)
    except OSError:
        return b""
    return data if len(data) <= MOST_BYTES else b""
