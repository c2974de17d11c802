# SPDX-License-Identifier: Apache-2.0
"""Body measurements from a depth camera, on this machine alone.

    import im2fit
    person = im2fit.measure("FOLDER")          # a depth folder; "me.oni" and "openni2" with libim2fit-cameras
    person.measurements["chest_girth"]         # Estimate(value=..., low=..., high=..., unit='mm')
    person.size, person.json, person.avatar("glb")

Frame by frame, from any camera:

    with im2fit.Session(width, height, fx, fy, cx, cy) as session:
        while not session.push(depth).measured:    # numpy: uint16 mm, or float32 metres
            ...
        person = session.finish()

The C library does the work; its header im2fit.h is the manual. A Session belongs to one thread at a time.
"""

import ctypes
import dataclasses
import html
import json
import os
import pathlib

import numpy as np

from . import _c, _folder

__all__ = ["Error", "Estimate", "GarmentFit", "Guidance", "Models", "Person", "Session", "garments", "measure", "rig_nodes",
           "version"]

_library = _cameras_library = None


def _lib():
    global _library
    if _library is None:
        _library = _c.load()
    return _library


def _cameras():
    global _cameras_library
    if _cameras_library is None:
        _lib()  # first: libim2fit-cameras uses the libim2fit that is already loaded
        _cameras_library = _c.load_cameras()
    return _cameras_library


class Error(RuntimeError):
    """A call of the library failed. `status` is the number of the status in im2fit.h, `name` its name ("not_found")."""

    def __init__(self, status, text):
        super().__init__(text)
        self.status = status
        self.name = _lib().im2fit_status_name(status).decode()


def version():
    """The version of the C library, "1.0.0"."""
    return _lib().im2fit_version().decode()


def garments():
    """The ids of all garments."""
    return [_lib().im2fit_garment_id(i).decode() for i in range(_lib().im2fit_garment_count())]


def rig_nodes():
    """The names of the nodes of Session.rig(), in its order."""
    return [_lib().im2fit_rig_node_name(i).decode() for i in range(_c.RIG_NODES)]


@dataclasses.dataclass(frozen=True)
class Estimate:
    """A value with its 95 % interval."""

    value: float
    low: float
    high: float
    unit: str


@dataclasses.dataclass(frozen=True)
class Guidance:
    """The progress of a session. `codes`: what the person or the scene must change now."""

    state: str
    codes: tuple
    measured: bool
    frames_seen: int
    frames_used: int


@dataclasses.dataclass(frozen=True)
class GarmentFit:
    """How a garment fits. `best` is the size to buy. `sizes` has the sizes by name, small to large. Each is a dictionary
    from region ("chest") to a pair: the Estimate of the ease, and the verdict "tight", "snug", "good" or "loose"."""

    garment: str
    best: str
    sizes: dict


@dataclasses.dataclass(frozen=True)
class Models:
    """The paths of the three model files. Without a body ("") there are measurements, but no Person.avatar."""

    body: str
    tracker: str
    index: str

    @staticmethod
    def find(directory=None):
        """Finds the files as the program im2fit does: IM2FIT_BODY and so on, else a directory with all three
        (docs/models.md). Raises FileNotFoundError."""
        home, env = pathlib.Path.home(), os.environ.get
        data, cache = env("XDG_DATA_HOME") or home / ".local/share", env("XDG_CACHE_HOME") or home / ".cache"
        shared = (env("XDG_DATA_DIRS") or "/usr/local/share:/usr/share").split(":")
        places = [pathlib.Path(directory)] if directory else [pathlib.Path(p) / "im2fit" for p in (data, cache, *shared) if p]
        names = {"body": "body.i2b", "tracker": "tracker.i2t", "index": "index.i2f"}
        place = next((p for p in places if all((p / name).exists() for name in names.values())), None)
        found = {}
        for key, name in names.items():
            given = None if directory else env("IM2FIT_" + key.upper())
            if not given and place is None:
                raise FileNotFoundError("no models in " + ", ".join(map(str, places)) +
                                        "; get a pack and run: im2fit models install PACK.i2p")
            found[key] = given or str(place / name)
        return Models(**found)


