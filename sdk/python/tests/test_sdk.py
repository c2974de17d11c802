# SPDX-License-Identifier: Apache-2.0
"""The Python package on the golden clip: IM2FIT_LIBRARY is libim2fit.so, IM2FIT_GOLDEN the folder of tests/golden/data,
IM2FIT_BODY the body file, IM2FIT_CAMERAS_LIBRARY libim2fit-cameras.so, IM2FIT_RECORDING a .oni of the clip (without one, what
needs it is left out, with a message)."""

import ctypes
import importlib.util
import json
import math
import os
import pathlib
import pickle
import re
import shutil
import struct
import subprocess
import sys
import sysconfig
import tempfile
import unittest

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, os.environ.get("IM2FIT_PYTHON", str(HERE.parent)))
sys.path.append(str(HERE.parent))
import numpy as np  # noqa: E402

import im2fit  # noqa: E402
import make_wheel  # noqa: E402
from im2fit import _c, _camera, _folder  # noqa: E402

GOLDEN = pathlib.Path(os.environ.get("IM2FIT_GOLDEN", HERE.parents[2] / "tests/golden/data"))
INCLUDE = HERE.parents[2] / "capi/include"
HEADER = INCLUDE / "im2fit/im2fit.h"
CAMERAS = os.environ.get("IM2FIT_CAMERAS_LIBRARY", "")
RECORDING = os.environ.get("IM2FIT_RECORDING", "")  # of the golden clip
BODY = os.environ.get("IM2FIT_BODY", "")
FRAMES = {"frames_wanted": 6, "frames_min": 5}  # of the clip's 8


# The enumerations of the header, by the part of their names that is the same.
ENUMERATIONS = {"STATE_": im2fit.State, "GUIDANCE_": im2fit.GuidanceCode, "VIEW_": im2fit.View, "SENSOR_": im2fit.Sensor,
                "CLOTHING_": im2fit.Clothing, "SEX_": im2fit.Sex, "TAPE_": im2fit.TapeStatus, "FIT_": im2fit.Verdict,
                "ERROR_": im2fit.Status, "TURN_": im2fit.Turn}


def has(*modules):
    return all(importlib.util.find_spec(module) for module in modules)


def models(body=None):
    return im2fit.Models(body=body or BODY, tracker=str(GOLDEN / "tracker.i2t"), index=str(GOLDEN / "index.i2f"))


class Layout(unittest.TestCase):
    def printed(self, lines):
        """What a C program with these statements prints."""
        compiler = shutil.which("cc")
        self.assertTrue(compiler, "needs a C compiler")
        lines = ["#include <stddef.h>", "#include <stdio.h>", "#include <im2fit/cameras.h>", "int main(void) {", *lines,
                 "  return 0;\n}"]
        with tempfile.TemporaryDirectory() as folder:
            source = pathlib.Path(folder) / "layout.c"
            source.write_text("\n".join(lines))
            program = pathlib.Path(folder) / "layout"
            subprocess.run([compiler, "-I", str(INCLUDE), str(source), "-o", str(program)], check=True)
            output = subprocess.run([str(program)], check=True, capture_output=True, text=True).stdout
        return output.split("\n")[:-1]

    def test_structs_are_the_headers(self):
        lines, expected = [], []
        for name, struct in _c.STRUCTS.items():
            lines.append(f'  printf("{name} %zu\\n", sizeof({name}));')
            expected.append(f"{name} {ctypes.sizeof(struct)}")
            for field in struct._fields_:
                lines.append(f'  printf("{name}.{field[0]} %zu\\n", offsetof({name}, {field[0]}));')
                expected.append(f"{name}.{field[0]} {getattr(struct, field[0]).offset}")
        self.assertEqual(self.printed(lines), expected)

    def test_enumerations_are_the_headers(self):
        text = re.sub(r"/\*.*?\*/", "", HEADER.read_text(), flags=re.S)
        names = re.findall(r"\bIM2FIT_(\w+)", " ".join(re.findall(r"\benum \w+ \{(.*?)\}", text, re.S)))
        numbers = {"OK": im2fit.Status.OK, "FORMAT_U16": _c.FORMAT_U16, "FORMAT_DEPTH16": _c.FORMAT_DEPTH16,
                   "FORMAT_F32": _c.FORMAT_F32, **{f"AVATAR_{kind.upper()}": number for kind, number in _c.AVATAR_FORMATS.items()}}
        for prefix, kind in ENUMERATIONS.items():
            members = {member.name for member in kind} - {"OK"}
            self.assertEqual(members, {name[len(prefix):] for name in names if name.startswith(prefix)}, f"IM2FIT_{prefix}")
            numbers.update({prefix + name: kind[name] for name in members})
        self.assertEqual(self.printed([f'  printf("{name} %d\\n", (int)IM2FIT_{name});' for name in numbers]),
                         [f"{name} {int(number)}" for name, number in numbers.items()])

    def test_names_are_the_librarys(self):
        lib = im2fit._lib()
        for state in im2fit.State:
            self.assertEqual(lib.im2fit_state_name(state).decode(), f"{state}")
        for code in im2fit.GuidanceCode:  # Person.guidance finds the codes of result.json by these names
            self.assertEqual(lib.im2fit_guidance_name(code.value.bit_length() - 1).decode(), str(code))
        for verdict in im2fit.Verdict:
            self.assertEqual(lib.im2fit_fit_name(verdict).decode().upper(), verdict.name)
        for status in im2fit.Status:
            self.assertEqual(im2fit.Error(status, "").name.upper(), "OK" if status == 0 else status.name)
        self.assertEqual(repr(im2fit.Sex.WOMAN), "Sex.WOMAN")
        self.assertEqual((int(im2fit.State(99)), str(im2fit.State(99))), (99, "NUMBER_99"))  # of a newer library
        with self.assertRaisesRegex(ValueError, "woman"):
            im2fit.Sex("woman")
        self.assertEqual(im2fit.joint_names(), "HE NE TO LS RS LE RE LA RA LH RH LK RK LF RF".split())
        self.assertEqual(im2fit.tape_names()["thigh_girth"], "Thigh girth")
        self.assertEqual(list(im2fit.tape_names("de")), list(im2fit.tape_names()))
        with self.assertRaisesRegex(ValueError, "'tlh': expected en"):
            im2fit.tape_names("tlh")

    def test_guidance_has_the_pages_words(self):
        folder = HERE.parents[2] / "apps/kiosk/web/lang"
        for language in ("en", "de", "es", "fr", "zh"):
            said = json.loads((folder / f"{language}.json").read_text(encoding="utf-8"))["say"]
            self.assertEqual({str(code): im2fit.guidance_text(code, language) for code in im2fit.GuidanceCode},
                             {str(code): said[str(code)] for code in im2fit.GuidanceCode}, language)
        self.assertEqual(im2fit.guidance_text(im2fit.GuidanceCode.TOO_NEAR), "Step back")
        with self.assertRaisesRegex(ValueError, "'it': expected en"):
            im2fit.guidance_text(im2fit.GuidanceCode.TOO_NEAR, "it")
        with self.assertRaisesRegex(ValueError, "no text"):
            im2fit.guidance_text(im2fit.GuidanceCode(1 << 30))

    def test_settings_are_the_headers(self):
        whole = {name for name, kind in _c.Settings._fields_ if kind is ctypes.c_int32}
        self.assertEqual(set(im2fit.Settings.__annotations__), whole - {"width", "height"})  # arguments of their own

    def test_the_library_is_the_headers(self):
        numbers = re.findall(r"#define IM2FIT_VERSION_(?:MAJOR|MINOR|PATCH) (\d+)", HEADER.read_text())
        self.assertEqual(im2fit.version(), ".".join(numbers))
        self.assertEqual(im2fit.__version__, ".".join(numbers))


