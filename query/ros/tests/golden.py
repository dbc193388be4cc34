"""Writes golden.txt: the samples as CycloneDDS encodes them, one a line, as hexadecimal digits.

    python golden.py > golden.txt
"""

import messages
import samples


def lines():
    """The lines of golden.txt."""
    for name in samples.BUILDERS:
        yield f"{name} {encoded(name).hex()}"


def encoded(name):
    """A sample in the first version of CDR, little-endian, behind its four bytes of header."""
    return samples.message(messages, name).serialize(use_version_2=False)


if __name__ == "__main__":
    print("\n".join(lines()))
