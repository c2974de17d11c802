# SPDX-License-Identifier: Apache-2.0
"""The C interface im2fit.h and cameras.h for ctypes: structs, statuses, functions. tests/test_sdk.py compares the structs
with the headers, with a C compiler."""

from __future__ import annotations

import ctypes as c
import os
import pathlib
from typing import Any, Iterable

REGIONS, RIG_NODES = 8, 19
MEASUREMENTS, JOINTS, USERS, AGE_BANDS = 11, 15, 8, 4
FORMAT_U16, FORMAT_DEPTH16, FORMAT_F32 = 0, 1, 2
AVATAR_FORMATS = {"glb": 0, "obj": 1, "bvh": 2}


class Data(c.Structure):
    _fields_ = [("kind", c.c_int32), ("fd", c.c_int32), ("offset", c.c_int64), ("bytes", c.c_void_p), ("size", c.c_size_t)]


class Settings(c.Structure):
    _fields_ = [
        ("struct_size", c.c_size_t), ("tracker_path", c.c_char_p), ("index_path", c.c_char_p), ("body_path", c.c_char_p),
        ("men_chart_path", c.c_char_p), ("women_chart_path", c.c_char_p), ("width", c.c_int32), ("height", c.c_int32),
        ("fx", c.c_float), ("fy", c.c_float), ("cx", c.c_float), ("cy", c.c_float), ("frames_wanted", c.c_int32),
        ("frames_min", c.c_int32), ("calibration_psi", c.c_int32), ("live", c.c_int32), ("single_thread", c.c_int32),
        ("pool_frames", c.c_int32), ("log", c.c_void_p), ("log_user", c.c_void_p), ("user_id", c.c_int32), ("turn", c.c_int32),
        ("clothing", c.c_int32), ("sensor", c.c_int32), ("tracker_data", Data), ("index_data", Data), ("body_data", Data),
        ("calibration_site_path", c.c_char_p), ("calibration_site_data", Data),
        ("pack_path", c.c_char_p), ("pack_data", Data)]


class Frame(c.Structure):
    _fields_ = [
        ("struct_size", c.c_size_t), ("pixels", c.c_void_p), ("format", c.c_int32), ("width", c.c_int32), ("height", c.c_int32),
        ("rotate_deg", c.c_int32), ("row_bytes", c.c_size_t), ("unit_mm", c.c_float), ("confidence_min", c.c_int32),
        ("confidence", c.c_void_p), ("confidence_row_bytes", c.c_size_t), ("fx", c.c_float), ("fy", c.c_float),
        ("cx", c.c_float), ("cy", c.c_float), ("sequence", c.c_uint64), ("time_ns", c.c_int64), ("device_us", c.c_int64),
        ("down_x", c.c_float), ("down_y", c.c_float), ("down_z", c.c_float), ("reserved", c.c_float),
        ("k1", c.c_float), ("k2", c.c_float), ("k3", c.c_float), ("p1", c.c_float), ("p2", c.c_float), ("reserved2", c.c_float),
        ("turn_x", c.c_float), ("turn_y", c.c_float), ("turn_z", c.c_float), ("turn_w", c.c_float), ("x_mm", c.c_float),
        ("y_mm", c.c_float), ("z_mm", c.c_float), ("reserved3", c.c_float)]


class Estimate(c.Structure):
    _fields_ = [("value", c.c_float), ("low", c.c_float), ("high", c.c_float)]


class Joint(c.Structure):
    _fields_ = [("x", c.c_float), ("y", c.c_float), ("z", c.c_float), ("confidence", c.c_float)]


class User(c.Structure):
    _fields_ = [("id", c.c_int32), ("left", c.c_int32), ("top", c.c_int32), ("right", c.c_int32), ("bottom", c.c_int32),
                ("x", c.c_float), ("y", c.c_float), ("z", c.c_float)]


class Result(c.Structure):
    _fields_ = [
        ("state", c.c_int32), ("guidance", c.c_uint32), ("guidance_seen", c.c_uint32), ("has_joints", c.c_int32),
        ("frames_seen", c.c_uint64), ("frames_used", c.c_uint64), ("frames_dropped", c.c_uint64), ("sequence_gaps", c.c_uint64),
        ("sequence_repeats", c.c_uint64), ("time_reversals", c.c_uint64), ("joints", Joint * JOINTS), ("measured", c.c_int32),
        ("female", c.c_float), ("measurements", Estimate * MEASUREMENTS), ("paper", c.c_float * MEASUREMENTS),
        ("index_entry", c.c_uint32), ("index_distance", c.c_float), ("user_id", c.c_int32), ("view", c.c_int32),
        ("joints_inferred", c.c_uint32), ("session", c.c_uint32), ("display_joints", Joint * JOINTS), ("user_count", c.c_int32),
        ("users", User * USERS), ("front_measured", c.c_int32), ("views", c.c_int32), ("frames_back", c.c_uint32),
        ("age", Estimate), ("age_bands", c.c_float * AGE_BANDS), ("arms_close", c.c_uint32),
        ("clothing_probability", c.c_float), ("clothing_ease_mm", c.c_float), ("known_used", c.c_uint32),
        ("known_doubted", c.c_uint32), ("turned_deg", c.c_float), ("frames_wanted", c.c_int32),
        ("users_outside", c.c_uint32), ("users_still", c.c_uint32)]