class Poses(unittest.TestCase):
    def test_a_matrix_is_seven_numbers(self):
        def matrix_of(x, y, z, w):
            return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                             [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                             [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])
        random = np.random.default_rng(57)
        # Half turns too, where three of the four squares vanish.
        for turn in (*np.eye(4), *random.normal(size=(200, 4))):
            turn = turn / np.linalg.norm(turn)
            pose = np.eye(4)
            pose[:3, :3], pose[:3, 3] = matrix_of(*turn), (0.1, -2, 3)
            found = np.array(_camera.pose_of(pose))
            np.testing.assert_allclose(found[:4] * np.sign(found[:4] @ turn), turn, atol=1e-12)
            np.testing.assert_allclose(found[4:], (100, -2000, 3000))  # mm
            self.assertEqual(_camera.pose_of(pose.tolist()), list(found))
        self.assertEqual(_camera.pose_of((1, 2, 3, 4, 5, 6, 7)), [1, 2, 3, 4, 5, 6, 7])

    def test_what_is_no_pose_is_named(self):
        mirrored, scaled, sheared = np.diag([1, 1, -1, 1]), np.diag([2, 2, 2, 1]), np.eye(4)
        sheared[3] = (0, 0, 1, 0)
        for bad in (mirrored, scaled, sheared, np.full((4, 4), np.nan)):
            with self.assertRaisesRegex(ValueError, "not a rigid motion"):
                _camera.pose_of(bad)
        with self.assertRaisesRegex(ValueError, r"\(3, 4\), expected a 4x4"):
            _camera.pose_of(np.eye(4)[:3])


class Folder(unittest.TestCase):
    def test_a_folder_is_a_camera_and_frames(self):
        folder = im2fit.read_folder(GOLDEN / "clip")
        self.assertEqual(folder.camera, _folder.read_camera(GOLDEN / "clip/camera.yaml"))
        frames = list(folder)
        self.assertEqual([frame.sequence for frame in frames], [number for number, _ in _folder.frames_of(GOLDEN / "clip")])
        self.assertEqual(len(frames), len(folder))
        for frame in frames:
            self.assertEqual((frame.depth.shape, frame.depth.dtype), ((folder.camera.height, folder.camera.width), np.uint16))
        self.assertEqual(sorted(frame.time_ns for frame in frames), [frame.time_ns for frame in frames])

    def test_png_is_read_the_same_without_pillow(self):
        if _folder.Image is None:
            self.skipTest("no Pillow to compare with")
        _, path = _folder.frames_of(GOLDEN / "clip")[0]
        with_pillow, kept = _folder.read_png(path), _folder.Image
        _folder.Image = None
        try:
            np.testing.assert_array_equal(_folder.read_png(path), with_pillow)
        finally:
            _folder.Image = kept

    def test_what_is_wrong_is_named(self):
        with tempfile.TemporaryDirectory() as folder:
            with self.assertRaisesRegex(FileNotFoundError, "no depth frames"):
                _folder.frames_of(folder)
            text = (GOLDEN / "clip/camera.yaml").read_text()
            bad = pathlib.Path(folder) / "camera.yaml"
            bad.write_text(text.replace("data: [0, 0, 0, 0, 0]", "data: [0.1, 0, 0, 0, 0, 1, 0, 0]"))
            with self.assertRaisesRegex(ValueError, "8 distortion_coefficients"):
                _folder.read_camera(bad)
            bad.write_text(text.replace("data: [0, 0, 0, 0, 0]", "data: [0.1, 0.2, 0.3, 0.4, 0.5]"))
            self.assertEqual(_folder.read_camera(bad).distortion, (0.1, 0.2, 0.3, 0.4, 0.5))
            bad.write_text(text.replace("image_width", "width"))
            with self.assertRaisesRegex(ValueError, "image_width"):
                _folder.read_camera(bad)


