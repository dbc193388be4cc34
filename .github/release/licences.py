#!/usr/bin/env python3
"""Print the licences of what others wrote and a release links: licences.py TARGET MANIFEST PACKAGE...

TARGET is the platform, as Rust names it; MANIFEST a Cargo.toml, and PACKAGE what is built of it:

    licences.py x86_64-unknown-linux-gnu Cargo.toml grasp-builder grasp-query > LICENSE-THIRD-PARTY

Most licences ask that their text goes with the programs. Of each crate that is linked they are those
of its source; equal ones are printed once. A crate without any ends the printing, unless its licence
is one of the project's own, whose texts go with the programs anyway.
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

from package import ROOT

TEXTS = re.compile(r"(LICEN[CS]E|COPYING|COPYRIGHT|NOTICE|UNLICENSE)", re.IGNORECASE)
OWN = ("MIT", "Apache-2.0")
"""Licences whose text a release has in files of its own: LICENSE-MIT and LICENSE-APACHE."""
DATA = {
    "noto-sans-mono-bitmap": "Its letters are Noto Sans Mono's: Copyright The Noto Project Authors, OFL-1.1."
}
"""What a crate's licence does not say about what is in it."""


def linked(metadata: dict[str, Any], roots: list[str]) -> list[dict[str, Any]]:
    """Return the packages of others that the packages `roots` link, by name; those that only a build or a test needs
    are none of them."""
    packages = {package["id"]: package for package in metadata["packages"]}
    nodes = {node["id"]: node for node in metadata["resolve"]["nodes"]}
    waiting = [
        identity
        for identity, package in packages.items()
        if package["name"] in roots and not package["source"]
    ]
    if len(waiting) != len(roots):
        sys.exit(f"not all of {', '.join(roots)} are packages there")
    found = set(waiting)
    while waiting:
        for dependency in nodes[waiting.pop()]["deps"]:
            is_linked = any(kind["kind"] is None for kind in dependency["dep_kinds"])
            if is_linked and dependency["pkg"] not in found:
                found.add(dependency["pkg"])
                waiting.append(dependency["pkg"])
    others = (packages[identity] for identity in found if packages[identity]["source"])
    return sorted(others, key=lambda package: (package["name"], package["version"]))


def texts(package: dict[str, Any]) -> list[str]:
    """Return the licences in a package's source: of those to choose from, not Apache's, which is long."""
    files = [
        path for path in sorted(Path(package["manifest_path"]).parent.iterdir()) if TEXTS.match(path.name)
    ]
    files = [path for path in files if path.is_file()]
    shorter = [path for path in files if "APACHE" not in path.name.upper()]
    if " OR " in package["license"].replace("/", " OR ") and shorter:
        files = shorter
    read = (path.read_text(encoding="utf-8", errors="replace") for path in files)
    return ["\n".join(line.rstrip() for line in text.strip().splitlines()) for text in read]


def main() -> None:
    if len(sys.argv) < 4:
        sys.exit(__doc__)
    target, manifest, roots = sys.argv[1], sys.argv[2], sys.argv[3:]
    # As it is on every platform: a redirected output on Windows has another encoding and other line ends.
    sys.stdout.reconfigure(encoding="utf-8", newline="\n")
    call = ["cargo", "metadata", "--locked", "--format-version", "1", "--filter-platform", target]
    told = subprocess.run([*call, "--manifest-path", manifest], cwd=ROOT, stdout=subprocess.PIPE, check=True)
    whose: dict[str, list[str]] = {}
    for package in linked(json.loads(told.stdout), roots):
        title = f"{package['name']} {package['version']} ({package['license']})"
        found = texts(package)
        if not found:
            if not any(licence in package["license"] for licence in OWN):
                sys.exit(f"{title} comes without the text of its licence, which its licence asks for")
            authors = ", ".join(re.sub(r" <.*", "", author) for author in package["authors"]) or "not named"
            found = [
                f"Its source has no text of its licence: see LICENSE-MIT or LICENSE-APACHE. Authors: {authors}"
            ]
        if package["name"] in DATA:
            found.append(DATA[package["name"]])
        for text in found:
            whose.setdefault(text, []).append(title)
    print(
        "What others wrote and these programs link, and under which licences. Rust's standard library, which they"
    )
    print("link too, is MIT OR Apache-2.0, by the Rust Project Developers.")
    for text, titles in whose.items():
        print(f"\n{'=' * 80}\n" + "\n".join(titles) + f"\n{'-' * 80}\n\n{text}")


if __name__ == "__main__":
    main()
