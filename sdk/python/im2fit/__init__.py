# SPDX-License-Identifier: Apache-2.0
"""Body measurements from a depth camera. All processing runs on this machine.

    import im2fit
    person = im2fit.measure("FOLDER")          # a depth folder; "me.oni" and "openni2" with libim2fit-cameras
    person.measurements["chest_girth"]         # Estimate(value=..., low=..., high=..., unit='mm')
    person.size, person.tape(), person.json

Frame by frame, from any camera:

    with im2fit.Session(width, height, fx, fy, cx, cy) as session:
        while not session.push(depth).measured:    # numpy: uint16 mm, or float32 metres
            ...
        person = session.finish()

This package calls the C library. Its header im2fit.h is the reference. Only one thread at a time may use a Session.
"""

from __future__ import annotations

import ctypes
import dataclasses
import json
import operator
import os
import pathlib
from typing import TYPE_CHECKING, Any, Iterable, Sequence, TypedDict, Union, cast

import numpy as np
import numpy.typing as npt

from . import _c
from ._camera import Camera, lens_of, pose_of, upright
from ._enums import Clothing, GuidanceCode, Sensor, Sex, State, Status, TapeStatus, Turn, Verdict, View
from ._folder import DepthFolder, DepthFrame
from ._person import AvatarKind, Estimate, Person, TapeValue, check_avatar_kind, too_late

if TYPE_CHECKING:
    from typing_extensions import Unpack  # not needed to run

__version__ = "1.0.0"

__all__ = ["Camera", "Clothing", "DepthFolder", "DepthFrame", "Diagnosis", "Error", "Estimate", "GarmentFit", "Guidance", "GuidanceCode",
           "Mask", "Models", "Person", "Sensor", "Session", "Settings", "Sex", "State", "Status", "TapeStatus", "TapeValue", "Turn",
           "User", "Verdict", "View", "garment_names", "garments", "guidance_text", "joint_names", "measure", "read_folder",
           "rig_node_parents", "rig_nodes", "tape_names", "version"]

StrPath = Union[str, "os.PathLike[str]"]

_library: ctypes.CDLL | None = None
_cameras_library: ctypes.CDLL | None = None


def _lib() -> ctypes.CDLL:
    global _library
    if _library is None:
        _library = _c.load()
    return _library


def _cameras() -> ctypes.CDLL:
    global _cameras_library
    if _cameras_library is None:
        _lib()  # first: libim2fit-cameras uses the libim2fit that is already loaded
        _cameras_library = _c.load_cameras()
    return _cameras_library


class Error(RuntimeError):
    """A call of the library failed. `name` is the short name of its status, "not_found"."""

    def __init__(self, status: int, text: str) -> None:
        super().__init__(text)
        self.status = Status(status)
        self.name = str(_lib().im2fit_status_name(status).decode())


def version() -> str:
    """The version of the C library, "1.0.0". `__version__` is that of this package."""
    return str(_lib().im2fit_version().decode())


def garments() -> list[str]:
    """The ids of all garments."""
    return [_lib().im2fit_garment_id(i).decode() for i in range(_lib().im2fit_garment_count())]


def garment_names(language: str = "en") -> dict[str, str]:
    """The names of all garments by id: "T-shirt". `language`: "en", "de", "es", "fr" or "zh"."""
    names = {key: _lib().im2fit_garment_name(i, language.encode()) for i, key in enumerate(garments())}
    if None in names.values():
        raise ValueError(f"no names in the language {language!r}: expected en, de, es, fr or zh")
    return {key: name.decode() for key, name in names.items()}


def guidance_text(code: GuidanceCode, language: str = "en") -> str:
    """The text to show or speak to the person, at most six words: "Step back" for TOO_NEAR. `language`: "en", "de", "es", "fr" or "zh"."""
    text = _lib().im2fit_guidance_text(code.bit_length() - 1, language.encode())
    if text is None:
        raise ValueError(f"no text for {code!r} in the language {language!r}: expected en, de, es, fr or zh")
    return str(text.decode())


