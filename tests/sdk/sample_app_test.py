#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The sample apps' files beside their Kotlin, which scripts/kotlin-test compiles: Gradle, manifest, words; and the Swift app,
which no compiler here reads: it has the same steps, and only names that the package has."""
import pathlib
import re
import unittest
import xml.etree.ElementTree as xml

ROOT = pathlib.Path(__file__).resolve().parents[2]
APP = ROOT / "sdk/kotlin/sample-app"
MAIN = APP / "app/src/main"
KOTLIN = {path.name: path.read_text() for path in (MAIN / "kotlin/im2fit/sampleapp").glob("*.kt")}
SWIFT_APP = {path.name: path.read_text() for path in (ROOT / "sdk/swift/SampleApp").glob("*.swift")}
SWIFT = "\n".join(path.read_text() for path in (ROOT / "sdk/swift/Sources/Im2fit").glob("*.swift"))
ANDROID = "{http://schemas.android.com/apk/res/android}"


def strings(folder):
    root = xml.parse(folder / "strings.xml").getroot()
    return {string.get("name"): string.text for string in root}


class Android(unittest.TestCase):
    def test_versions(self):
        version = re.search(r"^project\(im2fit VERSION ([\d.]+)", (ROOT / "CMakeLists.txt").read_text(), re.M).group(1)
        gradle = (APP / "app/build.gradle.kts").read_text()
        self.assertIn(f'files("libs/im2fit-{version}.aar")', gradle)
        self.assertIn(f'versionName = "{version}"', gradle)
        library = xml.parse(ROOT / "sdk/kotlin/android/AndroidManifest.xml").getroot()
        self.assertIn(f"minSdk = {library.find('uses-sdk').get(ANDROID + 'minSdkVersion')}\n", gradle)

    def test_the_pack_is_stored_and_named_alike(self):
        self.assertIn('noCompress += "i2p"', (APP / "app/build.gradle.kts").read_text())
        self.assertIn('ofAssets(assets, "im2fit-models.i2p"', KOTLIN["MainActivity.kt"])
        self.assertIn("assets/im2fit-models.i2p", (APP / "README.md").read_text())

    def test_the_manifest_takes_the_camera_and_no_network(self):
        manifest = xml.parse(MAIN / "AndroidManifest.xml").getroot()
        self.assertEqual([entry.get(ANDROID + "name") for entry in manifest.findall("uses-permission")],
                         ["android.permission.CAMERA"])
        activity = manifest.find("application/activity").get(ANDROID + "name")
        self.assertIn(f"class {activity[1:]} :", KOTLIN["MainActivity.kt"])
        self.assertEqual(manifest.find("application").get(ANDROID + "allowBackup"), "false")

    def test_words_are_the_same_in_every_language(self):
        english = strings(MAIN / "res/values")
        used = set(re.findall(r"R\.string\.(\w+)", "".join(KOTLIN.values()))) | {"app_name"}
        self.assertEqual(used, set(english), "used in Kotlin, and there")
        for language in ("de", "es", "fr", "zh"):
            words = strings(MAIN / f"res/values-{language}")
            self.assertEqual(list(words), list(english), language)
            for name, text in english.items():
                self.assertEqual(sorted(re.findall(r"%\d\$s", words[name])), sorted(re.findall(r"%\d\$s", text)), f"{language} {name}")
                if name != "value":
                    self.assertNotEqual(words[name], text, f"{language} {name} is not translated")


class Swift(unittest.TestCase):
    def test_the_same_steps(self):
        kotlin = re.sub(r"/\*\*.*?\*/", "", KOTLIN["Measuring.kt"], flags=re.S)
        steps = re.findall(r"[A-Z_]+", re.search(r"enum class Step \{(.*?)\}", kotlin, re.S).group(1))
        swift = re.search(r"enum Step[^{]*\{(.*?)\n\}", SWIFT_APP["Measuring.swift"], re.S).group(1)
        cases = re.findall(r"^    case (\w+)", swift, re.M)
        self.assertEqual([re.sub(r"([A-Z])", r"_\1", case).upper() for case in cases], steps)

    def test_the_same_actions(self):
        declared = {name for name in re.findall(r"^    fun (\w+)\(", KOTLIN["Measuring.kt"], re.M)}
        self.assertEqual(declared, {"granted", "start", "stop", "delete", "leave"})
        for action in declared:
            self.assertRegex(SWIFT_APP["Measuring.swift"], rf"    func {action}\(", action)

    def test_names_are_the_packages(self):
        app = "\n".join(SWIFT_APP.values())
        code = re.sub(r"//[^\n]*", "", app)
        calls = set(re.findall(r"\bsession\.(\w+)", code))
        self.assertTrue({"push", "progress", "mask", "finish"} <= calls, calls)
        for name in calls:
            self.assertRegex(SWIFT, rf"public (func|let|var) {name}\b", name)
        types = set(re.findall(r"\b(Fit[A-Z]\w+|CameraModel|CameraPose|Intrinsics|Mask|Outcome|Estimate|Turn|DepthSensor)\b", code))
        self.assertTrue({"FitSession", "FitSettings", "FitProgress"} <= types, types)
        for name in types:
            self.assertRegex(SWIFT, rf"public (final class|struct|enum) {name}\b", name)
        for label in re.findall(r"settings\.(\w+) =", code):
            self.assertRegex(SWIFT, rf"public var {label}\b", label)
        # Every call of push and of the initializer has the labels of one declaration.
        for name, declaration in (("session.push", r"public func push\(([^{}]*?)\) throws"),
                                  ("FitSession", r"init\??\(([^{}]*?)\) throws")):
            declared = [set(re.findall(r"(?:^|,)\s*(\w+)", text)) for text in re.findall(declaration, SWIFT, re.S)]
            calls = re.findall(re.escape(name) + r"\(((?:[^()]|\([^()]*\))*)\)", code)
            self.assertTrue(calls, name)
            for call in calls:
                given = {label if label else "_" for label in
                         re.findall(r"(?:^|,)\s*(?:(\w+):)?", re.sub(r"\([^()]*\)", "", call))}
                self.assertTrue(any(given <= labels for labels in declared), f"{name}({call})")

    def test_every_bracket_closes(self):
        package = {path.name: path.read_text() for path in (ROOT / "sdk/swift/Sources/Im2fit").glob("*.swift")}
        for name, text in {**SWIFT_APP, **package}.items():
            code = re.sub(r'"(\\.|[^"\\\n])*"|//[^\n]*', "", text)
            for left, right in ("()", "{}", "[]"):
                self.assertEqual(code.count(left), code.count(right), f"{name}: {left}{right}")


if __name__ == "__main__":
    unittest.main()
