#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Arms are not trunk: real people and a made one, through the program.

  arms.py --program IM2FIT          a sample, in under two minutes; exit 1 when a bar is missed, 77 when data is missing
  arms.py --program IM2FIT --all    every start, eroded by 0, 1 and 2 px

Whether an arm is apart from the trunk is judged here by the outline alone, without any joint: in half of the rows about the hips
and of those about the waist background lies between the widest piece and a piece beside it, on both sides.

starts: one frame held for 45 frames. A person whose arms are not apart is not MEASURED but told ARMS_CLOSE.
played: the recording as it is behind a start held for 15 frames: not MEASURED unless most of its frames show arms apart.
apart: frames that do show arms apart are not told ARMS_CLOSE, so that the check does not pass by refusing all people.
cases: ../shared/cases/arms-on-body-real and arms-touch-made.
"""
import argparse
import collections
import importlib.util
import importlib.machinery
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

SKIPPED = 77
HELD = 45  # frames: half as many again as are wanted
TOLD_BAR = 90  # per cent of the starts found, arms not apart, that are told ARMS_CLOSE
APART_BAR = 75  # per cent of the frames with arms apart that are not told ARMS_CLOSE
BANDS = {"hip": (0.46, 0.53), "waist": (0.57, 0.66)}  # of the way from the lowest to the highest pixel
GAP_PX, PIECE_PX, NEAR_PX = 2, 3, 35  # a pixel is some 10 mm
MADE_SLACK_MM = 60  # of a girth that is stated in spite of arms that touch: below the width of an arm


def skip(why):
    print(f"NOTHING_TO_TEST: {why}")
    sys.exit(SKIPPED)


try:
    import numpy as np
    from PIL import Image
except ImportError:
    if os.environ.get("IM2FIT_NO_SKIPS"):
        sys.exit("numpy or Pillow is not here (scripts/deps test), and nothing may be skipped")
    skip("numpy or Pillow is not here (scripts/deps test)")


def neighbour(name):
    """The script beside this one, as a module."""
    path = str(pathlib.Path(__file__).resolve().parent / name)
    sys.dont_write_bytecode = True
    loader = importlib.machinery.SourceFileLoader(name, path)
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader(name, loader))
    loader.exec_module(module)
    return module


def pieces(row):
    """Runs of pixels of a row of the outline, as (first, end); gaps of a pixel do not part them."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], row.astype(int), [0]])))
    joined = []
    for first, end in zip(edges[::2], edges[1::2]):
        if joined and first - joined[-1][1] < GAP_PX:
            joined[-1] = (joined[-1][0], end)
        else:
            joined.append((first, end))
    return joined


def arms_apart(depth):
    """Whether background lies between both arms and the trunk, at the hips and at the waist."""
    mask = depth > 0
    rows = np.nonzero(mask)[0]
    top, bottom = np.percentile(rows, 0.5), np.percentile(rows, 99.5)
    for low, high in BANDS.values():
        seen, gaps = 0, [0, 0]
        for v in range(int(bottom - high * (bottom - top)), int(bottom - low * (bottom - top)) + 1):
            found = pieces(mask[v])
            if not found:
                continue
            seen += 1
            trunk = max(found, key=lambda p: p[1] - p[0])
            wide = [p for p in found if p[1] - p[0] >= PIECE_PX]
            gaps[0] += any(p[1] <= trunk[0] and p[0] > trunk[0] - NEAR_PX for p in wide)
            gaps[1] += any(p[0] >= trunk[1] and p[1] < trunk[1] + NEAR_PX for p in wide)
        if seen < 3 or min(gaps) * 2 < seen:
            return False
    return True