def joint_names() -> list[str]:
    """The names of the rows of Session.joints(), in its order: head, neck, torso, then left and right shoulder, elbow, hand,
    hip, knee, foot ("HE", "NE", "TO", "LS", "RS", ...)."""
    return [_lib().im2fit_joint_name(i).decode() for i in range(_c.JOINTS)]


def rig_nodes() -> list[str]:
    """The names of the nodes of Session.rig(), in its order."""
    return [_lib().im2fit_rig_node_name(i).decode() for i in range(_c.RIG_NODES)]


def rig_node_parents() -> list[int]:
    """The index of the parent of each of rig_nodes(); -1 for the first."""
    return [_lib().im2fit_rig_node_parent(i) for i in range(_c.RIG_NODES)]


def tape_names(language: str = "en") -> dict[str, str]:
    """The names of the measurements of Person.tape() by id: "Thigh girth". `language`: "en", "de", "es", "fr" or "zh"."""
    lib = _lib()
    names = {lib.im2fit_tape_id(i).decode(): lib.im2fit_tape_name(i, language.encode())
             for i in range(lib.im2fit_tape_count())}
    if None in names.values():
        raise ValueError(f"no names in the language {language!r}: expected en, de, es, fr or zh")
    return {key: name.decode() for key, name in names.items()}


@dataclasses.dataclass(frozen=True)
class Guidance:
    """The progress of a session. `codes`: what the person or the scene must change now. `view`: the visible side of the person
    in the latest frame. `turned_deg`: with Turn.AROUND, the angle turned so far. For a progress bar, show `frames_used` out of
    `frames_wanted`; with Turn.BACK it counts both sides, each with `frames_wanted`."""

    state: State
    codes: tuple[GuidanceCode, ...]
    measured: bool
    frames_seen: int
    frames_used: int
    view: View
    turned_deg: float
    frames_wanted: int


@dataclasses.dataclass(frozen=True)
class User:
    """A person in view: the box in pixels of the upright picture, inclusive, and the centroid of the visible surface in mm,
    camera axes."""

    id: int
    left: int
    top: int
    right: int
    bottom: int
    x: float
    y: float
    z: float


@dataclasses.dataclass(frozen=True, eq=False)
class Mask:
    """The mask of the person in a frame. `pixels`: height x width of the upright picture, True for the person. `user_id`: the
    User.id of the person; 0: no person in view. `sequence`, `time_ns`: those of the frame."""

    pixels: npt.NDArray[np.bool_]
    user_id: int
    sequence: int
    time_ns: int


@dataclasses.dataclass(frozen=True)
class Diagnosis:
    """The reason why no person is found in a frame. `code`: "" if no cause is found, otherwise as IM2FIT_DIAGNOSIS_...: "UNIT",
    "ROTATED", ... `unit_mm` and `rotate_deg`: the correct value, or 0 for other codes. `text`: as printed by the programs."""

    code: str
    text: str
    unit_mm: float
    rotate_deg: int


@dataclasses.dataclass(frozen=True)
class GarmentFit:
    """How a garment fits. `best` is the size to buy. `sizes` has the sizes by name, from small to large. Each value is a dictionary
    from region ("chest") to a pair: the Estimate of the ease, and the Verdict."""

    garment: str
    best: str
    sizes: dict[str, dict[str, tuple[Estimate, Verdict]]]


class Settings(TypedDict, total=False):
    """Keyword arguments of Session, Session.of and measure: fields of im2fit_settings. Missing ones have the defaults of im2fit.h.
    Flags are 0 or 1."""

    frames_wanted: int
    frames_min: int
    calibration_psi: int
    live: int
    single_thread: int
    pool_frames: int
    user_id: int
    turn: Turn
    clothing: Clothing
    sensor: Sensor