class Person:
    """The result of a session, measured or not. `result` is result.json as a dictionary (docs/result.md)."""

    def __init__(self, result, text, avatars):
        self.result, self.json, self._avatars = result, text, avatars

    @property
    def measured(self):
        return self.result["state"] == "MEASURED"

    @property
    def guidance(self):
        return tuple(self.result["guidance"])

    @property
    def measurements(self):
        return {key: Estimate(entry["value"], *(entry.get("interval") or (None, None)), entry["unit"])
                for key, entry in self.result.get("measurements", {}).items()}

    @property
    def size(self):
        return (self.result.get("size") or {}).get("best")

    @property
    def female(self):
        return (self.result.get("sex") or {}).get("female")

    @property
    def doubted(self):
        """The facts of Session.set_known() that do not fit what was seen: "stature" or "weight"."""
        return tuple((self.result.get("known") or {}).get("doubted", ()))

    def avatar(self, kind="glb"):
        """The bytes of a .glb, .obj or .bvh; None without a measurement."""
        return self._avatars.get(kind)

    def __repr__(self):
        if not self.measured:
            return f"<im2fit.Person not measured: {', '.join(self.guidance) or self.result['state']}>"
        m = self.measurements
        return (f"<im2fit.Person {m['stature'].value:.0f} mm, {m['weight'].value:.1f} kg, "
                f"chest {m['chest_girth'].value:.0f} mm, size {self.size}>")

    def _repr_html_(self):
        rows = "".join(
            f"<tr><td>{html.escape(key)}</td><td>{e.value:.1f} {e.unit}</td><td>{e.low:.1f} – {e.high:.1f}</td></tr>"
            for key, e in self.measurements.items() if e.low is not None)
        return (f"<p>{html.escape(repr(self))}</p><table><tr><th>measurement</th><th>value</th><th>95 %</th></tr>"
                f"{rows}</table>")