@unittest.skipUnless(CAMERAS, "IM2FIT_CAMERAS_LIBRARY names no library")
class Cameras(unittest.TestCase):
    @staticmethod
    def children():
        names = []
        for path in pathlib.Path("/proc").glob("[0-9]*/stat"):
            try:
                name, parent = re.match(r"\d+ \((.*)\) \S (\d+)", path.read_text()).groups()
            except OSError:  # it has ended meanwhile
                continue
            if int(parent) == os.getpid():
                names.append(name)
        return names

    def test_a_recording_is_measured_as_its_frames_are(self):
        self.assertTrue(RECORDING, "IM2FIT_RECORDING names no recording")
        bare = im2fit.Models(body="", tracker=str(GOLDEN / "tracker.i2t"), index=str(GOLDEN / "index.i2f"))
        texts, joints = [], []
        for uri in (GOLDEN / "clip", RECORDING, None):
            camera = _folder.read_camera(GOLDEN / "clip/camera.yaml")
            session = im2fit.Session(**vars(camera), models=bare, **FRAMES) if uri is None else \
                im2fit.Session.of(uri, models=bare, **FRAMES)
            with session:
                if uri == RECORDING:  # read by a process of its own, found beside the library
                    self.assertEqual(self.children(), ["im2fit-oni-read"])
                for number, path in _folder.frames_of(GOLDEN / "clip"):
                    if uri is None:
                        session.push(_folder.read_frame(path), sequence=number)
                    else:
                        self.assertIsNotNone(session.pump())
                if uri is not None:
                    self.assertIsNone(session.pump())
                    session.detach()
                    with self.assertRaisesRegex(im2fit.Error, "no source is attached"):
                        session.pump()
                person = session.finish()
                self.assertTrue(person.measured, person.guidance)
                self.assertEqual(person.tape(), {})
                self.assertGreater(len(person.sizes), 3)
                with self.assertRaisesRegex(im2fit.Error, "body"):
                    person.avatar()
                texts.append(person.result["measurements"])
                joints.append(session.joints().tobytes())
        self.assertEqual(texts[0], texts[2])
        self.assertEqual(texts[1], texts[2])
        self.assertEqual(joints, joints[:1] * 3)

    def test_a_damaged_index_ends_the_measurement(self):
        data = bytearray((GOLDEN / "index.i2f").read_bytes())
        paged = 0
        for at in range(32, 32 + 40 * struct.unpack_from("<I", data, 12)[0], 40):  # the section table: core/container.cpp
            offset, size, _, page = struct.unpack_from("<QQII", data, at + 16)
            for byte in range(offset, offset + size if page else offset, 64):
                data[byte] ^= 0x55
                paged += 1
        self.assertGreater(paged, 0)
        with tempfile.TemporaryDirectory() as folder:
            index = pathlib.Path(folder) / "index.i2f"
            index.write_bytes(data)
            damaged = im2fit.Models(body="", tracker=str(GOLDEN / "tracker.i2t"), index=str(index))
            with im2fit.Session.of(GOLDEN / "clip", models=damaged, single_thread=1, **FRAMES) as session:
                with self.assertRaisesRegex(im2fit.Error, "index.i2f: .* damaged") as caught:
                    for _ in range(1000):
                        self.assertIsNotNone(session.pump())
                self.assertEqual(caught.exception.name, "corrupt")
            with self.assertRaisesRegex(im2fit.Error, "index.i2f: .* damaged"):
                im2fit.measure(GOLDEN / "clip", rotate_deg=90, models=damaged, **FRAMES)

    def test_what_cannot_be_opened_is_said(self):
        with self.assertRaisesRegex(im2fit.Error, "telepathy:1 does not exist") as caught:
            im2fit.measure("telepathy:1", models=models("b"))
        self.assertEqual(caught.exception.name, "not_found")
        with self.assertRaisesRegex(im2fit.Error, "45"):
            im2fit.Session.of(GOLDEN / "clip", rotate_deg=45, models=models("b"))
        with self.assertRaisesRegex(im2fit.Error, "v4l2|nonexistent"):
            im2fit.Session.of("v4l2:/dev/nonexistent", models=models("b"))
        kept = os.environ.pop("IM2FIT_CAMERAS_LIBRARY")
        os.environ["IM2FIT_CAMERAS_LIBRARY"] = "/nonexistent.so"
        try:
            with self.assertRaisesRegex(OSError, "libim2fit-cameras0"):
                _c.load_cameras()
        finally:
            os.environ["IM2FIT_CAMERAS_LIBRARY"] = kept


class Errors(unittest.TestCase):
    def test_a_failure_has_a_status_and_a_text(self):
        with self.assertRaises(im2fit.Error) as caught:
            im2fit.Session(320, 240, 287.9, 287.9, 159.5, 119.5, models=im2fit.Models("b", "/nonexistent.i2t", "i"))
        self.assertIn(caught.exception.name, ("not_found", "io"))
        with self.assertRaises(TypeError):
            im2fit.Session(320, 240, 288, 288, 160, 120, models=models("b"), colour=1)
        with self.assertRaisesRegex(TypeError, "sensor is 'time_of_flight', expected one of im2fit.Sensor"):
            im2fit.Session(320, 240, 288, 288, 160, 120, models=models("b"), sensor="time_of_flight")
        for missing in ("/nonexistent/folder", "nonexistent.oni"):
            with self.assertRaisesRegex(FileNotFoundError, f"{missing} does not exist"):
                im2fit.measure(missing, models=models("b"))
        with self.assertRaisesRegex(ValueError, "kind 'fbx': expected one of glb, obj, bvh"):
            im2fit.measure(GOLDEN / "clip", models=models("b"), avatars=("fbx",))
        with self.assertRaises(ValueError):
            im2fit.Session(320, 240, 288, 288, 160, 120, rotate_deg=45, models=models("b"))

    def test_no_models_says_what_to_do(self):
        kept = dict(os.environ)
        for key in ("IM2FIT_BODY", "IM2FIT_TRACKER", "IM2FIT_INDEX"):
            os.environ.pop(key, None)
        os.environ.update(XDG_DATA_HOME="/nonexistent", XDG_CACHE_HOME="/nonexistent", XDG_DATA_DIRS="/nonexistent")
        try:
            with self.assertRaisesRegex(FileNotFoundError, "im2fit models install"):
                im2fit.Models.find()
        finally:
            os.environ.clear()
            os.environ.update(kept)
        with tempfile.TemporaryDirectory() as folder:  # a directory that is given: neither another nor the environment
            with self.assertRaisesRegex(FileNotFoundError, f"{folder}: expected body.i2b, tracker.i2t, .* --to {folder}"):
                im2fit.measure(GOLDEN / "clip", models=folder)
            pack = pathlib.Path(folder) / "models.i2p"
            pack.write_bytes(b"I2PK\x01\0\0\0")
            with self.assertRaisesRegex(im2fit.Error, "models.i2p is a model pack of format 1, older than the 2"):
                im2fit.measure(GOLDEN / "clip", models=pack)
            self.assertEqual(im2fit.Models.find(pack).tracker, str(pack))


