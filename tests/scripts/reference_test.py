#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""scripts/reference: what Doxygen reads of the headers. The pages themselves need tools that this test does without."""
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
HEADERS = [ROOT / "capi/include/im2fit/im2fit.h", ROOT / "capi/include/im2fit/cameras.h"]


def filtered(path):
    return subprocess.run([sys.executable, ROOT / "scripts/reference", "--filter", path], check=True, stdout=subprocess.PIPE,
                          text=True).stdout


class Filter(unittest.TestCase):
    def test_every_function_has_its_comment(self):
        for header in HEADERS:
            functions = re.findall(r"^IM2FIT_API [^;(]*?\b(im2fit_\w+)\(", header.read_text(), re.M)
            text = filtered(header)
            self.assertGreater(len(functions), 3)
            for name in functions:
                # Before it, or after it on its line.
                self.assertTrue(re.search(rf"\*/\n[^\n/]*\b{name}\(|^[^\n]*\b{name}\([^\n]*/\*\*<", text, re.M), name)
            self.assertNotIn("IM2FIT_API int", text)
            self.assertEqual(len(re.findall(r"/\*\* \\file\n", text)), 1, header)
            self.assertEqual(text.count("\\verbatim"), text.count("\\endverbatim"), header)

    def test_comments(self):
        with tempfile.TemporaryDirectory() as folder:
            header = pathlib.Path(folder) / "it.h"
            header.write_text("/* SPDX-License-Identifier: Apache-2.0 */\n/* Of <all>.\n *   - a list\n *     goes on */\n#ifndef IT\n"
                              "/* ---- Group ---- */\nint field; /* mm, 100 % */\n/* Adds.\n * Errors:\n *   IO  none */\n"
                              "IM2FIT_API int add(void);\n#endif /* IT */\n")
            self.assertEqual(filtered(header),
                             "/* SPDX-License-Identifier: Apache-2.0 */\n/** \\file\n Of \\<all\\>.\n  - a list\n    goes on */\n"
                             "#ifndef IT\n/* ---- Group ---- */\nint field; /**< mm, 100 \\% */\n/** Adds.\nErrors:\n\\verbatim\n  IO  none\n"
                             "\\endverbatim */\nint add(void);\n#endif /* IT */\n")


class Wrong(unittest.TestCase):
    def test_wrong_use(self):
        done = subprocess.run([sys.executable, ROOT / "scripts/reference", "--fast"], capture_output=True, text=True)
        self.assertEqual((done.returncode, done.stderr), (1, "reference: expected one folder (scripts/reference --help)\n"))


if __name__ == "__main__":
    unittest.main()
