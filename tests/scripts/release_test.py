#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""scripts/release and scripts/release-check: what they must not let pass. Nothing is built here."""
import hashlib
import io
import json
import os
import pathlib
import shutil
import struct
import subprocess
import sys
import tarfile
import tempfile
import unittest
import xml.etree.ElementTree as xml
import zipfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
GIT = ["git", "-c", "user.name=test", "-c", "user.email=test@example.org", "-c", "init.defaultBranch=main"]


def pack(licence):
    """A model pack with a manifest alone."""
    manifest = json.dumps({"schema": "im2fit.models/1", "licence": licence}).encode()
    head = struct.pack("<4sIIIQII", b"I2PK", 2, 0x01020304, 1, 128 + len(manifest), 0, 0)
    table = struct.pack("<16sQQII", b"manifest", 128, len(manifest), 0, 0)
    return (head + table).ljust(128, b"\0") + manifest


def zipped(**files):
    held = io.BytesIO()
    with zipfile.ZipFile(held, "w") as archive:
        for name, data in files.items():
            archive.writestr(name, data)
    return held.getvalue()


def tarred(**files):
    held = io.BytesIO()
    with tarfile.open(fileobj=held, mode="w:xz") as archive:
        for name, data in files.items():
            entry = tarfile.TarInfo(name)
            entry.size = len(data)
            archive.addfile(entry, io.BytesIO(data))
    return held.getvalue()


class Check(unittest.TestCase):
    def setUp(self):
        holder = tempfile.TemporaryDirectory()
        self.addCleanup(holder.cleanup)
        self.folder = pathlib.Path(holder.name) / "release"
        self.folder.mkdir()
        self.put("models.i2p", pack("CC0-1.0"))
        self.put("NOTES.md", b"# im2fit\nMakeHuman's npm package is labelled AGPL-3.0-only; this pack is CC0.\n")
        self.put("sdk.aar", zipped(classes=zipped(NOTICE=b"labels say AGPL3")))

    def put(self, name, data):
        (self.folder / name).write_bytes(data)
        sums = "".join(f"{hashlib.sha256(path.read_bytes()).hexdigest()}  {path.name}\n"
                       for path in sorted(self.folder.iterdir()) if path.name != "SHA256SUMS")
        (self.folder / "SHA256SUMS").write_text(sums)

    def faults(self):
        done = subprocess.run([sys.executable, ROOT / "scripts/release-check", self.folder], capture_output=True, text=True)
        self.assertEqual(done.returncode, 1 if done.stderr else 0, done.stdout + done.stderr)
        return done.stderr.splitlines()

    def test_a_sound_folder_passes(self):
        self.assertEqual(self.faults(), [])

    def test_a_pack_under_another_licence(self):
        self.put("models.i2p", pack("AGPL-3.0-only"))
        self.assertEqual(self.faults(), ["release-check: models.i2p: its models are under AGPL-3.0-only, expected CC0-1.0"])

    def test_a_pack_within_an_archive(self):
        self.put("app.zip", zipped(**{"assets.i2p": pack("AGPL-3.0-only")}))
        self.assertEqual(self.faults(), ["release-check: app.zip: assets.i2p: its models are under AGPL-3.0-only, expected CC0-1.0"])

    def test_a_model_outside_a_pack(self):
        self.put("sources.tar.xz", tarred(**{"tests/index.i2f": b"I2FX" + bytes(60)}))
        self.assertEqual(self.faults(), ["release-check: sources.tar.xz: tests/index.i2f: an index outside a model pack, so "
                                         "nothing states its licence"])

    def test_a_file_that_states_the_agpl(self):
        self.put("sources.tar.xz", tarred(**{"a.c": b"// SPDX-License-Identifier: AGPL-3.0-only\n"}))
        self.put("package.whl", zipped(COPYING=b"            GNU AFFERO GENERAL PUBLIC LICENSE\n"))
        found = self.faults()
        self.assertEqual(len(found), 2, found)
        self.assertIn("package.whl: COPYING: states the AGPL", found[0])
        self.assertIn("sources.tar.xz: a.c: states the AGPL", found[1])

    def test_within_a_debian_package(self):
        tree = self.folder.parent / "tree"
        (tree / "DEBIAN").mkdir(parents=True)
        (tree / "DEBIAN/control").write_text("Package: it\nVersion: 1\nArchitecture: all\nMaintainer: a <a@b.c>\nDescription: it\n")
        (tree / "models.i2p").write_bytes(pack("AGPL-3.0-only"))
        subprocess.run(["dpkg-deb", "--build", tree, self.folder / "it.deb"], check=True, stdout=subprocess.DEVNULL)
        self.put("it.deb", (self.folder / "it.deb").read_bytes())
        self.assertEqual(self.faults(), ["release-check: it.deb: ./models.i2p: its models are under AGPL-3.0-only, expected CC0-1.0"])

    def test_no_pack_and_a_broken_one(self):
        (self.folder / "models.i2p").unlink()
        self.put("NOTES.md", b"text")
        self.assertEqual(self.faults(), ["release-check: no model pack (.i2p)"])
        self.put("models.i2p", b"I2PK")
        self.assertIn("models.i2p: not a model pack that can be read", self.faults()[0])

    def test_checksums(self):
        (self.folder / "NOTES.md").write_bytes(b"changed")
        (self.folder / "late.txt").write_bytes(b"late")
        (self.folder / "sdk.aar").unlink()
        self.assertEqual(self.faults(), ["release-check: NOTES.md: another SHA-256 than SHA256SUMS has",
                                         "release-check: late.txt: not listed in SHA256SUMS",
                                         "release-check: sdk.aar: listed in SHA256SUMS, but missing"])

    def test_an_archive_that_cannot_be_read(self):
        self.put("sources.tar.xz", b"no archive")
        self.assertIn("sources.tar.xz: cannot be looked into", self.faults()[0])

    def test_the_checkers_themselves_may_be_shipped(self):
        self.put("sources.tar.xz", tarred(**{name: (ROOT / name).read_bytes() for name in
                                             ("scripts/release", "scripts/release-check", "NOTICE", "apps/im2fit-lab/pack.cpp")}))
        self.assertEqual(self.faults(), [])