@unittest.skipUnless(BODY and pathlib.Path(BODY).exists(), "IM2FIT_BODY names no body file")
class Measuring(unittest.TestCase):
    def test_a_folder_is_measured(self):
        person = im2fit.measure(GOLDEN / "clip", models=models(), avatars=("glb", "obj", "bvh"), **FRAMES)
        self.assertTrue(person.measured, person.guidance)
        golden = json.loads((GOLDEN / "result.json").read_text())
        for key in ("stature", "inside_leg"):  # lengths of the golden result, made without a body: the same person
            self.assertAlmostEqual(person.measurements[key].value, golden["measurements"][key]["value"], delta=30)
        chest = person.measurements["chest_girth"]
        self.assertTrue(chest.low < chest.value < chest.high and chest.unit == "mm")
        self.assertIn("size", repr(person))
        self.assertIn("chest_girth", person._repr_html_())
        self.assertEqual(person.avatar("glb")[:4], b"glTF")
        self.assertTrue(person.avatar("obj").startswith(b"# im2fit avatar"))
        self.assertTrue(person.avatar("bvh").startswith(b"HIERARCHY"))
        if CAMERAS and RECORDING:
            recorded = im2fit.measure(RECORDING, models=models(), **FRAMES)
            self.assertEqual(recorded.measurements, person.measurements)

    def test_the_mask_is_the_persons(self):
        folder = im2fit.read_folder(GOLDEN / "clip")
        with im2fit.Session(**vars(folder.camera), models=models(), single_thread=1, **FRAMES) as session:
            self.assertIsNone(session.mask())
            frames = list(folder)
            progress = session.push(**vars(frames[1]))
            self.assertEqual(progress.frames_wanted, FRAMES["frames_wanted"])
            mask, user = session.mask(), session.users()[0]
            height, width = frames[1].depth.shape[::-1]  # the clip lies on its side
            self.assertEqual((mask.pixels.shape, mask.pixels.dtype), ((height, width), np.bool_))
            self.assertEqual((mask.sequence, mask.time_ns, mask.user_id), (frames[1].sequence, frames[1].time_ns, user.id))
            rows, columns = np.nonzero(mask.pixels)
            # The box is made on a coarser picture, and the feet are found after it.
            np.testing.assert_allclose((columns.min(), columns.max(), rows.min(), rows.max()),
                                       (user.left, user.right, user.top, user.bottom), atol=10)
            self.assertGreater(mask.pixels.mean(), 0.03)
            session.reset()
            self.assertIsNone(session.mask())

    def test_a_diagnosis_names_the_unit_in_which_a_person_is_found(self):
        folder = im2fit.read_folder(GOLDEN / "clip")
        with im2fit.Session(**vars(folder.camera), models=models(), single_thread=1, **FRAMES) as session:
            depth = next(iter(folder)).depth
            self.assertEqual(session.diagnose(depth), im2fit.Diagnosis("", "", 0, 0))
            found = session.diagnose(4 * depth)
            self.assertEqual((found.code, found.unit_mm), ("UNIT", 0.25))
            self.assertEqual(found.text, "values look like quarters of a millimetre; try --unit 0.25")
            with self.assertRaisesRegex(ValueError, "expected uint16"):
                session.diagnose(depth.astype(np.float32))

    def test_an_avatar_is_made_when_asked(self):
        folder = im2fit.read_folder(GOLDEN / "clip")
        with im2fit.Session(**vars(folder.camera), models=models(), **FRAMES) as session:
            for frame in folder:
                session.push(**vars(frame))
            person = session.finish()
            self.assertEqual(person._avatars, {})
            self.assertEqual(person.avatar("bvh")[:9], b"HIERARCHY")
            self.assertIs(person.avatar("bvh"), person.avatar("bvh"))
            with self.assertRaisesRegex(ValueError, "kind 'fbx'"):
                person.avatar("fbx")
            # Other facts make another avatar, which is not that of this result.
            session.set_known(weight_kg=person.measurements["weight"].value + 3, weight_sd_kg=0.7)
            self.assertEqual(person.avatar("bvh")[:9], b"HIERARCHY")  # made before
            with self.assertRaisesRegex(ValueError, r"gone on.*avatars=\('glb',\)"):
                person.avatar("glb")
            corrected = session.finish()
            self.assertNotEqual(corrected.avatar("bvh"), person.avatar("bvh"))
        with self.assertRaisesRegex(ValueError, "has ended"):
            corrected.avatar("glb")
        copy = pickle.loads(pickle.dumps(corrected))  # to another process
        self.assertEqual((copy.json, copy.sizes, copy.avatar("bvh")),
                         (corrected.json, corrected.sizes, corrected.avatar("bvh")))
        with self.assertRaisesRegex(ValueError, "has ended"):
            copy.avatar("glb")

    def test_the_tape_and_the_sizes_are_the_results(self):
        person = im2fit.measure(GOLDEN / "clip", models=models(), **FRAMES)
        tape = person.tape()
        self.assertEqual(list(tape), list(im2fit.tape_names()))
        for key, value in tape.items():
            entry = person.result["tape"].get(key)
            if value.status is not im2fit.TapeStatus.MEASURED:
                self.assertTrue(math.isnan(value.value) and value.reason and not (entry and entry["value"]), key)
                continue
            self.assertAlmostEqual(value.value, entry["value"], delta=0.06)  # result.json has tenths
            self.assertTrue(value.low < value.value < value.high and not value.reason, key)
            self.assertEqual(value.unit, entry["unit"])
            self.assertEqual(f"ISO 8559-1:2017 {value.iso}" if value.iso else None, entry["iso"])
        self.assertIs(tape["head_girth"].status, im2fit.TapeStatus.REFUSED)
        self.assertIn(person.size, person.sizes)
        self.assertEqual(max(person.sizes, key=person.sizes.get), person.size)
        self.assertAlmostEqual(sum(person.sizes.values()), 1, places=5)
        for size, probability in person.result["size"]["probabilities"].items():
            self.assertAlmostEqual(person.sizes[size], probability, delta=6e-5)

    def test_what_is_known_is_used_or_doubted(self):
        folder = im2fit.read_folder(GOLDEN / "clip")
        with im2fit.Session(**vars(folder.camera), models=models(), **FRAMES) as session:
            for frame in folder:
                session.push(**vars(frame))
            seen = session.finish()
            weight = seen.measurements["weight"].value
            session.set_known(weight_kg=weight + 2, weight_sd_kg=0.7, sex=im2fit.Sex.MAN)
            known = session.finish()
            self.assertEqual((known.doubted, known.female), ((), 0))
            self.assertLess(abs(known.measurements["weight"].value - weight - 2), 1)
            self.assertGreater(known.tape()["waist_girth"].value, seen.tape()["waist_girth"].value)
            session.set_known(weight_kg=weight + 80, weight_sd_kg=0.7)
            self.assertEqual(session.finish().doubted, ("weight",))
            session.set_known()
            self.assertEqual(session.finish().measurements, seen.measurements)
            with self.assertRaisesRegex(im2fit.Error, "known weight: expected 15 to 400 kg"):
                session.set_known(weight_kg=1)

    def test_one_of_the_people_in_view_is_selected(self):
        folder = im2fit.read_folder(GOLDEN / "clip")
        with im2fit.Session(**vars(folder.camera), models=models(), single_thread=1, **FRAMES) as session:
            self.assertEqual(session.users(), [])
            frames = list(folder)
            guidance = session.push(**vars(frames[0]))
            self.assertEqual((guidance.view, guidance.state.name), (im2fit.View.FRONT, str(guidance.state)))
            [user] = session.users()
            width, height = folder.camera.height, folder.camera.width  # upright
            self.assertTrue(0 <= user.left < user.right < width and 0 <= user.top < user.bottom < height, user)
            self.assertTrue(2000 < user.z < 3000, user)
            session.select_user(user.id + 7)  # nobody
            for frame in frames:
                self.assertEqual(session.push(**vars(frame)).frames_used, 0)
            session.select_user(session.users()[0].id)
            for frame in frames:
                session.push(**vars(frame))
            self.assertTrue(session.finish().measured)
            with self.assertRaisesRegex(im2fit.Error, "user id -1: ids are 1 and up"):
                session.select_user(-1)

    @unittest.skipUnless(has("pandas"), "no pandas (scripts/deps test)")
    def test_a_person_is_a_table(self):
        person = im2fit.measure(GOLDEN / "clip", models=models(), **FRAMES)
        frame = person.to_frame()
        self.assertEqual((list(frame.columns), frame.index.name), (["value", "low", "high", "unit"], "measurement"))
        self.assertEqual({key: im2fit.Estimate(*row) for key, row in zip(frame.index, frame.itertuples(index=False))},
                         person.measurements)
        tape = person.to_frame(tape=True)
        self.assertEqual(len(tape), len(person.tape()))
        self.assertEqual(tape.loc["thigh_girth", "value"], person.tape()["thigh_girth"].value)
        nobody = im2fit.Person({"state": "SEARCHING", "guidance": []}, "", {}, {}, lambda kind: b"")
        self.assertEqual((len(nobody.to_frame()), list(nobody.to_frame().columns)), (0, list(frame.columns)))

    @unittest.skipUnless(has("matplotlib"), "no matplotlib (scripts/deps test)")
    def test_a_person_is_a_picture(self):
        import matplotlib
        matplotlib.use("agg")
        person = im2fit.measure(GOLDEN / "clip", models=models(), **FRAMES)
        axes = person.plot()
        shown = [label.get_text() for label in axes.get_yticklabels()]
        self.assertEqual(shown, [key.replace("_", " ") for key, e in person.measurements.items() if e.unit == "mm"])
        points = axes.lines[0].get_xdata()
        self.assertEqual(list(points), [e.value for e in person.measurements.values() if e.unit == "mm"])
        self.assertIs(person.plot(axes), axes)
        axes.figure.canvas.draw()
        nobody = im2fit.Person({"state": "SEARCHING", "guidance": []}, "", {}, {}, lambda kind: b"")
        nobody.plot().figure.canvas.draw()

    def test_optional_packages_are_named(self):
        nobody = im2fit.Person({"state": "SEARCHING", "guidance": []}, "", {}, {}, lambda kind: b"")
        for module, call in (("pandas", nobody.to_frame), ("matplotlib.pyplot", nobody.plot)):
            kept = sys.modules.get(module)
            sys.modules[module] = None  # as if it were not installed
            try:
                with self.assertRaisesRegex(ImportError, f"needs {module.split('.')[0]}: install python3-"):
                    call()
            finally:
                del sys.modules[module]
                if kept:
                    sys.modules[module] = kept

    def test_intrinsics_of_a_frame_replace_those_of_the_session(self):
        folder = im2fit.read_folder(GOLDEN / "clip")
        camera = vars(folder.camera)
        own, people = (camera["fx"], camera["fy"], camera["cx"], camera["cy"]), []
        for opened, given in ((camera, None), ({**camera, "fx": 1.2 * own[0], "fy": 1.2 * own[1]}, own)):
            with im2fit.Session(**opened, models=models(), **FRAMES) as session:
                for frame in folder:
                    session.push(frame.depth, frame.time_ns, frame.sequence, intrinsics=given)
                people.append(session.finish().measurements)
        self.assertEqual(people[0], people[1])

    def test_metres_are_millimetres_and_the_mesh_is_the_person(self):
        camera = _folder.read_camera(GOLDEN / "clip/camera.yaml")
        texts = []
        for metres in (False, True):
            words = (camera.width, camera.height, camera.fx, camera.fy, camera.cx, camera.cy, camera.rotate_deg)
            with im2fit.Session(*words, models=models(), **FRAMES) as session:
                for number, path in _folder.frames_of(GOLDEN / "clip"):
                    depth = _folder.read_frame(path)
                    session.push(depth.astype(np.float32) / np.float32(1000) if metres else depth, sequence=number)
                person = session.finish()
                texts.append(person.json)
                self.assertEqual(session.joints().shape, (15, 4))
                vertices, triangles = session.mesh()
                self.assertAlmostEqual(float(vertices[:, 1].min()), 0, places=3)
                self.assertLess(abs(np.ptp(vertices[:, 1]) - person.measurements["stature"].value), 60)  # posed
                self.assertEqual(triangles.max() + 1, len(vertices))
                residual = session.residual()
                self.assertEqual(set(residual), set(person.measurements))
                tape = person.tape()["waist_girth"].value  # the mesh's
                self.assertAlmostEqual(residual["waist_girth"], tape - person.measurements["waist_girth"].value, delta=0.2)
        self.assertEqual(texts[0], texts[1])

    def test_garments_and_the_rig(self):
        camera = _folder.read_camera(GOLDEN / "clip/camera.yaml")
        words = (camera.width, camera.height, camera.fx, camera.fy, camera.cx, camera.cy, camera.rotate_deg)
        with im2fit.Session(*words, models=models(), **FRAMES) as session:
            known = session.models()
            self.assertGreater(known["captures"], known["people"] - 1)
            self.assertGreater(known["people"], 0)
            self.assertIs(known["has_body"], True)
            self.assertIs(known["site_corrected"], False)
            with self.assertRaisesRegex(im2fit.Error, "nothing is measured"):
                session.fit("t_shirt")
            for number, path in _folder.frames_of(GOLDEN / "clip"):
                session.push(_folder.read_frame(path), sequence=number)
            person = session.finish()
            self.assertTrue(person.measured)
            self.assertIn("t_shirt", im2fit.garments())
            fit = session.fit("t_shirt")
            self.assertIn(fit.best, fit.sizes)
            ease, verdict = fit.sizes[fit.best]["chest"]
            self.assertTrue(ease.low < ease.value < ease.high)
            self.assertIsInstance(verdict, im2fit.Verdict)
            eases = [places["chest"][0].value for places in fit.sizes.values()]
            self.assertEqual(eases, sorted(eases))
            self.assertEqual(session.dressed_avatar("t_shirt"), session.dressed_avatar(("t_shirt", fit.best)))
            everyday = session.dressed_avatar()
            self.assertEqual(everyday[:4], b"glTF")
            self.assertIn(b'"name":"trousers"', everyday)
            with self.assertRaisesRegex(im2fit.Error, "toga"):
                session.dressed_avatar("toga")
            root, rotations = session.rig()
            self.assertTrue(0.6 < root[1] < 1.2)
            np.testing.assert_allclose(np.linalg.norm(rotations, axis=1), 1, atol=1e-5)
            self.assertEqual(im2fit.rig_nodes()[0], "pelvis")
            parents = im2fit.rig_node_parents()
            self.assertEqual((parents[0], len(parents)), (-1, len(im2fit.rig_nodes())))
            self.assertTrue(all(parent < node for node, parent in enumerate(parents)))
            self.assertEqual(list(im2fit.garment_names()), im2fit.garments())
            self.assertEqual(im2fit.garment_names("de")["trousers"], "Hose")
            with self.assertRaisesRegex(ValueError, "'it': expected en"):
                im2fit.garment_names("it")

    def test_the_pose_of_a_camera_in_the_hand(self):
        camera = _folder.read_camera(GOLDEN / "clip/camera.yaml")
        words = (camera.width, camera.height, camera.fx, camera.fy, camera.cx, camera.cy, camera.rotate_deg)
        texts = []
        matrix = np.array([[0, -1, 0, 0.1], [0, 0, -1, 0.2], [1, 0, 0, 0.3], [0, 0, 0, 1]])
        for turned in (None, (0, 0, 0, 1, 0, 0, 0), (0.5, -0.5, 0.5, 0.5, 100, 200, 300), matrix):
            with im2fit.Session(*words, models=models(), **FRAMES) as session:
                for number, path in _folder.frames_of(GOLDEN / "clip"):
                    session.push(_folder.read_frame(path), sequence=number, pose=turned)
                texts.append(session.finish().json)
                with self.assertRaisesRegex(im2fit.Error, "unit quaternion|after finish"):
                    session.push(_folder.read_frame(path), pose=(1, 1, 1, 1, 0, 0, 0))
        self.assertEqual(texts[0], texts[1])  # a camera at rest, wherever it is
        self.assertEqual(texts[0], texts[2])
        self.assertEqual(texts[0], texts[3])

    def test_gravity_is_used_where_no_floor_is_seen(self):
        camera = _folder.read_camera(GOLDEN / "clip/camera.yaml")
        self.assertEqual(camera.rotate_deg, 90)
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            (folder / "camera.yaml").write_text(
                f"image_width: {camera.height}\nimage_height: {camera.width}\ncamera_matrix:\n  rows: 3\n  cols: 3\n  data: "
                f"[{camera.fy}, 0, {camera.height - 1 - camera.cy}, 0, {camera.fx}, {camera.cx}, 0, 0, 1]\n")
            for number, path in _folder.frames_of(GOLDEN / "clip"):
                upright = np.rot90(_folder.read_frame(path), -1).astype(">u2")
                header = f"P5 {upright.shape[1]} {upright.shape[0]} 65535\n".encode()
                (folder / f"{number:06d}.pgm").write_bytes(header + upright.tobytes())
            rows = [f"{number},{number * 33333333}" for number, _ in _folder.frames_of(folder)]
            (folder / "timestamps.csv").write_text("frame,host_ns\n" + "\n".join(rows) + "\n")
            self.assertTrue(im2fit.measure(folder, models=models(), **FRAMES).measured)
            # Ten degrees off, as the first frame reports: a person who stands straight leans.
            rows = [rows[0] + ",0,0.9848,0.1736"] + [row + ",,," for row in rows[1:]]
            (folder / "timestamps.csv").write_text("frame,host_ns,down_x,down_y,down_z\n" + "\n".join(rows) + "\n")
            leaning = im2fit.measure(folder, models=models(), **FRAMES)
            self.assertFalse(leaning.measured)
            if CAMERAS:
                self.assertEqual(im2fit.measure(folder, models=models(), rotate_deg=0, **FRAMES).guidance, leaning.guidance)
        size = (camera.width, camera.height, camera.fx, camera.fy, camera.cx, camera.cy)
        with im2fit.Session(*size, models=models()) as session:
            for at in range(3):
                with self.assertRaisesRegex(im2fit.Error, "frame.down_x, down_y, down_z"):
                    session.push(np.zeros((240, 320), np.uint16), down=[float("nan") if i == at else 0.5 for i in range(3)])

    def test_a_lens_is_undone(self):
        # The same by numpy: for each pixel of the straight picture the nearest of the bent one.
        camera = _folder.read_camera(GOLDEN / "clip/camera.yaml")
        size = (camera.width, camera.height, camera.fx, camera.fy, camera.cx, camera.cy)
        lens = (0.06, -0.03, 0.002, -0.001, 0.01)
        k1, k2, p1, p2, k3 = (float(np.float32(number)) for number in lens)
        fx, fy, cx, cy = (float(np.float32(number)) for number in size[2:])
        v, u = np.mgrid[0:camera.height, 0:camera.width]
        x, y = (u - cx) / fx, (v - cy) / fy
        r2 = x * x + y * y
        radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3))
        column = np.floor((x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)) * fx + cx + 0.5).astype(int)
        row = np.floor((y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y) * fy + cy + 0.5).astype(int)
        seen = (column >= 0) & (column < camera.width) & (row >= 0) & (row < camera.height)
        self.assertTrue(0.5 < seen.mean() < 1)
        bent = [_folder.read_frame(path) for _, path in _folder.frames_of(GOLDEN / "clip")]
        straight = [np.where(seen, depth[row.clip(0, camera.height - 1), column.clip(0, camera.width - 1)], 0) for depth in bent]
        texts = []
        for frames, distortion in ((bent, lens), (straight, ()), (bent, ())):
            with im2fit.Session(*size, camera.rotate_deg, models=models(), distortion=distortion, **FRAMES) as session:
                for depth in frames:
                    session.push(depth.astype(np.uint16))
                texts.append(session.finish().json)
        self.assertEqual(texts[0], texts[1])
        self.assertNotEqual(texts[0], texts[2])
        with self.assertRaisesRegex(ValueError, "3 numbers"):
            im2fit.Session(*size, models=models(), distortion=(1, 2, 3))

    def test_an_empty_room_is_not_measured(self):
        with im2fit.Session(320, 240, 287.9, 287.9, 159.5, 119.5, models=models()) as session:
            for _ in range(3):
                guidance = session.push(np.zeros((240, 320), np.uint16))
            self.assertFalse(guidance.measured)
            person = session.finish()
            self.assertIn(im2fit.GuidanceCode.NO_PERSON, session.poll().codes)
        self.assertFalse(person.measured)
        self.assertIn(im2fit.GuidanceCode.NO_PERSON, person.guidance)
        self.assertEqual((person.tape(), person.sizes), ({}, {}))
        with self.assertRaisesRegex(ValueError, "no avatar: .*NO_PERSON"):
            person.avatar()
        with self.assertRaisesRegex(ValueError, "closed"):
            session.poll()


