#!/usr/bin/env python3
"""Pack the programs of a release: package.py TARGET PROGRAMS THIRD-PARTY OUT

TARGET is the platform, as Rust names it; PROGRAMS the folder with the two programs, which have to
run here; THIRD-PARTY the file with the licences of what they link, which licences.py prints; OUT the
folder in which grasp-TARGET.tar.gz (for Windows .zip) is written. The archive holds programs, manual
pages and completions where a prefix such as ~/.local has them: it is installed by being unpacked
there. The same programs make the same bytes.

    package.py x86_64-unknown-linux-gnu target/release LICENSE-THIRD-PARTY dist
"""

from __future__ import annotations

import gzip
import io
import re
import subprocess
import sys
import tarfile
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PROGRAMS = ("grasp-builder", "grasp-query")
DOCUMENTS = ("README.md", "CHANGELOG.md", "LICENSE-APACHE", "LICENSE-MIT", "renders/data/LICENSE-poses")
# Where each shell looks, below a prefix; the last is for `. FILE` in a profile.
COMPLETIONS = {
    "bash": "share/bash-completion/completions/{}",
    "zsh": "share/zsh/site-functions/_{}",
    "fish": "share/fish/vendor_completions.d/{}.fish",
    "powershell": "share/grasp/completions/{}.ps1",
}
# The least time that a ZIP archive can state.
LONG_AGO = (1980, 1, 1, 0, 0, 0)
# Beyond it, a hundredth less costs twice the time.
COMPRESSION = 6


def version() -> str:
    """Return the version that all packages share."""
    (found,) = re.findall(r'^version = "(.+)"$', (ROOT / "Cargo.toml").read_text(encoding="utf-8"), re.MULTILINE)
    return found


def printed(program: Path, *arguments: str) -> bytes:
    """Return what a program prints; its failure ends the packing."""
    return subprocess.run([program, *arguments], stdout=subprocess.PIPE, check=True).stdout


def subcommands(program: Path) -> list[str]:
    """Return the names of a program's subcommands, which have manual pages of their own."""
    _, _, listed = printed(program, "--help").decode().replace("\r\n", "\n").partition("\nCommands:\n")
    names = re.findall(r"^  (\w[\w-]*)", listed.split("\n\n")[0], re.MULTILINE)
    return [name for name in names if name != "help"]


def contents(programs: Path, third_party: Path, ending: str) -> dict[str, bytes]:
    """Return the files of the archive, by their paths below the prefix."""
    files = {}
    for name in PROGRAMS:
        program = programs / f"{name}{ending}"
        files[f"bin/{program.name}"] = program.read_bytes()
        files[f"share/man/man1/{name}.1"] = printed(program, "man")
        for subcommand in subcommands(program):
            files[f"share/man/man1/{name}-{subcommand}.1"] = printed(program, "man", subcommand)
        for shell, path in COMPLETIONS.items():
            files[path.format(name)] = printed(program, "completions", shell)
    for document in (*(ROOT / name for name in DOCUMENTS), third_party):
        files[f"share/doc/grasp/{document.name}"] = document.read_bytes()
    return dict(sorted(files.items()))


def tar(folder: str, files: dict[str, bytes]) -> bytes:
    """Return a compressed tar archive that names neither its maker nor the hour."""
    packed = io.BytesIO()
    with tarfile.open(fileobj=packed, mode="w", format=tarfile.USTAR_FORMAT) as archive:
        for path, data in files.items():
            entry = tarfile.TarInfo(f"{folder}/{path}")
            entry.size, entry.mode = len(data), 0o755 if path.startswith("bin/") else 0o644
            archive.addfile(entry, io.BytesIO(data))
    return gzip.compress(packed.getvalue(), COMPRESSION, mtime=0)


def zipped(folder: str, files: dict[str, bytes]) -> bytes:
    """Return the same as a ZIP archive."""
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        for path, data in files.items():
            archive.writestr(zipfile.ZipInfo(f"{folder}/{path}", LONG_AGO), data, zipfile.ZIP_DEFLATED)
    return packed.getvalue()


def main() -> None:
    if len(sys.argv) != 5:
        sys.exit(__doc__)
    target, (programs, third_party, out) = sys.argv[1], map(Path, sys.argv[2:])
    is_windows = "windows" in target
    files = contents(programs, third_party, ".exe" if is_windows else "")
    folder = f"grasp-{version()}"
    out.mkdir(parents=True, exist_ok=True)
    path = out / f"grasp-{target}.{'zip' if is_windows else 'tar.gz'}"
    path.write_bytes((zipped if is_windows else tar)(folder, files))
    print(path)


if __name__ == "__main__":
    main()
