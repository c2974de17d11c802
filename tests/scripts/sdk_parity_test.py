#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""scripts/sdk-parity on a copy of the header and the SDKs: what it must not let pass."""
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
PARTS = ["scripts/sdk-parity", "docs/sdk-parity.md", "capi/include/im2fit/im2fit.h", "sdk/python/im2fit", "sdk/kotlin/jni",
         "sdk/swift/Sources/Im2fit"]
HEADER, PYTHON, SWIFT = "capi/include/im2fit/im2fit.h", "sdk/python/im2fit/__init__.py", "sdk/swift/Sources/Im2fit/FitSession.swift"


class Parity(unittest.TestCase):
    def setUp(self):
        holder = tempfile.TemporaryDirectory()
        self.addCleanup(holder.cleanup)
        self.tree = pathlib.Path(holder.name)
        for part in PARTS:
            (self.tree / part).parent.mkdir(parents=True, exist_ok=True)
            copy = shutil.copytree if (ROOT / part).is_dir() else shutil.copy
            copy(ROOT / part, self.tree / part)

    def run_it(self, *words):
        done = subprocess.run([sys.executable, self.tree / "scripts/sdk-parity", *words], capture_output=True, text=True)
        return done.returncode, done.stdout + done.stderr

    def change(self, part, before, after):
        text = (self.tree / part).read_text()
        self.assertIn(before, text)
        (self.tree / part).write_text(text.replace(before, after))

    def test_the_page_is_written_and_checked(self):
        code, text = self.run_it("--check")
        self.assertEqual(code, 0, text)
        self.assertRegex(text, r"^sdk-parity: \d\d functions; Python \d+ of \d+, Kotlin")
        (self.tree / "docs/sdk-parity.md").write_text("old")
        code, text = self.run_it("--check")
        self.assertEqual((code, "out of date" in text), (1, True), text)
        self.assertEqual(self.run_it()[0], 0)
        self.assertEqual(self.run_it("--check")[0], 0)
        self.assertEqual(self.run_it("--chekc")[0], 2)

    def test_a_new_function_that_no_sdk_has_fails(self):
        self.change(HEADER, "IM2FIT_API int im2fit_reset(", "IM2FIT_API int im2fit_fly(im2fit_handle* handle);\nIM2FIT_API int im2fit_reset(")
        self.run_it()
        code, text = self.run_it("--check")
        self.assertEqual((code, "im2fit_fly is in no SDK" in text), (1, True), text)
        # Comments do not count as calls. One SDK that calls the function is enough.
        self.change(PYTHON, "def version()", "# im2fit_fly\ndef version()")
        self.assertEqual(self.run_it()[0], 1)
        self.change(PYTHON, "def version()", "def fly():\n    _lib().im2fit_fly(None)\n\n\ndef version()")
        self.assertEqual(self.run_it()[0], 0, self.run_it())

    def test_a_reason_that_no_longer_holds_fails(self):
        self.change(SWIFT, "im2fit_push_frame(handle, &frame)", "im2fit_push(handle, nil, 0, 0, 0, 0, 0)")
        code, text = self.run_it()
        self.assertEqual((code, "Swift calls im2fit_push, which WITHOUT says" in text), (1, True), text)
        self.change(HEADER, "im2fit_detach(", "im2fit_let_go(")
        self.assertIn("im2fit_detach is in WITHOUT but not in the header", self.run_it()[1])

    def test_an_sdk_that_falls_behind_fails(self):
        shutil.rmtree(self.tree / "sdk/swift/Sources/Im2fit")
        code, text = self.run_it()
        self.assertEqual((code, "Swift has 0 of" in text), (1, True), text)


if __name__ == "__main__":
    unittest.main()