class Typed(unittest.TestCase):
    @unittest.skipUnless(has("mypy"), "no mypy (scripts/deps test)")
    def test_the_package_and_the_recipes_are_typed(self):
        recipes = re.findall(r"^## (.*?)\n.*?^```python\n(.*?)^```$", (HERE.parent / "recipes.md").read_text(), re.M | re.S)
        self.assertGreaterEqual(len(recipes), 5)
        with tempfile.TemporaryDirectory() as name:
            folder, places = pathlib.Path(name), []
            for number, (title, text) in enumerate(recipes):
                compile(text, title, "exec")
                places.append(folder / f"recipe_{number}.py")
                places[-1].write_text(text)
            # What a user does wrong is found, so types did not fall to Any.
            wrong = folder / "wrong.py"
            wrong.write_text("import im2fit\n"
                             "person = im2fit.measure('FOLDER', 'MODELS', turns=1, sensor=im2fit.Clothing.BARE)\n"
                             "person.sizes.append(1)\nim2fit.State.TRACKING == 'TRACKING'\n")
            command = [sys.executable, "-m", "mypy", "--cache-dir", str(folder / "cache"), "--no-error-summary"]
            done = subprocess.run([*command, "im2fit", *map(str, places)], cwd=HERE.parent, capture_output=True, text=True)
            self.assertEqual((done.returncode, done.stdout + done.stderr), (0, ""))
            done = subprocess.run([*command, str(wrong)], cwd=HERE.parent, capture_output=True, text=True)
            for word in ("turns", "sensor", "append", "comparison"):
                self.assertIn(word, done.stdout)
            self.assertEqual(done.stdout.count("error:"), 4, done.stdout)