class Release(unittest.TestCase):
    """Refusals that cost nothing: each is one line, and nothing is left behind."""

    def setUp(self):
        holder = tempfile.TemporaryDirectory()
        self.addCleanup(holder.cleanup)
        self.place = pathlib.Path(holder.name)
        # A checkout of its own, whose state the test decides.
        self.tree = self.place / "checkout"
        (self.tree / "apps/im2fit-lab").mkdir(parents=True)
        (self.tree / "scripts").mkdir()
        for part in ["scripts/release", "scripts/common.sh", "CMakeLists.txt", "apps/im2fit-lab/upstream.h"]:
            (self.tree / part).write_bytes((ROOT / part).read_bytes())
        self.change_log("## [1.0.0] – 2026-12-01")
        # Every tool is there, and none does anything but git.
        tools = self.place / "tools"
        tools.mkdir()
        for tool in ["xz", "cmake", "dpkg-deb", "dpkg-shlibdeps", "lintian", "javac", "kotlinc", "sha256sum",
                     "aarch64-linux-gnu-g++", "arm-linux-gnueabihf-g++", "clang++-14", "ld.lld-14", "npm"]:
            (tools / tool).write_text(f"#!/bin/sh\necho {tool} >> {self.place}/called\nexit 1\n")
            (tools / tool).chmod(0o755)
        self.environment = {**os.environ, "PATH": f"{tools}:{os.environ['PATH']}", "GIT_CEILING_DIRECTORIES": holder.name}
        self.environment.pop("ANDROID_NDK_HOME", None)
        self.commit()

    def change_log(self, heading):
        (self.tree / "CHANGELOG.md").write_text(f"# Changes\n\n{heading}\n\nText.\n")

    def commit(self):
        for words in (["init", "-q"], ["add", "-A"], ["commit", "-q", "--allow-empty", "-m", "state"]):
            subprocess.run([*GIT, "-C", self.tree, *words], check=True)

    def refusal(self, *words):
        done = subprocess.run(["bash", self.tree / "scripts/release", *words], capture_output=True, text=True,
                              env=self.environment, cwd=self.place)
        self.assertNotEqual(done.returncode, 0)
        self.assertEqual(done.stderr.count("\n"), 1, done.stderr)
        self.assertFalse((self.place / "called").exists(), "refused before anything is built")
        self.assertEqual([path for path in self.place.iterdir() if ".part." in path.name], [])
        return done.returncode, done.stderr

    def test_wrong_use(self):
        for words, said in (([], "name the folder"), (["a", "b"], "one folder only"), (["--speed", "a"], "no option --speed"),
                            (["a", "--models"], "--models needs a value"), (["a", "--without", "deb"], "aar or firmware"),
                            (["a", "--lab", "."], "--lab is for --trial alone")):
            code, text = self.refusal(*words)
            self.assertEqual(code, 2, text)
            self.assertIn(said, text)

    def test_the_folder(self):
        (self.place / "there").mkdir()
        self.assertIn("there exists already", self.refusal("there")[1])
        self.assertIn("is no folder to write into", self.refusal("no/where")[1])

    def test_models(self):
        (self.place / "models").mkdir()
        self.assertIn("models has no body.i2b", self.refusal("out", "--models", "models")[1])
        self.assertIn("absent is no folder", self.refusal("out", "--models", "absent")[1])

    def test_a_state_that_is_not_to_be_shipped(self):
        self.assertIn("needs ANDROID_NDK_HOME", self.refusal("out")[1])
        (self.tree / "CMakeLists.txt").write_text((self.tree / "CMakeLists.txt").read_text() + "\n")
        self.assertIn("not committed", self.refusal("out")[1])
        self.change_log("## [1.0.0] – unreleased")
        self.assertIn("section [1.0.0] has no date", self.refusal("out")[1])
        self.change_log("## [0.9.0] – 2026-12-01")
        self.assertIn("has no section [1.0.0]", self.refusal("out", "--trial")[1])

    def test_a_tool_that_is_missing(self):
        # A path with links to what the script needs before it looks, and git, python3: nothing else.
        bare = self.place / "bare"
        bare.mkdir()
        for tool in ["bash", "git", "python3", "sed", "grep", "dirname", "basename", "realpath", "nproc"]:
            (bare / tool).symlink_to(shutil.which(tool))
        self.environment["PATH"] = str(bare)
        code, text = self.refusal("out", "--without", "aar", "--without", "firmware")
        self.assertEqual((code, text), (1, "release: needs xz cmake dpkg-deb dpkg-shlibdeps lintian javac kotlinc sha256sum "
                                           "(scripts/deps build test arm package kotlin android)\n"))
        self.assertIn("arm-linux-gnueabihf-g++ (scripts", self.refusal("out", "--without", "aar")[1])

    def test_no_cc0_source(self):
        nowhere = f"file://{self.place}/nowhere.git"
        code, text = self.refusal("out", "--without", "aar", "--upstream", nowhere)
        self.assertEqual((code, text), (1, f"release: no CC0 source: {nowhere} does not answer; name a mirror with "
                                           "--upstream (docs/makehuman.md)\n"))
        self.assertIn("no CC0 source", self.refusal("out", "--trial", "--upstream", nowhere)[1])
        self.assertFalse((self.place / "out").exists())

    def test_a_failure_on_the_way_leaves_nothing(self):
        mirror = self.place / "mirror"
        for words in (["init", "-q", mirror], ["-C", mirror, "commit", "-q", "--allow-empty", "-m", "files"]):
            subprocess.run([*GIT, *words], check=True)
        done = subprocess.run(["bash", self.tree / "scripts/release", "out", "--without", "aar", "--upstream", mirror],
                              capture_output=True, text=True, env=self.environment, cwd=self.place)
        self.assertEqual(done.returncode, 1)
        self.assertEqual((self.place / "called").read_text(), "cmake\n", "it got as far as the first build")
        self.assertEqual(sorted(path.name for path in self.place.iterdir()), ["called", "checkout", "mirror", "tools"])

    def test_the_pom(self):
        text = (ROOT / "sdk/kotlin/android/pom.xml.in").read_text().replace("@VERSION@", "1.2.3")
        space = "{http://maven.apache.org/POM/4.0.0}"
        project = xml.fromstring(text.encode())
        self.assertEqual([project.findtext(space + key) for key in ("groupId", "artifactId", "version", "packaging")],
                         ["im2fit", "im2fit", "1.2.3", "aar"])


if __name__ == "__main__":
    unittest.main()