@dataclasses.dataclass(frozen=True)
class Models:
    """The paths of the three model files. Each may be a model pack. Without a body (""), there are measurements but no
    Person.avatar."""

    body: str
    tracker: str
    index: str

    @staticmethod
    def find(directory: StrPath | None = None) -> Models:
        """A model pack, or a directory with the three files. None: searches like the program im2fit: IM2FIT_BODY and so on, then
        IM2FIT_MODELS, then a directory with all three files (docs/models.md). Raises FileNotFoundError."""
        home, env = pathlib.Path.home(), os.environ.get
        data, cache = env("XDG_DATA_HOME") or home / ".local/share", env("XDG_CACHE_HOME") or home / ".cache"
        shared = (env("XDG_DATA_DIRS") or "/usr/local/share:/usr/share").split(":")
        named = directory or env("IM2FIT_MODELS")
        if named and pathlib.Path(named).is_file():
            pack = os.fspath(named)
            return Models(**{key: (None if directory else env("IM2FIT_" + key.upper())) or pack
                             for key in ("body", "tracker", "index")})
        places = [pathlib.Path(named)] if named else [pathlib.Path(p) / "im2fit" for p in (data, cache, *shared) if p]
        names = {"body": "body.i2b", "tracker": "tracker.i2t", "index": "index.i2f"}
        place = next((p for p in places if all((p / name).exists() for name in names.values())), None)
        found = {}
        for key, name in names.items():
            given = None if directory else env("IM2FIT_" + key.upper())
            if given:
                found[key] = given
            elif place:
                found[key] = str(place / name)
            else:
                raise FileNotFoundError(f"no models in {', '.join(map(str, places))}: expected {', '.join(names.values())}; "
                                        "get a pack (models=\"PACK.i2p\"), or install one: im2fit models install PACK.i2p" +
                                        (f" --to {directory}" if directory else ""))
        return Models(**found)