class WheelTag(unittest.TestCase):
    def tag(self, *names, extra=()):
        elf = bytearray(b"\x7fELF" + bytes(60))
        elf[18:20] = (62).to_bytes(2, "little")
        library = bytes(elf) + b"\0" + b"".join(name.encode() + b"\0" for name in names)
        return make_wheel.tag_of({"libim2fit.so.0": library, **dict.fromkeys(extra, library)})

    def test_the_oldest_system_that_has_all(self):
        self.assertEqual(self.tag("libc.so.6", "GLIBC_2.2.5", "GLIBC_2.14"), "manylinux_2_28_x86_64")
        self.assertEqual(self.tag("libc.so.6", "GLIBC_2.33", "GLIBCXX_3.4.21"), "manylinux_2_34_x86_64")
        self.assertEqual(self.tag("libstdc++.so.6", "GLIBC_2.14", "GLIBCXX_3.4.30"), "manylinux_2_35_x86_64")

    def test_what_not_every_system_has(self):
        self.assertEqual(self.tag("GLIBC_2.38"), "linux_x86_64")
        self.assertEqual(self.tag("libzstd.so.1", "GLIBC_2.14"), "linux_x86_64")
        self.assertEqual(self.tag("libzstd.so.1", "GLIBC_2.14", extra=("libzstd.so.1",)), "manylinux_2_28_x86_64")


