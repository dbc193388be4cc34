"""`python3 -m unittest` here: what is packed can be used, and the notes say what they have to.

GRASP_PROGRAMS names the folder of the programs; without it, it is target/debug.
"""

import hashlib
import os
import re
import subprocess
import sys
import tarfile
import tempfile
import unittest
import zipfile
from pathlib import Path

import licences
import notes
import package

TARGET = "x86_64-unknown-linux-gnu"
PROGRAMS = Path(os.environ.get("GRASP_PROGRAMS", package.ROOT / "target" / "debug"))


def ran(script: str, *arguments: object) -> subprocess.CompletedProcess:
    command = [sys.executable, Path(__file__).parent / script, *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, check=False)


@unittest.skipUnless(os.name == "posix", "the programs are those of this platform")
class Package(unittest.TestCase):
    @classmethod
    def setUpClass(cls) -> None:
        cls.folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.folder.cleanup)
        cls.out = Path(cls.folder.name) / "out"
        cls.third_party = Path(cls.folder.name) / "LICENSE-THIRD-PARTY"
        cls.third_party.write_text("a 1.0.0 (MIT)\n")
        made = ran("package.py", TARGET, PROGRAMS, cls.third_party, cls.out)
        assert made.returncode == 0, made.stderr
        cls.path = Path(made.stdout.strip())

    def test_it_is_unpacked_into_a_prefix(self) -> None:
        prefix = Path(self.folder.name) / "prefix"
        prefix.mkdir()
        unpack = ["tar", "xzf", self.path, "-C", prefix, "--strip-components", "1"]
        subprocess.run(unpack, check=True)
        for name in package.PROGRAMS:
            program = prefix / "bin" / name
            told = subprocess.run([program, "--version"], capture_output=True, text=True, check=True)
            self.assertEqual(told.stdout.split(), [name, package.version()])
            for shell in ("bash-completion/completions/{}", "zsh/site-functions/_{}"):
                self.assertIn(name, (prefix / "share" / shell.format(name)).read_text())
            self.assertTrue((prefix / "share" / "man" / "man1" / f"{name}.1").read_text().startswith(".ie"))
        for page in ("grasp-query-recognise.1", "grasp-builder-build.1"):
            self.assertIn(".SH OPTIONS", (prefix / "share" / "man" / "man1" / page).read_text())
        for licence in ("MIT", "APACHE", "poses", "THIRD-PARTY"):
            self.assertTrue((prefix / "share" / "doc" / "grasp" / f"LICENSE-{licence}").exists(), licence)

    def stand_ins(self, ending: str = "") -> Path:
        """Small programs that print what they are asked."""
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        folder = Path(temporary.name)
        for name in package.PROGRAMS:
            program = folder / f"{name}{ending}"
            program.write_text(f'#!/bin/sh\necho "{name} $*"\n')
            program.chmod(0o755)
        return folder

    def test_the_same_programs_make_the_same_bytes(self) -> None:
        programs = self.stand_ins()
        made = [ran("package.py", TARGET, programs, self.third_party, self.out / name) for name in "ab"]
        paths = [Path(one.stdout.strip()) for one in made]
        self.assertEqual(paths[0].read_bytes(), paths[1].read_bytes())
        with tarfile.open(paths[0]) as archive:
            for entry in archive:
                self.assertEqual((entry.mtime, entry.uid, entry.uname), (0, 0, ""))
                self.assertTrue(entry.name.startswith(f"grasp-{package.version()}/"))
                self.assertEqual(entry.mode, 0o755 if "/bin/" in entry.name else 0o644)

    def test_windows_has_a_zip_archive(self) -> None:
        programs = self.stand_ins(".exe")
        made = ran("package.py", "x86_64-pc-windows-msvc", programs, self.third_party, self.out)
        with zipfile.ZipFile(made.stdout.strip()) as archive:
            names = archive.namelist()
        self.assertIn(f"grasp-{package.version()}/bin/grasp-query.exe", names)
        self.assertIn(f"grasp-{package.version()}/share/grasp/completions/grasp-query.ps1", names)

    def test_a_missing_program_ends_it(self) -> None:
        made = ran("package.py", TARGET, self.folder.name, self.third_party, self.out / "none")
        self.assertNotEqual(made.returncode, 0)
        self.assertFalse((self.out / "none").exists())


class Licences(unittest.TestCase):
    def test_every_linked_crate_has_one(self) -> None:
        made = ran("licences.py", TARGET, "Cargo.toml", *package.PROGRAMS)
        self.assertEqual(made.returncode, 0, made.stderr)
        for crate in ("serde", "axum", "rapier3d"):
            self.assertRegex(made.stdout, rf"(?m)^{crate} \d+\.\d+\.\d+ \(.+\)$")
        self.assertIn("Permission is hereby granted", made.stdout)
        # What only tests need is not in the programs.
        self.assertNotRegex(made.stdout, r"(?m)^(criterion|insta|proptest) ")

    def test_a_crate_without_a_text_is_told(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            manifest = str(Path(folder) / "Cargo.toml")
            crate = {"manifest_path": manifest, "license": "MIT/Apache-2.0"}
            self.assertEqual(licences.texts(crate), [])
            for name in ("LICENSE-APACHE", "LICENSE-MIT", "NOTICE"):
                (Path(folder) / name).write_text(f"{name} \n\n")
            self.assertEqual(licences.texts(crate), ["LICENSE-MIT", "NOTICE"])
            self.assertEqual(len(licences.texts({**crate, "license": "MIT AND Apache-2.0"})), 3)


class Notes(unittest.TestCase):
    def test_all_packages_have_one_version(self) -> None:
        for workspace in ("query/python", "query/ros"):
            manifest = (package.ROOT / workspace / "Cargo.toml").read_text(encoding="utf-8")
            self.assertIn(f'\nversion = "{package.version()}"\n', manifest, workspace)

    def test_a_section_ends_where_the_next_begins(self) -> None:
        changelog = "# C\n\n## 1.2.0 (2026-01-02)\n\n### A\n\n- b\n\n## 1.2\n\n- old\n"
        self.assertEqual(notes.section("1.2.0", changelog), "### A\n\n- b")
        self.assertEqual(notes.section("1.2", changelog), "- old")
        with self.assertRaisesRegex(SystemExit, "says nothing below `## 9`"):
            notes.section("9", changelog)

    def test_a_tag_names_the_version(self) -> None:
        wrong = ran("notes.py", "v0.0.0")
        self.assertIn("does not name the version of Cargo.toml", wrong.stderr)
        self.assertEqual(wrong.returncode, 1)

    def test_a_rehearsal_names_the_index_and_all_files(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            sums = Path(folder) / "SHA256SUMS"
            digest = hashlib.sha256(b"index").hexdigest()
            sums.write_text(f"{digest}  grasp.idx\n{digest}  grasp-{TARGET}.tar.gz\n")
            made = ran("notes.py", notes.REHEARSAL, sums)
            self.assertEqual(made.returncode, 0, made.stderr)
            self.assertTrue(re.search(rf"`{digest}`", made.stdout) and TARGET in made.stdout)
            sums.write_text(f"{digest}  other.idx\n")
            self.assertIn("does not name grasp.idx", ran("notes.py", notes.REHEARSAL, sums).stderr)


if __name__ == "__main__":
    unittest.main()