class MaskInfo(c.Structure):
    _fields_ = [("width", c.c_int32), ("height", c.c_int32), ("user_id", c.c_int32), ("reserved", c.c_int32),
                ("sequence", c.c_uint64), ("time_ns", c.c_int64)]


class Known(c.Structure):
    _fields_ = [("struct_size", c.c_size_t), ("stature_mm", c.c_float), ("stature_sd_mm", c.c_float), ("weight_kg", c.c_float),
                ("weight_sd_kg", c.c_float), ("age_years", c.c_float), ("age_sd_years", c.c_float), ("sex", c.c_int32),
                ("reserved", c.c_int32)]


class RegionFit(c.Structure):
    _fields_ = [("name", c.c_char_p), ("ease_mm", c.c_float), ("low_mm", c.c_float), ("high_mm", c.c_float),
                ("verdict", c.c_int32)]


class SizeFit(c.Structure):
    _fields_ = [("name", c.c_char * 32), ("cost", c.c_float), ("region_count", c.c_int32), ("regions", RegionFit * REGIONS)]


class Diagnosis(c.Structure):
    _fields_ = [("code", c.c_int32), ("rotate_deg", c.c_int32), ("unit_mm", c.c_float), ("text", c.c_char * 244)]


class Worn(c.Structure):
    _fields_ = [("garment", c.c_char_p), ("size", c.c_char_p)]


class Size(c.Structure):
    _fields_ = [("name", c.c_char * 32), ("probability", c.c_float)]


class TapeValue(c.Structure):
    _fields_ = [("status", c.c_int32), ("value", c.c_float), ("low", c.c_float), ("high", c.c_float), ("reason", c.c_char_p)]


class Rig(c.Structure):
    _fields_ = [("root_m", c.c_float * 3), ("rotations", c.c_float * 4 * RIG_NODES), ("user_id", c.c_int32),
                ("joints_inferred", c.c_uint32)]


class Models(c.Structure):
    _fields_ = [("made_by", c.c_char_p), ("people", c.c_uint32), ("captures", c.c_uint32), ("tracker_key", c.c_uint32),
                ("has_body", c.c_int32), ("answers_shape", c.c_int32), ("answers_turned", c.c_int32),
                ("answers_clothed", c.c_int32), ("site_corrected", c.c_int32)]


class CamerasOptions(c.Structure):
    _fields_ = [("struct_size", c.c_size_t), ("calibration_path", c.c_char_p), ("rotate_deg", c.c_int32), ("width", c.c_int32),
                ("height", c.c_int32), ("unit_mm", c.c_float)]


STRUCTS = {"im2fit_data": Data, "im2fit_settings": Settings, "im2fit_frame": Frame, "im2fit_estimate": Estimate,
           "im2fit_joint": Joint, "im2fit_known": Known, "im2fit_user": User, "im2fit_result": Result,
           "im2fit_mask_info": MaskInfo, "im2fit_size": Size, "im2fit_tape_value": TapeValue,
           "im2fit_region_fit": RegionFit, "im2fit_size_fit": SizeFit, "im2fit_worn": Worn, "im2fit_rig": Rig,
           "im2fit_models": Models, "im2fit_cameras_options": CamerasOptions}