class Session:
    """One person before one depth camera. push() takes frames; pump() takes them from a source of Session.of or attach().

    `width, height, fx, fy, cx, cy`: the depth camera, in pixels of frames as they are pushed. `rotate_deg` makes them
    upright. `distortion`: of a lens that is not yet undone, in OpenCV's order: k1, k2, p1, p2 and optionally k3. Other
    keywords are fields of im2fit_settings: turn=1, frames_wanted=30, clothing=1, sensor=2, single_thread=1, live=1.

    One thread at a time may use a session. Raises Error."""

    def __init__(self, width, height, fx, fy, cx, cy, rotate_deg=0, models=None, distortion=(), **settings):
        self._handle = ctypes.c_void_p()
        models = models or Models.find()
        s = _c.Settings()
        _lib().im2fit_settings_init(ctypes.byref(s), ctypes.sizeof(s))
        s.tracker_path, s.index_path = os.fsencode(models.tracker), os.fsencode(models.index)
        s.body_path = os.fsencode(models.body) if models.body else None
        s.width, s.height, s.fx, s.fy, s.cx, s.cy = _upright(width, height, fx, fy, cx, cy, rotate_deg)
        known = {name for name, kind in _c.Settings._fields_ if kind is ctypes.c_int32}
        for name, value in settings.items():
            if name not in known:
                raise TypeError(f"no setting is called {name}; there are {', '.join(sorted(known))}")
            setattr(s, name, int(value))
        self._size, self._rotate_deg, self._number = (height, width), rotate_deg, 0
        self._intrinsics, self._lens, self._options = (fx, fy, cx, cy), _lens_of(distortion), None
        self._has_body = bool(models.body)
        self._check(_lib().im2fit_open(ctypes.byref(s), ctypes.byref(self._handle)))

    @classmethod
    def of(cls, uri, rotate_deg=None, calibration=None, models=None, **settings):
        """A session with an attached source: a camera ("openni2", "usb", "v4l2:/dev/video2"), a recording ("me.oni") or a
        folder. Needs libim2fit-cameras. `rotate_deg`: mounting of the camera, `calibration`: the path of a YAML, both where
        the source lacks them. Then call pump() until there is a measurement:

            with im2fit.Session.of("openni2", rotate_deg=90) as session:
                while not session.pump().measured: ...
                person = session.finish()
        """
        options, source = _camera_options(rotate_deg, calibration), _c.Settings()
        _lib().im2fit_settings_init(ctypes.byref(source), ctypes.sizeof(source))
        status = _cameras().im2fit_cameras_describe(os.fsencode(uri), ctypes.byref(options), ctypes.byref(source))
        if status != _c.OK:
            raise Error(status, _cameras().im2fit_cameras_error().decode(errors="replace"))
        settings = {"sensor": source.sensor, "live": source.live, **settings}
        session = cls(source.width, source.height, source.fx, source.fy, source.cx, source.cy, models=models, **settings)
        try:
            session.attach(uri, rotate_deg, calibration)
        except BaseException:
            session.close()
            raise
        return session

    def attach(self, uri, rotate_deg=None, calibration=None):
        """Attaches a source, as Session.of does, for pump(). It replaces the attached one. Its upright frames must have the
        size of the session. The session's intrinsics apply to them."""
        options = _camera_options(rotate_deg, calibration)
        handle, cameras = self._open_handle(), _cameras()
        status = cameras.im2fit_cameras_use(handle, ctypes.byref(options))
        if status == _c.OK:
            self._options = options  # im2fit_attach reads them: they live as long as the handle
            status = _lib().im2fit_attach(handle, os.fsencode(uri))
        if status != _c.OK:
            raise Error(status, cameras.im2fit_cameras_error().decode(errors="replace"))

    def pump(self, timeout_ms=1000):
        """Takes one frame from the attached source, if one comes within `timeout_ms`. Skips a damaged frame. Returns the
        Guidance, or None when a recording or folder has ended. Raises Error "no_device" when the camera is gone, "corrupt"
        when the index is damaged."""
        status = _lib().im2fit_pump(self._open_handle(), timeout_ms)
        if status == _c.END_OF_STREAM:
            return None
        if status not in (_c.OK, _c.TIMEOUT, _c.CORRUPT):
            reason = _cameras().im2fit_cameras_error() if self._options is not None else b""
            raise Error(status, (reason or _lib().im2fit_last_error(self._handle)).decode(errors="replace"))
        if status == _c.CORRUPT and _lib().im2fit_wait(self._handle, timeout_ms) == _c.CORRUPT:
            self._check(_c.CORRUPT)  # the index is damaged, not the frame: every further call would return CORRUPT
        return self.poll()

    def push(self, depth, time_ns=None, sequence=None, confidence=None, confidence_min=0, pose=None, down=None):
        """Processes one frame. Returns the Guidance.

        `depth`: height x width, uint16 millimetres or float32 metres (NaN or 0: no data). `confidence`: uint8 of the same
        shape; pixels below `confidence_min` hold no data. `pose`: of a camera in the hand, seven numbers: the unit quaternion
        x, y, z, w from the axes of the frame (x right, y down, z forward) to axes at rest, and the position of the camera in
        those, mm. `down`: the direction of gravity in the axes of the frame, of any length; without it the latest known one
        holds."""
        depth = np.asarray(depth)
        if depth.shape != self._size or depth.dtype not in (np.uint16, np.float32):
            raise ValueError(f"depth is {depth.dtype} {depth.shape}, expected uint16 or float32 {self._size}")
        depth = np.ascontiguousarray(depth)
        frame = _c.Frame()
        _lib().im2fit_frame_init(ctypes.byref(frame), ctypes.sizeof(frame))
        frame.pixels, frame.format = depth.ctypes.data, _c.FORMAT_U16 if depth.dtype == np.uint16 else _c.FORMAT_F32
        frame.height, frame.width = depth.shape
        frame.rotate_deg = self._rotate_deg
        frame.fx, frame.fy, frame.cx, frame.cy = self._intrinsics
        frame.k1, frame.k2, frame.p1, frame.p2, frame.k3 = self._lens
        if confidence is not None:
            confidence = np.ascontiguousarray(confidence, np.uint8)
            if confidence.shape != self._size:
                raise ValueError(f"confidence is {confidence.shape}, expected {self._size}")
            frame.confidence, frame.confidence_min = confidence.ctypes.data, confidence_min
        if pose is not None:
            (frame.turn_x, frame.turn_y, frame.turn_z, frame.turn_w, frame.x_mm, frame.y_mm, frame.z_mm) = map(float, pose)
        if down is not None:
            frame.down_x, frame.down_y, frame.down_z = map(float, down)
        frame.sequence = self._number if sequence is None else sequence
        frame.time_ns = self._number * 33_333_333 if time_ns is None else time_ns
        self._number += 1
        self._check(_lib().im2fit_push_frame(self._open_handle(), ctypes.byref(frame)))
        return self.poll()

    def poll(self):
        """The Guidance after the latest frame processed."""
        r = self._result()
        codes = tuple(_lib().im2fit_guidance_name(bit).decode() for bit in range(32)
                      if r.guidance >> bit & 1 and _lib().im2fit_guidance_name(bit))
        return Guidance(_lib().im2fit_state_name(r.state).decode(), codes, bool(r.measured), r.frames_seen, r.frames_used)

    def joints(self):
        """15 x 4: x, y, z (mm, camera axes) and confidence of each joint; None without a person."""
        r = self._result()
        return np.ctypeslib.as_array(r.joints).view(np.float32).reshape(_c.JOINTS, 4).copy() if r.has_joints else None

    def finish(self):
        """Ends the stream and measures with the accepted frames. Returns a Person, measured or not."""
        self._check(_lib().im2fit_finish(self._open_handle()))
        text = self._bytes(_lib().im2fit_result_json).decode()
        result = json.loads(text)
        avatars = {}
        if result["state"] == "MEASURED" and self._has_body:
            for kind, number in _c.AVATAR_FORMATS.items():
                avatars[kind] = self._bytes(_lib().im2fit_avatar, ctypes.c_int32(number))
        return Person(result, text, avatars)

    def mesh(self):
        """The measured person as a mesh: (vertices n x 3 in mm, triangles m x 3)."""
        count, faces = ctypes.c_size_t(), ctypes.c_size_t()
        handle = self._open_handle()
        self._check(_lib().im2fit_body_mesh(handle, None, 0, ctypes.byref(count), None, 0, ctypes.byref(faces)))
        vertices, triangles = np.empty((count.value, 3), np.float32), np.empty((faces.value, 3), np.int32)
        self._check(_lib().im2fit_body_mesh(handle, vertices.ctypes.data, count, ctypes.byref(count), triangles.ctypes.data,
                                            faces, ctypes.byref(faces)))
        return vertices, triangles

    def fit(self, garment):
        """How a garment, by its id, fits the measured person: a GarmentFit."""
        count, best, handle = ctypes.c_size_t(), ctypes.c_size_t(), self._open_handle()
        arguments = (handle, garment.encode())
        status = _lib().im2fit_garment_fit(*arguments, None, ctypes.sizeof(_c.SizeFit), 0, ctypes.byref(count), None)
        if status != _c.TOO_SMALL:
            self._check(status)
        fits = (_c.SizeFit * count.value)()
        self._check(_lib().im2fit_garment_fit(*arguments, fits, ctypes.sizeof(_c.SizeFit), count, ctypes.byref(count),
                                              ctypes.byref(best)))
        sizes = {fit.name.decode(): {
            place.name.decode(): (Estimate(place.ease_mm, place.low_mm, place.high_mm, "mm"),
                                  _lib().im2fit_fit_name(place.verdict).decode())
            for place in fit.regions[:fit.region_count]} for fit in fits}
        return GarmentFit(garment, fits[best.value].name.decode(), sizes)

    def dressed_avatar(self, *worn):
        """The measured person in clothes, as the bytes of a .glb. `worn`, innermost first: the id of a garment, for the best
        size, or a pair of id and size. Without any: trousers and a T-shirt."""
        pairs = [(one, None) if isinstance(one, str) else one for one in worn]
        items = (_c.Worn * len(pairs))(*((garment.encode(), size.encode() if size else None) for garment, size in pairs))
        return self._bytes(_lib().im2fit_dressed_avatar, items, ctypes.c_size_t(len(pairs)))

    def rig(self):
        """The pose of the avatar's nodes (rig_nodes()) in the latest frame: (root, 3 numbers, metres; rotations, 19 x 4, unit
        quaternions x y z w). None when no person is followed in that frame. Needs a measurement."""
        rig = _c.Rig()
        status = _lib().im2fit_live_rig(self._open_handle(), ctypes.byref(rig), ctypes.sizeof(rig))
        if status == _c.NOT_FOUND:
            return None
        self._check(status)
        return np.array(rig.root_m, np.float32), np.array(rig.rotations, np.float32)

    def models(self):
        """A description of the models: a dict with the fields of im2fit_models (made_by, people, captures, tracker_key, and
        has_body, answers_shape, answers_turned, answers_clothed, site_corrected as bool)."""
        models = _c.Models()
        self._check(_lib().im2fit_get_models(self._open_handle(), ctypes.byref(models), ctypes.sizeof(models)))
        known = {name: getattr(models, name) for name, _ in _c.Models._fields_}
        known["made_by"] = known["made_by"].decode()
        return {name: bool(v) if kind is ctypes.c_int32 else v
                for (name, kind), v in zip(_c.Models._fields_, known.values())}

    def set_known(self, stature_mm=0, weight_kg=0, sex=None, age_years=0, stature_sd_mm=0, weight_sd_kg=0, age_sd_years=0):
        """Sets what the person reports of themselves: evidence beside the frames, before, during or after them. A known
        weight makes girths more accurate. Add 0.5 to an age in completed years. `sex` is "woman" or "man". 0 and None: not known. A standard
        deviation of 0 is that of facts as people report them; of a weight from a scale give weight_sd_kg=0.7. A second
        call replaces the first. Person.doubted names what does not fit the frames and was not used."""
        if sex not in (None, "woman", "man"):
            raise ValueError(f"sex {sex!r}: expected 'woman', 'man' or None")
        known = _c.Known()
        _lib().im2fit_known_init(ctypes.byref(known), ctypes.sizeof(known))
        known.stature_mm, known.stature_sd_mm = stature_mm or 0, stature_sd_mm or 0
        known.weight_kg, known.weight_sd_kg = weight_kg or 0, weight_sd_kg or 0
        known.age_years, known.age_sd_years = age_years or 0, age_sd_years or 0
        known.sex = {None: 0, "woman": 1, "man": 2}[sex]
        self._check(_lib().im2fit_set_known(self._open_handle(), ctypes.byref(known)))

    def next(self):
        """Prepares for the next person: frames are processed again. The measurement stays until the measured person has
        left."""
        self._check(_lib().im2fit_next(self._open_handle()))

    def reset(self):
        """Begins a session for a new person and forgets all frames."""
        self._check(_lib().im2fit_reset(self._open_handle()))
        self._number = 0

    def close(self):
        """Frees the session. A second call does nothing."""
        if self._handle:
            _lib().im2fit_close(self._handle)
            self._handle = ctypes.c_void_p()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def __del__(self):
        if getattr(self, "_handle", None):
            self.close()

    def _open_handle(self):
        if not self._handle:
            raise ValueError("the session is closed")
        return self._handle

    def _result(self):
        r = _c.Result()
        self._check(_lib().im2fit_poll(self._open_handle(), ctypes.byref(r), ctypes.sizeof(r)))
        return r

    def _check(self, status):
        if status != _c.OK:
            text = (_lib().im2fit_last_error(self._handle) if self._handle else b"") or _lib().im2fit_last_error(None)
            raise Error(status, text.decode(errors="replace"))

    def _bytes(self, function, *arguments):
        needed = ctypes.c_size_t()
        status = function(self._open_handle(), *arguments, None, 0, ctypes.byref(needed))
        if status != _c.TOO_SMALL:
            self._check(status)
        place = ctypes.create_string_buffer(needed.value + 1)
        self._check(function(self._handle, *arguments, place, needed.value + 1, ctypes.byref(needed)))
        return place.raw[:needed.value]