class Arms:
    def __init__(self, options, check, sequences):
        self.options = options
        self.check = check
        self.program = check.Program(options.program)
        self.sequences = sequences
        self.scratch = pathlib.Path(tempfile.mkdtemp(prefix="real-arms-"))
        self.missed = []
        self.report = {}

    def measure(self, sequence, frames, floor=True, erode_px=0):
        folder = self.scratch / "clip"
        shutil.rmtree(folder, ignore_errors=True)
        self.check.write_clip(sequence, frames, folder, floor, erode_px)
        return self.program.measure(folder)

    def miss(self, why):
        self.missed.append(why)

    def starts(self):
        """Calm starts, arms as they hang."""
        told = collections.Counter()
        measured, silent, count, found = [], [], 0, 0
        for erode_px in (0, 1, 2) if self.options.all else (0,):
            for sequence in self.sequences:
                picks = sequence.calm() if self.options.all else sequence.calm()[:1]
                for k in picks:
                    if arms_apart(sequence.frames[k]):
                        continue
                    count += 1
                    result = self.measure(sequence, [k] * HELD, erode_px=erode_px)
                    name = f"{sequence.name}:{k}" + (f"-{erode_px}px" if erode_px else "")
                    codes = result["guidance"]
                    told.update(codes or [result["state"]])
                    if result["state"] == "MEASURED":
                        measured.append(name)
                    if "NO_PERSON" in codes:
                        continue
                    found += 1
                    if "ARMS_CLOSE" not in codes:
                        silent.append(name)
                    elif not result.get("guidance_details", {}).get("arms_close"):
                        self.miss(f"{name}: ARMS_CLOSE names no arm")
        share = 100 * (found - len(silent)) / max(1, found)
        print(f"starts: {count} with arms on the body, {found} found, {len(measured)} MEASURED, {share:.0f} % of those found are told "
              f"ARMS_CLOSE; " + ", ".join(f"{c} {n}" for c, n in told.most_common()), flush=True)
        self.report["starts"] = {"count": count, "found": found, "measured": measured, "silent": silent, "told": dict(told)}
        if measured:
            self.miss("starts MEASURED with arms on the body: " + ", ".join(measured))
        if share < TOLD_BAR:
            self.miss(f"{share:.0f} % told ARMS_CLOSE, {TOLD_BAR} wanted; not told: " + ", ".join(silent))

    def played(self):
        measured, count = [], 0
        for sequence in self.sequences[:: 1 if self.options.all else 3]:
            apart = sum(arms_apart(d) for d in sequence.frames)
            if apart * 2 >= len(sequence.frames) or sequence.seated:
                continue
            count += 1
            result = self.measure(sequence, [sequence.rest] * 15 + list(range(len(sequence.frames))))
            if result["state"] == "MEASURED":
                measured.append(sequence.name)
        print(f"played: {count} recordings, {len(measured)} MEASURED", flush=True)
        self.report["played"] = {"count": count, "measured": measured}
        if measured:
            self.miss("recordings MEASURED: " + ", ".join(measured))

    def apart(self):
        """Held frames with arms apart. Girths of each person, over frames and arms, for those who are measured."""
        count, fine, refused = 0, 0, []
        girths = collections.defaultdict(list)
        for sequence in self.sequences:
            for k, depth in enumerate(sequence.frames):
                if not arms_apart(depth):
                    continue
                result = self.measure(sequence, [k] * HELD)
                codes = result["guidance"]
                if "NO_PERSON" in codes:
                    continue
                count += 1
                fine += "ARMS_CLOSE" not in codes
                if "ARMS_CLOSE" in codes:
                    refused.append(f"{sequence.name}:{k} {'+'.join(result.get('guidance_details', {}).get('arms_close', []))}")
                if result["measurements"]:
                    girths[sequence.person].append(
                        {g: result["measurements"][f"{g}_girth"]["value"] for g in ("chest", "waist", "hip")})
        share = 100 * fine / max(1, count)
        print(f"apart: {count} frames, {share:.0f} % not told ARMS_CLOSE", flush=True)
        for person, values in girths.items():
            spans = ", ".join(f"{g} {min(v[g] for v in values):.0f} to {max(v[g] for v in values):.0f}" for g in values[0])
            print(f"apart: {person} measured {len(values)} times: {spans} mm", flush=True)
        self.report["apart"] = {"count": count, "percent": share, "refused": refused, "girths": dict(girths)}
        if count == 0 or share < APART_BAR:
            self.miss(f"{share:.0f} % of {count} frames with arms apart not told ARMS_CLOSE, {APART_BAR} wanted: " + ", ".join(refused))

    def cases(self, shared):
        real, made = shared / "cases/arms-on-body-real", shared / "cases/arms-touch-made"
        if not real.exists() or not made.exists():
            print(f"cases: not in {shared}", flush=True)
            return
        folder = self.scratch / "real"
        folder.mkdir()
        shutil.copy(real / "camera.yaml", folder)
        for i in range(30):
            shutil.copy(real / "000000.png", folder / f"{i:06d}.png")
        result = self.program.measure(folder)
        print(f"cases: arms-on-body-real {result['state']} {result['guidance']} {result.get('guidance_details')}", flush=True)
        if result["state"] == "MEASURED" or result.get("guidance_details", {}).get("arms_close") != ["left", "right"]:
            self.miss("arms-on-body-real: ARMS_CLOSE of both arms wanted")
        folder = self.scratch / "made"
        shutil.copytree(made, folder, ignore=shutil.ignore_patterns("truth.json"))
        result = self.program.measure(folder)
        print(f"cases: arms-touch-made {result['state']} {result['guidance']} {result.get('guidance_details')}", flush=True)
        if result["state"] == "MEASURED":
            truth = json.loads((made / "truth.json").read_text())
            for girth in ("chest_girth", "waist_girth", "hip_girth"):
                error = result["measurements"][girth]["value"] - truth[f"{girth}_mm"]
                if abs(error) > MADE_SLACK_MM:
                    self.miss(f"arms-touch-made: {girth} off by {error:+.0f} mm")
        elif "ARMS_CLOSE" not in result["guidance"]:
            self.miss("arms-touch-made: neither measured nor told ARMS_CLOSE")

    def run(self, shared):
        try:
            self.cases(shared)
            self.starts()
            self.apart()
            self.played()
        finally:
            shutil.rmtree(self.scratch)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", required=True, metavar="IM2FIT", help="im2fit, with its files in the environment or the cache")
    parser.add_argument("--shared", default=os.environ.get("IM2FIT_SHARED") or str(pathlib.Path(__file__).resolve().parents[3] / "shared"),
                        metavar="DIR", help="the shared folder (default: IM2FIT_SHARED, or beside the checkout)")
    parser.add_argument("--all", action="store_true", help="every calm start, eroded by 0, 1 and 2 px, and every recording")
    parser.add_argument("--json", metavar="FILE", help="the report as JSON")
    options = parser.parse_args()
    shared = pathlib.Path(options.shared)
    folders = [f for group in ("utd", "msr") for f in sorted((shared / "data/real/people" / group).glob("a*"))]
    if not folders:
        skip(f"no real people in {shared}: set IM2FIT_SHARED to the shared folder")
    usable = subprocess.run([options.program, "measure", str(shared / "cases/no-such-folder")], capture_output=True, text=True)
    if "index" in usable.stderr or "tracker" in usable.stderr:
        skip(usable.stderr.strip())
    check = neighbour("check")
    arms = Arms(options, check, [check.Sequence(f) for f in folders])
    arms.run(shared)
    if options.json:
        pathlib.Path(options.json).write_text(json.dumps(arms.report, indent=1))
    for missed in arms.missed:
        print(f"MISSED: {missed}")
    return 1 if arms.missed else 0


if __name__ == "__main__":
    sys.exit(main())