def load(path: str | None = None) -> c.CDLL:
    """Loads libim2fit: `path`, else IM2FIT_LIBRARY, else the one of this package, else the system's."""
    beside = pathlib.Path(__file__).with_name("libim2fit.so.0")
    name = path or os.environ.get("IM2FIT_LIBRARY") or (str(beside) if beside.exists() else "libim2fit.so.0")
    try:
        if name == str(beside):
            # What the wheel brings for it: loaded first, it is found by its name.
            for needed in sorted(beside.parent.glob("lib*.so.*")):
                if needed != beside:
                    c.CDLL(str(needed))
        lib = c.CDLL(name)
    except OSError as error:
        raise OSError(f"{error}; install libim2fit0 or the wheel, or set IM2FIT_LIBRARY to libim2fit.so") from None
    pointer = c.c_void_p
    _declare(lib, (
            ("version", c.c_char_p, []), ("status_name", c.c_char_p, [c.c_int]), ("last_error", c.c_char_p, [pointer]),
            ("settings_init", None, [c.POINTER(Settings), c.c_size_t]), ("frame_init", None, [c.POINTER(Frame), c.c_size_t]),
            ("open", c.c_int, [c.POINTER(Settings), c.POINTER(pointer)]), ("close", None, [pointer]),
            ("push_frame", c.c_int, [pointer, c.POINTER(Frame)]), ("wait", c.c_int, [pointer, c.c_int32]),
            ("known_init", None, [c.POINTER(Known), c.c_size_t]), ("set_known", c.c_int, [pointer, c.POINTER(Known)]),
            ("finish", c.c_int, [pointer]), ("reset", c.c_int, [pointer]), ("next", c.c_int, [pointer]),
            ("poll", c.c_int, [pointer, c.POINTER(Result), c.c_size_t]),
            ("mask", c.c_int, [pointer, pointer, c.c_size_t, c.POINTER(MaskInfo), c.c_size_t]),
            ("result_json", c.c_int, [pointer, pointer, c.c_size_t, c.POINTER(c.c_size_t)]),
            ("avatar", c.c_int, [pointer, c.c_int32, pointer, c.c_size_t, c.POINTER(c.c_size_t)]),
            ("body_mesh", c.c_int, [pointer, pointer, c.c_size_t, c.POINTER(c.c_size_t), pointer, c.c_size_t,
                                    c.POINTER(c.c_size_t)]),
            ("garment_fit", c.c_int, [pointer, c.c_char_p, c.POINTER(SizeFit), c.c_size_t, c.c_size_t, c.POINTER(c.c_size_t),
                                      c.POINTER(c.c_size_t)]),
            ("dressed_avatar", c.c_int, [pointer, c.POINTER(Worn), c.c_size_t, pointer, c.c_size_t, c.POINTER(c.c_size_t)]),
            ("live_rig", c.c_int, [pointer, c.POINTER(Rig), c.c_size_t]),
            ("get_models", c.c_int, [pointer, c.POINTER(Models), c.c_size_t]),
            ("body_residual", c.c_int, [pointer, c.POINTER(c.c_float)]), ("measurement_name", c.c_char_p, [c.c_int]),
            ("garment_name", c.c_char_p, [c.c_size_t, c.c_char_p]),
            ("garment_count", c.c_size_t, []), ("garment_id", c.c_char_p, [c.c_size_t]), ("fit_name", c.c_char_p, [c.c_int]),
            ("rig_node_name", c.c_char_p, [c.c_int]), ("rig_node_parent", c.c_int, [c.c_int]),
            ("attach", c.c_int, [pointer, c.c_char_p]), ("pump", c.c_int, [pointer, c.c_int32]), ("detach", c.c_int, [pointer]),
            ("select_user", c.c_int, [pointer, c.c_int32]),
            ("set_region", c.c_int, [pointer, c.c_float, c.c_float, c.c_float, c.c_float]),
            ("sizes", c.c_int, [pointer, c.POINTER(Size), c.c_size_t, c.POINTER(c.c_size_t), c.POINTER(c.c_size_t)]),
            ("tape", c.c_int, [pointer, c.POINTER(c.c_char_p), c.c_size_t, c.POINTER(TapeValue), c.c_size_t]),
            ("tape_count", c.c_size_t, []), ("tape_id", c.c_char_p, [c.c_size_t]), ("tape_unit", c.c_char_p, [c.c_size_t]),
            ("tape_iso", c.c_char_p, [c.c_size_t]), ("tape_name", c.c_char_p, [c.c_size_t, c.c_char_p]),
            ("joint_name", c.c_char_p, [c.c_int]), ("state_name", c.c_char_p, [c.c_int]),
            ("diagnose", c.c_int, [pointer, c.POINTER(c.c_uint16), c.c_int32, c.c_int32, c.c_size_t, c.POINTER(Diagnosis),
                                   c.c_size_t]),
            ("diagnosis_name", c.c_char_p, [c.c_int]),
            ("guidance_name", c.c_char_p, [c.c_int]), ("guidance_text", c.c_char_p, [c.c_int, c.c_char_p])))
    return lib


def load_cameras() -> c.CDLL:
    """Loads libim2fit-cameras, after load(): IM2FIT_CAMERAS_LIBRARY, else the system's."""
    name = os.environ.get("IM2FIT_CAMERAS_LIBRARY") or "libim2fit-cameras.so.0"
    try:
        lib = c.CDLL(name)
    except OSError as error:
        raise OSError(f"{error}; cameras and recordings need libim2fit-cameras: install libim2fit-cameras0, or set "
                      "IM2FIT_CAMERAS_LIBRARY to libim2fit-cameras.so") from None
    options = c.POINTER(CamerasOptions)
    _declare(lib, (("cameras_options_init", None, [options, c.c_size_t]),
                   ("cameras_describe", c.c_int, [c.c_char_p, options, c.POINTER(Settings)]),
                   ("cameras_use", c.c_int, [c.c_void_p, options]), ("cameras_error", c.c_char_p, [])))
    return lib


def _declare(lib: c.CDLL, functions: Iterable[tuple[str, Any, list[Any]]]) -> None:
    for function, result, arguments in functions:
        handle = getattr(lib, "im2fit_" + function)
        handle.restype, handle.argtypes = result, arguments