class Session:
    """Measures one person with one depth camera. push() takes a frame; pump() reads one from a source of Session.of or attach().

    `width, height, fx, fy, cx, cy`: size and intrinsics of the depth camera, in pixels of the pushed frames. `rotate_deg`: rotation
    that makes them upright. `models`: a model pack, a folder with the three files, or Models; None: the installed models
    (Models.find). `distortion`: lens distortion that is not yet corrected, in OpenCV's order: k1, k2, p1, p2 and optionally k3.
    Other keyword arguments are those of Settings: turn=Turn.AROUND, frames_wanted=30, clothing=Clothing.BARE,
    sensor=Sensor.TIME_OF_FLIGHT.

    Only one thread at a time may use a session. Raises Error."""

    def __init__(self, width: int, height: int, fx: float, fy: float, cx: float, cy: float, rotate_deg: int = 0,
                 models: Models | StrPath | None = None, distortion: Sequence[float] = (),
                 **settings: Unpack[Settings]) -> None:
        self._handle = ctypes.c_void_p()
        if not isinstance(models, Models):
            models = Models.find(models)
        s = _c.Settings()
        _lib().im2fit_settings_init(ctypes.byref(s), ctypes.sizeof(s))
        s.tracker_path, s.index_path = os.fsencode(models.tracker), os.fsencode(models.index)
        s.body_path = os.fsencode(models.body) if models.body else None
        s.width, s.height, s.fx, s.fy, s.cx, s.cy = upright(width, height, fx, fy, cx, cy, rotate_deg)
        for name, value in settings.items():
            if name not in Settings.__annotations__:
                raise TypeError(f"no setting is called {name}; there are {', '.join(sorted(Settings.__annotations__))}")
            try:
                setattr(s, name, operator.index(cast(int, value)))
            except TypeError:
                expected = f"one of im2fit.{name.title()}" if name in ("clothing", "sensor", "turn") else "a whole number"
                raise TypeError(f"{name} is {value!r}, expected {expected}") from None
        self._size, self._rotate_deg, self._number = (height, width), rotate_deg, 0
        self._intrinsics, self._lens = (fx, fy, cx, cy), lens_of(distortion)
        self._options: _c.CamerasOptions | None = None
        self._attached = False  # a source of libim2fit-cameras, which then has the reasons of failures
        self._has_body = bool(models.body)
        self._answer = 0  # counts up when the session goes on to another person or other facts: an avatar is then another's
        self._check(_lib().im2fit_open(ctypes.byref(s), ctypes.byref(self._handle)))

    @classmethod
    def of(cls, uri: StrPath, rotate_deg: int | None = None, calibration: StrPath | None = None,
           models: Models | StrPath | None = None, **settings: Unpack[Settings]) -> Session:
        """A session with an attached source: a camera ("openni2", "usb", "v4l2:/dev/video2"), a recording ("me.oni") or a
        folder. Needs libim2fit-cameras. If the source lacks them, set `rotate_deg`, the mounting of the camera, and `calibration`,
        the path of a calibration file. Then call pump() until there is a measurement:

            with im2fit.Session.of("openni2", rotate_deg=90) as session:
                while not session.pump().measured: ...
                person = session.finish()
        """
        options, source = _camera_options(rotate_deg, calibration), _c.Settings()
        _lib().im2fit_settings_init(ctypes.byref(source), ctypes.sizeof(source))
        status = _cameras().im2fit_cameras_describe(os.fsencode(uri), ctypes.byref(options), ctypes.byref(source))
        if status != Status.OK:
            raise Error(status, _cameras().im2fit_cameras_error().decode(errors="replace"))
        settings.setdefault("sensor", source.sensor)
        settings.setdefault("live", source.live)
        session = cls(source.width, source.height, source.fx, source.fy, source.cx, source.cy, models=models, **settings)
        try:
            session.attach(uri, rotate_deg, calibration)
        except BaseException:
            session.close()
            raise
        return session

    def attach(self, uri: StrPath, rotate_deg: int | None = None, calibration: StrPath | None = None) -> None:
        """Attaches a source for pump(), like Session.of. It replaces the attached source. Its upright frames must have the size of
        the session. The intrinsics of the session apply to them."""
        options = _camera_options(rotate_deg, calibration)
        handle, cameras = self._open_handle(), _cameras()
        status = cameras.im2fit_cameras_use(handle, ctypes.byref(options))
        if status == Status.OK:
            self._options = options  # im2fit_attach reads them: they live as long as the handle
            status = _lib().im2fit_attach(handle, os.fsencode(uri))
        self._attached = status == Status.OK
        if status != Status.OK:
            raise Error(status, cameras.im2fit_cameras_error().decode(errors="replace"))

    def detach(self) -> None:
        """Closes the attached source, if any. close() does that too."""
        self._check(_lib().im2fit_detach(self._open_handle()))
        self._attached = False

    def pump(self, timeout_ms: int = 1000) -> Guidance | None:
        """Processes one frame of the attached source if it arrives within `timeout_ms`. Skips damaged frames. Returns the Guidance,
        or None at the end of a recording or folder. Raises Error "no_device" if the camera was unplugged, "corrupt" if the index
        is damaged."""
        status = _lib().im2fit_pump(self._open_handle(), timeout_ms)
        if status == Status.END_OF_STREAM:
            return None
        if status not in (Status.OK, Status.TIMEOUT, Status.CORRUPT):
            reason = _cameras().im2fit_cameras_error() if self._attached else b""
            raise Error(status, (reason or _lib().im2fit_last_error(self._handle)).decode(errors="replace"))
        if status == Status.CORRUPT and _lib().im2fit_wait(self._handle, timeout_ms) == Status.CORRUPT:
            self._check(Status.CORRUPT)  # the index is damaged, not the frame: every further call would return CORRUPT
        return self.poll()

    def push(self, depth: npt.NDArray[np.uint16] | npt.NDArray[np.float32], time_ns: int | None = None,
             sequence: int | None = None, confidence: npt.NDArray[np.uint8] | None = None, confidence_min: int = 0,
             pose: npt.ArrayLike | None = None, down: Sequence[float] | None = None,
             intrinsics: Sequence[float] | None = None) -> Guidance:
        """Processes one frame. Returns the Guidance.

        `depth`: height x width, uint16 millimetres or float32 metres (NaN or 0: no data). `confidence`: uint8 of the same
        shape; pixels below `confidence_min` count as no data. `down`: the direction of gravity in the axes of the frame, of any
        length; without it, the latest known direction is used. `intrinsics`: fx, fy, cx, cy of this frame, where they change with
        focus; without them, those of the session.

        `pose`: pose of a hand-held camera, from the axes of the frame (x right, y down, z forward) to static axes. It is a 4x4
        matrix with the position in metres, as in Open3D, ROS and ARKit. ARKit and OpenGL have y up and z backwards: pass
        matrix @ numpy.diag([1, -1, -1, 1]). Or it is the seven numbers of im2fit_frame: the unit quaternion x, y, z, w and the
        position in millimetres."""
        depth = np.asarray(depth)
        if depth.shape != self._size or depth.dtype not in (np.uint16, np.float32):
            raise ValueError(f"depth is {depth.dtype} {depth.shape}, expected uint16 or float32 {self._size}")
        depth = np.ascontiguousarray(depth)
        frame = _c.Frame()
        _lib().im2fit_frame_init(ctypes.byref(frame), ctypes.sizeof(frame))
        frame.pixels, frame.format = depth.ctypes.data, _c.FORMAT_U16 if depth.dtype == np.uint16 else _c.FORMAT_F32
        frame.height, frame.width = depth.shape
        frame.rotate_deg = self._rotate_deg
        frame.fx, frame.fy, frame.cx, frame.cy = self._intrinsics if intrinsics is None else map(float, intrinsics)
        frame.k1, frame.k2, frame.p1, frame.p2, frame.k3 = self._lens
        if confidence is not None:
            confidence = np.ascontiguousarray(confidence, np.uint8)
            if confidence.shape != self._size:
                raise ValueError(f"confidence is {confidence.shape}, expected {self._size}")
            frame.confidence, frame.confidence_min = confidence.ctypes.data, confidence_min
        if pose is not None:
            (frame.turn_x, frame.turn_y, frame.turn_z, frame.turn_w, frame.x_mm, frame.y_mm, frame.z_mm) = pose_of(pose)
        if down is not None:
            frame.down_x, frame.down_y, frame.down_z = map(float, down)
        frame.sequence = self._number if sequence is None else sequence
        frame.time_ns = self._number * 33_333_333 if time_ns is None else time_ns
        self._number += 1
        self._check(_lib().im2fit_push_frame(self._open_handle(), ctypes.byref(frame)))
        return self.poll()

    def poll(self) -> Guidance:
        """The Guidance after the latest processed frame."""
        r = self._result()
        codes = tuple(code for code in GuidanceCode if r.guidance & code)
        return Guidance(State(r.state), codes, bool(r.measured), r.frames_seen, r.frames_used, View(r.view),
                        r.turned_deg, r.frames_wanted)

    def joints(self) -> npt.NDArray[np.float32] | None:
        """15 x 4: x, y, z (mm, camera axes) and confidence of each joint (joint_names()); None without a person."""
        r = self._result()
        if not r.has_joints:
            return None
        return np.array([(j.x, j.y, j.z, j.confidence) for j in r.joints], np.float32)

    def mask(self) -> Mask | None:
        """The mask of the person in the latest frame, to draw over the picture. The library keeps masks after the first call, so the
        result is None until the next frame."""
        info, handle = _c.MaskInfo(), self._open_handle()
        status = _lib().im2fit_mask(handle, None, 0, ctypes.byref(info), ctypes.sizeof(info))
        if status == Status.NOT_FOUND:
            return None
        self._check(status)
        pixels = np.empty((info.height, info.width), np.uint8)
        self._check(_lib().im2fit_mask(handle, pixels.ctypes.data, pixels.size, ctypes.byref(info), ctypes.sizeof(info)))
        return Mask(pixels != 0, info.user_id, info.sequence, info.time_ns)

    def diagnose(self, depth: npt.NDArray[np.uint16]) -> Diagnosis:
        """The reason why no person is found: wrong unit or byte order, a camera on its side, intrinsics of another picture. `depth`:
        as for push(), uint16. It can take some tenths of a second: do not call it for every frame."""
        depth = np.asarray(depth)
        if depth.shape != self._size or depth.dtype != np.uint16:
            raise ValueError(f"depth is {depth.dtype} {depth.shape}, expected uint16 {self._size}")
        upright = np.ascontiguousarray(np.rot90(depth, -self._rotate_deg // 90))
        found = _c.Diagnosis()
        height, width = upright.shape
        self._check(_lib().im2fit_diagnose(self._open_handle(), upright.ctypes.data_as(ctypes.POINTER(ctypes.c_uint16)), width,
                                           height, 0, ctypes.byref(found), ctypes.sizeof(found)))
        return Diagnosis(_lib().im2fit_diagnosis_name(found.code).decode(), found.text.decode(), found.unit_mm, found.rotate_deg)

    def users(self) -> list[User]:
        """All people in the latest frame, nearest first."""
        r = self._result()
        return [User(u.id, u.left, u.top, u.right, u.bottom, u.x, u.y, u.z) for u in r.users[:r.user_count]]

    def select_user(self, user_id: int) -> None:
        """From the next frame on, measures only the person with this User.id; 0: the first person whose guidance is empty. Another
        id begins a new session."""
        self._check(_lib().im2fit_select_user(self._open_handle(), user_id))
        self._answer += 1

    def set_region(self, x0_mm: float = 0, z0_mm: float = 0, x1_mm: float = 0, z1_mm: float = 0) -> None:
        """From the next frame on, measures only people whose feet are within this rectangle on the floor. Coordinates are relative
        to the point under the camera: x to the camera's right, z away from it. Without arguments: everywhere."""
        self._check(_lib().im2fit_set_region(self._open_handle(), x0_mm, z0_mm, x1_mm, z1_mm))

    def finish(self) -> Person:
        """Ends the stream and measures with the accepted frames. Returns a Person, measured or not. Call it again after set_known
        to get the changed measurements."""
        self._check(_lib().im2fit_finish(self._open_handle()))
        text = self._bytes(_lib().im2fit_result_json).decode()
        result = json.loads(text)
        measured, answer = result["state"] == "MEASURED", self._answer

        def make_avatar(kind: AvatarKind) -> bytes:
            if not self._handle or self._answer != answer:
                raise too_late(kind)
            return self._bytes(_lib().im2fit_avatar, ctypes.c_int32(_c.AVATAR_FORMATS[kind]))

        return Person(result, text, self._tape() if measured and self._has_body else {}, self._sizes() if measured else {},
                      make_avatar)

    def mesh(self) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.int32]]:
        """The measured person as a mesh: (vertices n x 3 in mm, triangles m x 3)."""
        count, faces = ctypes.c_size_t(), ctypes.c_size_t()
        handle = self._open_handle()
        self._check(_lib().im2fit_body_mesh(handle, None, 0, ctypes.byref(count), None, 0, ctypes.byref(faces)))
        vertices, triangles = np.empty((count.value, 3), np.float32), np.empty((faces.value, 3), np.int32)
        self._check(_lib().im2fit_body_mesh(handle, vertices.ctypes.data, count, ctypes.byref(count), triangles.ctypes.data,
                                            faces, ctypes.byref(faces)))
        return vertices, triangles

    def residual(self) -> dict[str, float]:
        """The differences between the measurements of mesh() and those of the Person: mm, weight in kg. They are below 1 mm if a
        body with all these measurements exists."""
        values = (ctypes.c_float * _c.MEASUREMENTS)()
        self._check(_lib().im2fit_body_residual(self._open_handle(), values))
        return {_lib().im2fit_measurement_name(i).decode(): value for i, value in enumerate(values)}

    def fit(self, garment: str) -> GarmentFit:
        """How a garment, by its id, fits the measured person: a GarmentFit."""
        count, best, handle = ctypes.c_size_t(), ctypes.c_size_t(), self._open_handle()
        arguments = (handle, garment.encode())
        status = _lib().im2fit_garment_fit(*arguments, None, ctypes.sizeof(_c.SizeFit), 0, ctypes.byref(count), None)
        if status != Status.TOO_SMALL:
            self._check(status)
        fits = (_c.SizeFit * count.value)()
        self._check(_lib().im2fit_garment_fit(*arguments, fits, ctypes.sizeof(_c.SizeFit), count, ctypes.byref(count),
                                              ctypes.byref(best)))
        sizes = {fit.name.decode(): {
            place.name.decode(): (Estimate(place.ease_mm, place.low_mm, place.high_mm, "mm"),
                                  Verdict(place.verdict))
            for place in fit.regions[:fit.region_count]} for fit in fits}
        return GarmentFit(garment, fits[best.value].name.decode(), sizes)

    def dressed_avatar(self, *worn: str | tuple[str, str | None]) -> bytes:
        """The measured person in clothes, as the bytes of a .glb. `worn`, innermost first: ids of garments in the best size, or pairs
        of id and size. Without arguments: trousers and a T-shirt."""
        pairs = [(one, None) if isinstance(one, str) else one for one in worn]
        items = (_c.Worn * len(pairs))(*(_c.Worn(garment.encode(), size.encode() if size else None)
                                         for garment, size in pairs))
        return self._bytes(_lib().im2fit_dressed_avatar, items, ctypes.c_size_t(len(pairs)))

    def rig(self) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]] | None:
        """The pose of the avatar's nodes (rig_nodes()) in the latest frame: (root, 3 numbers, metres; rotations, 19 x 4, unit
        quaternions x y z w). None if no person is tracked in this frame. Needs a measurement."""
        rig = _c.Rig()
        status = _lib().im2fit_live_rig(self._open_handle(), ctypes.byref(rig), ctypes.sizeof(rig))
        if status == Status.NOT_FOUND:
            return None
        self._check(status)
        return np.array(rig.root_m, np.float32), np.array(rig.rotations, np.float32)

    def models(self) -> dict[str, Any]:
        """A description of the models: a dict with the fields of im2fit_models (made_by, people, captures, tracker_key, and
        has_body, answers_shape, answers_turned, answers_clothed, site_corrected as bool)."""
        models = _c.Models()
        self._check(_lib().im2fit_get_models(self._open_handle(), ctypes.byref(models), ctypes.sizeof(models)))
        known = {name: getattr(models, name) for name, _ in _c.Models._fields_}
        known["made_by"] = known["made_by"].decode()
        return {name: bool(v) if kind is ctypes.c_int32 else v
                for (name, kind), v in zip(_c.Models._fields_, known.values())}

    def set_known(self, stature_mm: float | None = None, weight_kg: float | None = None, sex: Sex | None = None,
                  age_years: float | None = None, stature_sd_mm: float | None = None, weight_sd_kg: float | None = None,
                  age_sd_years: float | None = None) -> None:
        """Sets facts that the person reports, before, during or after the frames. A known weight makes girths more accurate. Add 0.5
        to an age in completed years. None and 0: not known. Without a standard deviation, that of reported facts is used; for a
        weight from a scale, set weight_sd_kg=0.7. A second call replaces the first. Person.doubted names facts that were not
        used because they contradict the frames."""
        known = _c.Known()
        _lib().im2fit_known_init(ctypes.byref(known), ctypes.sizeof(known))
        known.stature_mm, known.stature_sd_mm = stature_mm or 0, stature_sd_mm or 0
        known.weight_kg, known.weight_sd_kg = weight_kg or 0, weight_sd_kg or 0
        known.age_years, known.age_sd_years = age_years or 0, age_sd_years or 0
        known.sex = Sex(sex or 0)
        self._check(_lib().im2fit_set_known(self._open_handle(), ctypes.byref(known)))
        self._answer += 1

    def next(self) -> None:
        """Prepares for the next person: frames are processed again. The measurement stays until the measured person has
        left."""
        self._check(_lib().im2fit_next(self._open_handle()))
        self._answer += 1

    def reset(self) -> None:
        """Begins a session for a new person and discards all frames."""
        self._check(_lib().im2fit_reset(self._open_handle()))
        self._number = 0
        self._answer += 1

    def close(self) -> None:
        """Frees the session. A second call does nothing."""
        if self._handle:
            _lib().im2fit_close(self._handle)
            self._handle = ctypes.c_void_p()

    def __enter__(self) -> Session:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __del__(self) -> None:
        if getattr(self, "_handle", None):
            self.close()

    def _open_handle(self) -> ctypes.c_void_p:
        if not self._handle:
            raise ValueError("the session is closed")
        return self._handle

    def _result(self) -> _c.Result:
        r = _c.Result()
        self._check(_lib().im2fit_poll(self._open_handle(), ctypes.byref(r), ctypes.sizeof(r)))
        return r

    def _check(self, status: int) -> None:
        if status != Status.OK:
            text = (_lib().im2fit_last_error(self._handle) if self._handle else b"") or _lib().im2fit_last_error(None)
            raise Error(status, text.decode(errors="replace"))

    def _tape(self) -> dict[str, TapeValue]:
        lib, count = _lib(), _lib().im2fit_tape_count()
        values = (_c.TapeValue * count)()
        self._check(lib.im2fit_tape(self._open_handle(), None, count, values, ctypes.sizeof(_c.TapeValue)))
        return {lib.im2fit_tape_id(i).decode(): TapeValue(
            TapeStatus(v.status), v.value, v.low, v.high, lib.im2fit_tape_unit(i).decode(), lib.im2fit_tape_iso(i).decode(),
            (v.reason or b"").decode()) for i, v in enumerate(values)}

    def _sizes(self) -> dict[str, float]:
        count, handle = ctypes.c_size_t(), self._open_handle()
        status = _lib().im2fit_sizes(handle, None, 0, ctypes.byref(count), None)
        if status != Status.TOO_SMALL:
            self._check(status)
        sizes = (_c.Size * count.value)()
        self._check(_lib().im2fit_sizes(handle, sizes, count, ctypes.byref(count), None))
        return {size.name.decode(): size.probability for size in sizes}

    def _bytes(self, function: Any, *arguments: Any) -> bytes:
        needed = ctypes.c_size_t()
        status = function(self._open_handle(), *arguments, None, 0, ctypes.byref(needed))
        if status != Status.TOO_SMALL:
            self._check(status)
        place = ctypes.create_string_buffer(needed.value + 1)
        self._check(function(self._handle, *arguments, place, needed.value + 1, ctypes.byref(needed)))
        return place.raw[:needed.value]


