#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The programs of docs/tutorial.md as they stand there, on the golden clip: C is compiled and run, Python run, Swift's names
compared with the package; Kotlin is compiled and run by scripts/kotlin-test. tutorial_test.py --program LANGUAGE prints one.

Environment: IM2FIT_LIBRARY, IM2FIT_LAB (makes the pack), and IM2FIT_BODY, IM2FIT_TRACKER, IM2FIT_INDEX."""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs/tutorial.md").read_text(encoding="utf-8")
sys.path.insert(0, str(ROOT / "sdk/python"))


def program(language):
    found = re.findall(rf"^```{language}\n(.*?)^```", PAGE, re.M | re.S)
    assert len(found) == 1, f"{len(found)} programs in {language}"
    return found[0]


def write_frames(path):
    """The golden clip as one file of frames, as its camera delivers them."""
    import im2fit
    folder = im2fit.read_folder(ROOT / "tests/golden/data/clip")
    camera = folder.camera
    assert (camera.width, camera.height, camera.rotate_deg, camera.fx, camera.cx) == (320, 240, 90, 287.9, 159.5), camera
    with open(path, "wb") as file:
        for frame in folder:
            file.write(frame.depth.astype("<u2").tobytes())


class Tutorial(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        lab = os.environ.get("IM2FIT_LAB")
        models = {kind: os.environ.get(f"IM2FIT_{kind.upper()}") for kind in ("body", "tracker", "index")}
        lacking = [kind for kind, path in models.items() if not path or not os.path.exists(path)]
        if not lab or lacking:
            if os.environ.get("IM2FIT_NO_SKIPS"):
                raise RuntimeError(f"no im2fit-lab, or no {', '.join(lacking)}")
            raise unittest.SkipTest(f"no im2fit-lab, or no {', '.join(lacking)}: run scripts/test")
        holder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(holder.cleanup)
        cls.place = pathlib.Path(holder.name)
        words = [word for kind, path in models.items() for word in (f"--{kind}", path)]
        subprocess.run([lab, "pack", "--source", "npm", "--stored", "--out", cls.place / "pack.i2p", *words], check=True,
                       stdout=subprocess.DEVNULL)
        write_frames(cls.place / "frames.raw")

    def measured(self, command):
        """The values that the program prints, by name."""
        done = subprocess.run([*command, self.place / "pack.i2p", self.place / "frames.raw"], capture_output=True, text=True,
                              cwd=self.place, env={**os.environ, "PYTHONPATH": str(ROOT / "sdk/python")})
        self.assertEqual(done.returncode, 0, done.stderr)
        rows = re.findall(r"^(\w+) +(\d+\.\d) (mm|kg)  \[(\d+\.\d), (\d+\.\d)\]$", done.stdout, re.M)
        self.assertEqual(len(rows), 11, done.stdout)
        for name, value, _, low, high in rows:
            self.assertLess(float(low), float(value), name)
            self.assertLess(float(value), float(high), name)
        return {row[0]: row[1:] for row in rows}

    def test_c_and_python_say_the_same(self):
        library = pathlib.Path(os.environ["IM2FIT_LIBRARY"])
        (self.place / "first.c").write_text(program("c"))
        subprocess.run([shutil.which("cc"), "-Wall", "-Wextra", "-Werror", "-I", ROOT / "capi/include", self.place / "first.c",
                        library, f"-Wl,-rpath,{library.resolve().parent}", "-o", self.place / "first"], check=True)
        (self.place / "first.py").write_text(program("python"))
        c = self.measured([self.place / "first"])
        python = self.measured([sys.executable, self.place / "first.py"])
        self.assertEqual(c, python)
        self.assertTrue(1400 < float(c["stature"][0]) < 2100, c)
        self.assertEqual((self.place / "me.glb").read_bytes()[:4], b"glTF")
        wrong = subprocess.run([self.place / "first", "absent.i2p", self.place / "frames.raw"], capture_output=True, text=True)
        self.assertEqual((wrong.returncode, wrong.stderr.count("\n")), (1, 1), wrong.stderr)
        self.assertIn("absent.i2p", wrong.stderr)

    def test_swift_names_are_the_packages(self):
        swift = "\n".join(path.read_text() for path in (ROOT / "sdk/swift/Sources/Im2fit").glob("*.swift"))
        code = re.sub(r"//[^\n]*", "", program("swift"))
        for name in set(re.findall(r"\bsession\.(\w+)", code)):
            self.assertRegex(swift, rf"public func {name}\b", name)
        for name in set(re.findall(r"\bsettings\.(\w+) =", code)):
            self.assertRegex(swift, rf"public var {name}\b", name)
        for name in set(re.findall(r"\bprogress\.(\w+)", code)):
            self.assertRegex(swift, rf"public let {name}\b", name)
        self.assertIn("func guidanceText(_ code: String, language: String = \"en\")", swift)
        self.assertIn("func unit(ofMeasurement name: String)", swift)
        for left, right in ("()", "{}", "[]"):
            self.assertEqual(code.count(left), code.count(right))


if __name__ == "__main__":
    if sys.argv[1:2] == ["--program"]:
        print(program(sys.argv[2]), end="")
    elif sys.argv[1:2] == ["--frames"]:
        write_frames(sys.argv[2])
    else:
        unittest.main()