def _lens_of(distortion):
    """k1, k2, p1, p2, k3: OpenCV's order."""
    numbers = [float(number) for number in np.ravel(distortion)]
    if len(numbers) not in (0, 4, 5):
        raise ValueError(f"distortion has {len(numbers)} numbers, expected k1, k2, p1, p2 and perhaps k3")
    return tuple(numbers + [0.0] * (5 - len(numbers)))


def _camera_options(rotate_deg, calibration):
    options = _c.CamerasOptions()
    _cameras().im2fit_cameras_options_init(ctypes.byref(options), ctypes.sizeof(options))
    if rotate_deg is not None:
        options.rotate_deg = rotate_deg
    if calibration is not None:
        options.calibration_path = os.fsencode(calibration)
    return options


def _upright(width, height, fx, fy, cx, cy, rotate_deg):
    """The camera of the upright picture: hal/rotate.cpp has the same lines."""
    if rotate_deg == 90:
        return height, width, fy, fx, height - 1 - cy, cx
    if rotate_deg == 180:
        return width, height, fx, fy, width - 1 - cx, height - 1 - cy
    if rotate_deg == 270:
        return height, width, fy, fx, cy, width - 1 - cx
    if rotate_deg != 0:
        raise ValueError(f"rotate_deg is {rotate_deg}, expected 0, 90, 180 or 270")
    return width, height, fx, fy, cx, cy


def measure(source, models=None, rotate_deg=None, calibration=None, **settings):
    """Measures the person in a depth folder, a recording (.oni) or before a camera; sources are those of Session.of. Uses
    frames until the measurement, or all of them. Returns a Person: check its `measured` and `guidance`. A folder does not
    need libim2fit-cameras. `settings` are those of Session."""
    if pathlib.Path(source).is_dir() and rotate_deg is None and calibration is None:
        return _measure_folder(pathlib.Path(source), models, settings)
    with Session.of(source, rotate_deg, calibration, models, **settings) as session:
        progress = session.pump()
        while progress is not None and not progress.measured:
            progress = session.pump()
        return session.finish()


def _measure_folder(folder, models, settings):
    camera = _folder.read_camera(folder / "camera.yaml")
    frames, times = _folder.frames_of(folder), _folder.read_times(folder)
    downs = {} if camera.rotate_deg else _folder.read_downs(folder)  # of pictures that are stored upright
    with Session(**dataclasses.asdict(camera), models=models, **settings) as session:
        for number, path in frames:
            time_ns = times.get(number, number * 1_000_000_000 // 30)
            if session.push(_folder.read_frame(path), time_ns=time_ns, sequence=number, down=downs.get(number)).measured:
                break
        return session.finish()