def _camera_options(rotate_deg: int | None, calibration: StrPath | None) -> _c.CamerasOptions:
    options = _c.CamerasOptions()
    _cameras().im2fit_cameras_options_init(ctypes.byref(options), ctypes.sizeof(options))
    if rotate_deg is not None:
        options.rotate_deg = rotate_deg
    if calibration is not None:
        options.calibration_path = os.fsencode(calibration)
    return options


def read_folder(path: StrPath) -> DepthFolder:
    """Opens a depth folder (docs/cameras/folders-and-recordings.md). Iterate over it to read its frames.

        folder = im2fit.read_folder("FOLDER")
        with im2fit.Session(**vars(folder.camera)) as session:
            for frame in folder:
                session.push(**vars(frame))
            person = session.finish()
    """
    return DepthFolder(path)


def measure(source: StrPath, models: Models | StrPath | None = None, rotate_deg: int | None = None,
            calibration: StrPath | None = None, avatars: Iterable[AvatarKind] = (), **settings: Unpack[Settings]) -> Person:
    """Measures the person in a depth folder, a recording (.oni, .mkv, .bag, .zip) or before a camera; sources are those of Session.of. Uses
    frames until the measurement, or all of them. Returns a Person: check its `measured` and `guidance`. A folder does not
    need libim2fit-cameras. `avatars`: the kinds of Person.avatar to make. `models` and `settings` are those of Session."""
    avatars = tuple(avatars)
    for kind in avatars:
        check_avatar_kind(kind)
    place = pathlib.Path(source)
    if not place.exists() and ":" not in str(source) and (place.suffix in (".oni", ".mkv", ".bag", ".zip") or len(place.parts) > 1):  # no URI
        raise FileNotFoundError(f"{source} does not exist: expected a depth folder or a recording")
    if place.is_dir() and rotate_deg is None and calibration is None:
        folder = read_folder(place)
        with Session(**vars(folder.camera), models=models, **settings) as session:
            for frame in folder:
                if session.push(**vars(frame)).measured:
                    break
            return _finished(session, avatars)
    with Session.of(source, rotate_deg, calibration, models, **settings) as session:
        progress = session.pump()
        while progress is not None and not progress.measured:
            progress = session.pump()
        return _finished(session, avatars)


def _finished(session: Session, avatars: Iterable[AvatarKind]) -> Person:
    person = session.finish()
    for kind in avatars if person.measured else ():
        person.avatar(kind)
    return person