@unittest.skipUnless(has("ensurepip"), "no ensurepip (scripts/deps test)")
class Wheel(unittest.TestCase):
    def test_the_readme_installs_it(self):
        # The line of README.md as it stands, where no network can be reached.
        [line] = re.findall(r"^    (python3 -m venv .*)$", (HERE.parent / "README.md").read_text(), re.M)
        library = os.environ.get("IM2FIT_LIBRARY")
        self.assertTrue(library, "IM2FIT_LIBRARY names no library")
        zstd = pathlib.Path(f"/lib/{sysconfig.get_config_var('MULTIARCH')}/libzstd.so.1")
        brings = [zstd, "/usr/share/doc/libzstd1/copyright"] if b"libzstd.so.1" in pathlib.Path(library).read_bytes() else []
        with tempfile.TemporaryDirectory() as folder:
            made = subprocess.run([sys.executable, HERE.parent / "make_wheel.py", library, f"{folder}/build/packages", *brings],
                                  check=True, capture_output=True, text=True).stdout
            self.assertRegex(made, r"-py3-none-manylinux_2_\d+_\w+\.whl\n$")
            nowhere = "http://127.0.0.1:9"
            environment = {"PATH": "/usr/bin:/bin", "HOME": folder, "LC_ALL": "C.UTF-8", "http_proxy": nowhere,
                           "https_proxy": nowhere, "PIP_RETRIES": "0"}
            done = subprocess.run(["sh", "-ec", line], cwd=folder, env=environment, capture_output=True, text=True)
            self.assertEqual(done.returncode, 0, f"{line}\n{done.stdout}{done.stderr}")
            python = line.split()[-3].replace("/pip", "/python")
            script = ("import im2fit, importlib.metadata as m, pathlib; p = pathlib.Path(im2fit.__file__).parent\n"
                      "print(p, im2fit.version(), im2fit.__version__, m.version('im2fit'), (p / 'py.typed').exists())")
            found = subprocess.run([python, "-c", script], cwd=folder, env=environment, check=True, capture_output=True,
                                   text=True).stdout.split()
            self.assertTrue(found[0].startswith(folder), found)
            self.assertEqual(found[1:], [im2fit.__version__] * 3 + ["True"])
            script = "import im2fit; im2fit.version(); print(open('/proc/self/maps').read())"
            maps = subprocess.run([python, "-c", script], cwd=folder, env=environment, check=True, capture_output=True,
                                  text=True).stdout
            for name in ["libim2fit.so.0", "libzstd.so.1"][:1 + len(brings)]:
                self.assertIn(f"{found[0]}/{name}\n", maps + "\n")
            if BODY:
                place = pathlib.Path(folder) / "models"
                place.mkdir()
                for name, file in (("body.i2b", pathlib.Path(BODY)), *((n, GOLDEN / n) for n in ("tracker.i2t", "index.i2f"))):
                    (place / name).symlink_to(file.resolve())
                script = f"import im2fit; print(im2fit.measure({str(GOLDEN / 'clip')!r}, models='models', frames_wanted=6))"
                answer = subprocess.run([python, "-c", script], cwd=folder, env=environment, check=True, capture_output=True,
                                        text=True).stdout
                self.assertRegex(answer, "<im2fit.Person .* mm, .* kg, chest .*>")


if __name__ == "__main__":
    result = unittest.main(verbosity=1, exit=False).result
    skipped = bool(result.skipped) and bool(os.environ.get("IM2FIT_NO_SKIPS"))
    if skipped:
        print("nothing may be skipped:", *(why for _, why in result.skipped), file=sys.stderr)
    sys.exit(0 if result.wasSuccessful() and not skipped else 1)
