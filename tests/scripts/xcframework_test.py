#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""scripts/xcframework with stand-ins for a Mac's tools: what it builds, in which order, and what it refuses."""
import os
import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest
import zipfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
PARTS = ["scripts/xcframework", "scripts/zip-sorted", "CMakeLists.txt", "LICENSE", "NOTICE", "capi/include/im2fit/im2fit.h"]
TOOLS = {
    "uname": "echo Darwin",
    "ninja": "exit 1",
    "xcrun": 'echo "/SDKs/$2"',
    "brew": 'mkdir -p "$PLACE/brew/$2"; echo "$PLACE/brew/$2"',
    # A build makes two archives of rooms.
    "cmake": 'if [ "$1" = --build ]; then mkdir -p "$2/core"; echo core > "$2/core/libim2fit_core.a"; echo c > "$2/libim2fit_c.a"; fi',
    "libtool": 'out=; for word; do [ "$last" != -o ] || out=$word; last=$word; done; for word; do case $word in *.a) [ "$word" = "$out" ] || '
               'cat "$word" >> "$out"; esac; done',
    "lipo": 'cat "$2" "$3" > "$5"',
    "xcodebuild": 'for word; do last=$word; done; mkdir -p "$last"; echo list > "$last/Info.plist"',
    "shasum": 'sha256sum "$3"',
}


class Framework(unittest.TestCase):
    def setUp(self):
        holder = tempfile.TemporaryDirectory()
        self.addCleanup(holder.cleanup)
        self.place = pathlib.Path(holder.name)
        self.tree = self.place / "tree"
        (self.tree / "sdk/swift").mkdir(parents=True)
        for part in PARTS:
            (self.tree / part).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(ROOT / part, self.tree / part)
        self.tools = self.place / "tools"
        self.tools.mkdir()
        for name, body in TOOLS.items():
            (self.tools / name).write_text(f'#!/bin/bash\necho {name} "$@" >> "$PLACE/called"\n{body}\n')
            (self.tools / name).chmod(0o755)

    def run_it(self):
        environment = {**os.environ, "PATH": f"{self.tools}:{os.environ['PATH']}", "PLACE": str(self.place)}
        environment.pop("IM2FIT_PACKAGES", None)
        return subprocess.run([self.tree / "scripts/xcframework"], capture_output=True, text=True, env=environment)

    def test_it_makes_five_slices_and_one_framework(self):
        done = self.run_it()
        self.assertEqual(done.returncode, 0, done.stderr)
        called = (self.place / "called").read_text().splitlines()
        configured = [line for line in called if line.startswith("cmake -G")]
        slices = [(re.search(r"-DCMAKE_SYSTEM_NAME=(\w+)", line).group(1), re.search(r"SYSROOT=/SDKs/(\w+)", line).group(1),
                   re.search(r"ARCHITECTURES=(\w+)", line).group(1), re.search(r"TIERS=(\w+)", line).group(1)) for line in configured]
        self.assertEqual(slices, [("iOS", "iphoneos", "arm64", "auto"), ("iOS", "iphonesimulator", "arm64", "auto"),
                                  ("iOS", "iphonesimulator", "x86_64", "portable"), ("Darwin", "macosx", "arm64", "auto"),
                                  ("Darwin", "macosx", "x86_64", "portable")])
        for line in configured:  # no option that CMakeLists.txt does not have
            for option in re.findall(r"-D(IM2FIT_\w+)=", line):
                self.assertRegex((ROOT / "CMakeLists.txt").read_text(), rf"(option|set)\({option}\b", option)
        build = self.tree / "build/xcframework"
        self.assertEqual((build / "ios-arm64/libim2fit.a").read_text(), "core\nc\n")
        self.assertEqual((build / "macos/libim2fit.a").read_text(), "core\nc\n" * 2)
        last = next(line for line in called if line.startswith("xcodebuild"))
        self.assertEqual(re.findall(r"xcframework/(\S+)/libim2fit.a -headers build/xcframework/headers", last), ["ios-arm64", "simulator", "macos"])
        self.assertEqual((build / "headers/im2fit/im2fit.h").read_text(), (ROOT / "capi/include/im2fit/im2fit.h").read_text())
        self.assertTrue((self.tree / "sdk/swift/CIm2fit.xcframework/Info.plist").exists())
        archive, = (self.tree / "build/packages").glob("im2fit-*.xcframework.zip")
        self.assertEqual(sorted(zipfile.ZipFile(archive).namelist()), [f"CIm2fit.xcframework/{name}" for name in ("Info.plist", "LICENSE", "NOTICE")])
        self.assertRegex(done.stdout, r'checksum: "[0-9a-f]{64}"')
        self.assertEqual(self.run_it().returncode, 0, "and once more over what is there")

    def test_it_refuses_in_one_line(self):
        for tool, body, said in (("uname", "echo Linux", "needs a Mac"), ("brew", "exit 1", "needs nlohmann-json")):
            (self.tools / tool).write_text(f"#!/bin/bash\n{body}\n")
            done = self.run_it()
            self.assertEqual((done.returncode, done.stderr.count("\n")), (1, 1), done.stderr)
            self.assertIn(said, done.stderr)
            (self.tools / tool).write_text(f"#!/bin/bash\n{TOOLS[tool]}\n")

    def test_a_build_that_fails_leaves_the_framework_of_before(self):
        old = self.tree / "sdk/swift/CIm2fit.xcframework"
        old.mkdir()
        (old / "old").write_text("old")
        (self.tools / "cmake").write_text("#!/bin/bash\nexit 1\n")
        self.assertNotEqual(self.run_it().returncode, 0)
        self.assertEqual((old / "old").read_text(), "old")

    def test_the_package_takes_it(self):
        package = (ROOT / "sdk/swift/Package.swift").read_text()
        self.assertIn('.binaryTarget(name: "CIm2fit", path: "CIm2fit.xcframework")', package)
        self.assertIn("module CIm2fit", (ROOT / "scripts/xcframework").read_text())
        self.assertIn("module CIm2fit", (ROOT / "sdk/swift/Sources/CIm2fit/module.modulemap").read_text())


if __name__ == "__main__":
    unittest.main()
