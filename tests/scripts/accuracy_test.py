#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""scripts/accuracy on a small tree of its own: invented sources, pages and results."""
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

SCRIPT = pathlib.Path(__file__).resolve().parents[2] / "scripts/accuracy"
DATASET = "constexpr std::uint64_t kDatasetVersion = {};  // raise when a sample changes\n"
INDEX = 'inline constexpr char kMagic[] = "I2FX";\ninline constexpr std::uint32_t kVersion = {};\n'
UNITS = {"stature": "mm", "neck_girth": "mm", "chest_girth": "mm", "waist_girth": "mm", "hip_girth": "mm",
         "weight": "kg"}
CONDITIONS = ["noise", "both", "around", "clothed", "garments"]
POPULATIONS = {"noise": ["other", "ansur", "modifiers"], "both": ["other", "ansur", "modifiers"],
               "around": ["other", "ansur", "modifiers"],
               "clothed": ["ansur", "modifiers"], "garments": ["ansur", "modifiers"]}
EACH = [(condition, population) for condition in CONDITIONS for population in POPULATIONS[condition]]

# Stands for im2fit-lab: notes each evaluation, and fails after as many as FAKE_LAB_LIMIT says.
FAKE_LAB = """#!/usr/bin/env python3
import json, os, sys
words = sys.argv[1:]
if words[:2] == ["index", "inspect"]:
    print(json.dumps({"entries": 4000, "provenance": "made, dataset version " + os.environ.get("FAKE_DATASET", "22")}))
    sys.exit(0)
flat = [w for w in words[1:] if w != "--no-raw"]
given = dict(zip(flat[::2], flat[1::2]))
with open(os.environ["FAKE_LOG"], "a+") as log:
    log.seek(0)
    if len(log.readlines()) >= int(os.environ.get("FAKE_LAB_LIMIT", "99")):
        sys.exit(1)
    log.write(given["--condition"] + " " + given["--family"] + "\\n")
sys.path.insert(0, os.environ["FAKE_RESULTS"])
import accuracy_test
result = accuracy_test.result(given["--condition"], given["--family"], people=int(given["--subjects"]),
                              commit=given["--commit"])
json.dump(result, open(given["--out"], "w"))
"""


def result(condition, population, people=400, commit="abc1234", dataset=22, index_format=13, mae=20.4, bias=-6.6):
    measurements = {
        name: {"unit": unit, "ours": {"count": people, "bias": bias, "mae": mae}, "coverage_95": 0.954321987,
               "interval_width": 130.0, "interval_width_median": 124.6}
        for name, unit in UNITS.items()}
    return {"schema": "im2fit.evaluation/1", "family": population, "condition": condition,
            "measured_with": {"dataset_version": dataset, "index_format": index_format, "index_models": 4000,
                              "seed": 7, "commit": commit},
            "subjects": people, "measured": people - 2, "measurements": measurements}


