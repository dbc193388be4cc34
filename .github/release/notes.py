#!/usr/bin/env python3
"""Print the notes of a release: notes.py TAG [SHA256SUMS]

TAG has to be the version of Cargo.toml with a `v` before it, and CHANGELOG.md to have a section of
it; `rehearsal` stands for the section `Unreleased`. Of the checksums the index's is named: whoever
builds the default index by these programs gets the same bytes.

    notes.py v1.2.3 dist/SHA256SUMS
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

from package import ROOT, version

REHEARSAL = "rehearsal"


def section(title: str, changelog: str) -> str:
    """Return the text below the heading of a version; ends the program where there is none."""
    found = re.search(rf"^## {re.escape(title)}(?: [^\n]*)?\n(.*?)(?=^## |\Z)", changelog, re.MULTILINE | re.DOTALL)
    if not found or not found[1].strip():
        sys.exit(f"CHANGELOG.md says nothing below `## {title}`: write what changed for users there")
    return found[1].strip()


def main() -> None:
    if len(sys.argv) not in (2, 3) or sys.argv[1] in ("-h", "--help"):
        sys.exit(__doc__)
    tag = sys.argv[1]
    if tag not in (REHEARSAL, f"v{version()}"):
        sys.exit(f"the tag {tag} does not name the version of Cargo.toml, {version()}")
    title = "Unreleased" if tag == REHEARSAL else version()
    print(section(title, (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")))
    if len(sys.argv) == 3:
        sums = Path(sys.argv[2]).read_text(encoding="utf-8")
        index = re.search(r"^([0-9a-f]{64}) [ *]grasp\.idx$", sums, re.MULTILINE)
        if not index:
            sys.exit(f"{sys.argv[2]} does not name grasp.idx: a release has the default index")
        print(f"\n## Files\n\n`grasp.idx` is the default index, SHA-256 `{index[1]}`: what")
        print("`grasp-builder build --out grasp.idx` of this version makes on any machine. All checksums:")
        print(f"\n```\n{sums.strip()}\n```")


if __name__ == "__main__":
    main()