class Accuracy(unittest.TestCase):
    def setUp(self):
        self.root = pathlib.Path(tempfile.mkdtemp())
        self.addCleanup(shutil.rmtree, self.root)
        for folder in ("scripts", "somewhere/deep", "index", "docs/evaluation"):
            (self.root / folder).mkdir(parents=True)
        shutil.copy(SCRIPT, self.root / "scripts/accuracy")
        self.code(22, 13)
        self.page("README.md", "# im2fit\n\n<!-- accuracy:headline -->\n<!-- /accuracy -->\n\nAfter it.\n")
        self.page("docs/evaluation.md", "".join(f"## {name}\n<!-- accuracy:{name} -->\nold\n<!-- /accuracy -->\n"
                                                for name in ("front", "both-sides", "around", "clothed", "garments")))
        for condition in CONDITIONS:
            self.put(result(condition, "modifiers"))
            self.put(result(condition, "ansur", mae=30.6, bias=14.2))
        for condition in ("noise", "both", "around"):
            self.put(result(condition, "other", mae=28.2, bias=3.3))

    def code(self, dataset, index_format):
        (self.root / "somewhere/deep/dataset.cpp").write_text(DATASET.format(dataset))
        (self.root / "index/format.h").write_text(INDEX.format(index_format))

    def page(self, name, text=None):
        if text is not None:
            (self.root / name).write_text(text, encoding="utf-8")
        return (self.root / name).read_text(encoding="utf-8")

    def put(self, entry):
        path = self.root / f"docs/evaluation/{entry['condition']}.{entry['family']}.json"
        path.write_text(json.dumps(entry))
        return path

    def script(self, *words, **environment):
        return subprocess.run([sys.executable, self.root / "scripts/accuracy", *words], capture_output=True, text=True,
                              env={**os.environ, "PYTHONDONTWRITEBYTECODE": "1", **environment})

    def succeeds(self, *words, **environment):
        done = self.script(*words, **environment)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout

    def fails(self, words, *names):
        done = self.script(*words)
        self.assertEqual(done.returncode, 1, done.stdout + done.stderr)
        for name in names:
            self.assertIn(name, done.stderr)
        self.assertNotIn("Traceback", done.stderr)

    def test_tables_are_those_of_the_results(self):
        self.fails(["check"], "README.md", "docs/evaluation.md", "scripts/accuracy tables")
        self.succeeds("tables")
        self.succeeds("check")
        readme = self.page("README.md")
        self.assertIn("| close-fitting clothes (simulated as none): `ansur` | 31 (+14)<br>95 % in ±62 |", readme)
        self.assertIn("| loose T-shirt and trousers: `ansur` |", readme)
        self.assertIn("| the same, and one turn (`--around`): `ansur` |", readme)
        self.assertIn("30.6 (+14.2)<br>95 % in ±62.3 |", readme, "weight, with a decimal")
        self.assertIn("Measured: 398 of 400 (`ansur`), 398 of 400 (`ansur`), 398 of 400 (`ansur`). Index of 4,000 simulated people, format 13. "
                      "Dataset: version 22. Commit: abc1234.", " ".join(readme.split()))
        self.assertTrue(readme.endswith("<!-- /accuracy -->\n\nAfter it.\n"), readme)
        page = self.page("docs/evaluation.md")
        row = "| waist girth, mm | 31 (+14) | 95 % | 125 |{} 20 (−7) | 95 % | 125 |"
        self.assertEqual(page.count(row.format("")), 2, page)
        self.assertEqual(page.count(row.format(" 28 (+3) | 95 % | 125 |")), 3, page)
        self.assertNotIn("\nold\n", page)
        self.assertEqual(page.count("abc1234"), 5, "one commit a table")

    def test_worse_population_comes_first_by_chest_waist_hip_and_neck_alone(self):
        entry = result("noise", "modifiers", mae=31)
        entry["measurements"]["weight"]["ours"]["mae"] = 1.0
        self.put(entry)
        self.succeeds("tables")
        front = self.page("docs/evaluation.md").split("## both-sides")[0]
        self.assertLess(front.index("`modifiers`: MAE"), front.index("`ansur`: MAE"))
        self.assertIn("Measured: 398 of 400 (`modifiers`), 398 of 400 (`ansur`), 398 of 400 (`ansur`).", " ".join(self.page("README.md").split()))

    def test_figures_of_earlier_versions_are_marked_and_refused(self):
        for dataset, index_format, words in ((23, 13, "dataset 22, code is 23"),
                                             (22, 14, "index format 13, code is 14")):
            with self.subTest(words):
                self.code(22, 13)
                self.succeeds("tables")
                self.code(dataset, index_format)
                self.fails(["check"], words, "scripts/accuracy run")
                self.succeeds("check", "--tables")
                self.succeeds("tables")
                self.assertIn(f"**Measured at {words}.**\n\n| clothing |", self.page("README.md"))
                self.assertEqual(self.page("docs/evaluation.md").count(f"**Measured at {words}.**"), 5)
                self.fails(["check"], words)
                self.succeeds("check", "--tables")
        self.code(22, 13)
        self.succeeds("tables")
        self.assertNotIn("**Measured at", self.page("README.md"))
        self.succeeds("check")

    def test_an_index_without_its_dataset_version_is_of_earlier_code(self):
        for condition, population in EACH:
            self.put(result(condition, population, dataset=None))
        self.succeeds("tables")
        self.fails(["check"], "dataset unknown, code is 22")

    def test_a_table_changed_by_hand_is_found(self):
        self.succeeds("tables")
        for page in ("README.md", "docs/evaluation.md"):
            good = self.page(page)
            self.page(page, good.replace("31 (+14)", "11 (+14)", 1))
            self.fails(["check"], page)
            self.fails(["check", "--tables"], page)
            self.page(page, good)
        self.succeeds("check", "--tables")

    def test_a_missing_or_damaged_result_is_named(self):
        self.succeeds("tables")
        path = self.root / "docs/evaluation/both.ansur.json"
        path.unlink()
        for words in (["tables"], ["check"], ["check", "--tables"]):
            self.fails(words, "docs/evaluation/both.ansur.json is missing", "scripts/accuracy run")
        path.write_text("{")
        self.fails(["check", "--tables"], "docs/evaluation/both.ansur.json is damaged")

    def test_results_of_two_runs_make_no_table(self):
        for difference in ({"commit": "def5678"}, {"people": 20}, {"index_format": 12}):
            with self.subTest(difference):
                self.put(result("noise", "modifiers", **difference))
                self.fails(["tables"], "docs/evaluation/noise.modifiers.json")

    def test_a_population_may_be_of_its_own_commit(self):
        for condition in ("noise", "both", "around"):
            self.put(result(condition, "other", commit="def5678"))
        self.succeeds("tables")
        self.assertEqual(" ".join(self.page("docs/evaluation.md").split()).count(
            "Commit: abc1234 (`ansur`, `modifiers`), def5678 (`other`)."), 3)

    def test_a_measurement_without_true_values_has_no_figures(self):
        entry = result("noise", "other")
        entry["measurements"]["stature"].update(coverage_95=None, interval_width_median=None)
        entry["measurements"]["stature"]["ours"].update(count=0, mae=0.0, bias=0.0)
        self.put(entry)
        self.succeeds("tables")
        self.assertEqual(self.page("docs/evaluation.md").count("| stature, mm | 31 (+14) | 95 % | 125 | – | – | – |"), 1)

    def test_turns_may_be_of_another_commit_and_fewer_people_but_not_of_another_index(self):
        for population in POPULATIONS["around"]:
            self.put(result("around", population, commit="def5678", people=200))
        self.succeeds("tables")
        for population in POPULATIONS["around"]:
            self.put(result("around", population, index_format=12))
        self.fails(["tables"], "index format is 13 of fronts and 12 of turns")

    def test_results_without_a_commit_make_no_table(self):
        for condition, population in EACH:
            self.put(result(condition, population, commit=""))
        self.fails(["tables"], "names no commit")

    def test_tables_and_their_markers_must_be_there(self):
        self.succeeds("tables")
        good = self.page("docs/evaluation.md")
        self.page("docs/evaluation.md", good[:good.index("## garments")])
        self.fails(["check", "--tables"], "garments")
        self.page("docs/evaluation.md", good.removesuffix("<!-- /accuracy -->\n"))
        self.fails(["check", "--tables"], "docs/evaluation.md")
        self.page("docs/evaluation.md", good.replace("accuracy:garments", "accuracy:coats"))
        self.fails(["check", "--tables"], "coats")

    def test_pages_without_a_table_fail_without_results_too(self):
        for entry in (self.root / "docs/evaluation").glob("*.json"):
            entry.unlink()
        for page in ("README.md", "docs/evaluation.md"):
            self.page(page, "# Nothing here\n")
        self.fails(["check", "--tables"], "no page shows the table 'headline'")

    def test_versions_must_be_found_once_in_the_sources(self):
        (self.root / "somewhere/other.cpp").write_text(DATASET.format(21))
        self.fails(["check"], "2 versions of dataset")
        (self.root / "somewhere/other.cpp").unlink()
        (self.root / "index/format.h").unlink()
        self.fails(["check"], "0 versions of index format")

    def fake_lab(self, **environment):
        lab = self.root / "fake-lab"
        lab.write_text(FAKE_LAB)
        lab.chmod(0o755)
        log = self.root / "log"
        log.write_text("")
        words = ["run", "--people", "400", "--lab", str(lab), "--index", "x.i2f", "--commit", "abc1234"]
        done = self.script(*words, FAKE_LOG=str(log), FAKE_RESULTS=str(pathlib.Path(__file__).parent), **environment)
        return done, log.read_text().split("\n")[:-1]

    def test_an_interrupted_run_goes_on_where_it_ended(self):
        for path in (self.root / "docs/evaluation").iterdir():
            path.unlink()
        done, first = self.fake_lab(FAKE_LAB_LIMIT="3")
        self.assertEqual(done.returncode, 1)
        self.assertEqual(len(first), 3)
        self.assertEqual(len(list((self.root / "docs/evaluation").iterdir())), 3)
        done, second = self.fake_lab()
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(sorted(first + second), sorted(f"{c} {p}" for c, p in EACH))
        self.succeeds("tables")
        self.succeeds("check")
        kept = json.loads((self.root / "docs/evaluation/noise.ansur.json").read_text())
        self.assertEqual(kept["measurements"]["stature"]["coverage_95"], 0.95432, "rounded")

    def test_a_result_of_other_versions_people_or_commit_is_measured_again(self):
        for other in ({"dataset": 21}, {"people": 20}, {"commit": "def5678"}):
            self.put(result("noise", "ansur", **other))
            done, measured = self.fake_lab()
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertEqual(measured, ["noise ansur"], other)

    def test_an_index_of_earlier_code_is_not_measured(self):
        done, measured = self.fake_lab(FAKE_DATASET="21")
        self.assertEqual((done.returncode, measured), (1, []))
        self.assertIn("x.i2f was made at dataset 21, code is 22", done.stderr)


if __name__ == "__main__":
    unittest.main()
