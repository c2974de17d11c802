# SPDX-License-Identifier: Apache-2.0
"""The enumerations of im2fit.h, with the names and numbers that the header gives them. tests/test_sdk.py compares them."""

from __future__ import annotations

import enum


class _Number(enum.IntEnum):
    """Prints as its name. What enum.IntEnum prints depends on the version of Python."""

    @classmethod
    def _missing_(cls, value: object) -> _Number | None:
        # A newer library may know more than this package does.
        if not isinstance(value, int):
            return None
        member = int.__new__(cls, value)
        member._name_, member._value_ = f"NUMBER_{value}", value
        return member

    def __str__(self) -> str:
        return self.name

    def __repr__(self) -> str:
        return f"{type(self).__name__}.{self.name}"

    def __format__(self, spec: str) -> str:
        return format(self.name, spec)


class Status(_Number):
    """Of an Error."""

    OK = 0
    INVALID_ARGUMENT = -1
    NOT_FOUND = -2
    IO = -3
    CORRUPT = -4
    UNSUPPORTED = -5
    NO_DEVICE = -6
    TIMEOUT = -7
    END_OF_STREAM = -8
    NO_MEMORY = -9
    NOT_MEASURED = -10
    TOO_SMALL = -11
    INTERNAL = -12
    FORKED = -13


class State(_Number):
    """Of a session."""

    SEARCHING = 0
    USER_FOUND = 1
    CALIBRATING = 2
    TRACKING = 3
    MEASURED = 4
    LOST = 5
    TURNING = 6


class GuidanceCode(_Number):
    """What the person or the scene must change (docs/result.md)."""

    NO_PERSON = 1 << 0
    TOO_NEAR = 1 << 1
    TOO_FAR = 1 << 2
    FEET_CUT = 1 << 3
    HEAD_CUT = 1 << 4
    ARMS_CLOSE = 1 << 5
    NOT_FRONTAL = 1 << 6
    NOT_UPRIGHT = 1 << 7
    MOVING = 1 << 8
    SEVERAL_PEOPLE = 1 << 9
    TOO_NOISY = 1 << 10
    SIDE_CUT = 1 << 11
    CALIBRATION_POSE = 1 << 12
    TURN_ROUND = 1 << 13
    CLOTHED = 1 << 14
    TURN_ON = 1 << 15
    TURN_SLOWER = 1 << 16
    WALK_ROUND = 1 << 17
    OUT_OF_POPULATION = 1 << 18
    FLOOR_BENT = 1 << 19
    FEET_RAISED = 1 << 20
    HEAD_UNSEEN = 1 << 21
    STEP_TO_THE_MIDDLE = 1 << 22
    DEPTH_MISSING = 1 << 23


class View(_Number):
    """The side of the person that faces the camera."""

    UNKNOWN = 0
    FRONT = 1
    BACK = 2
    SIDE = 3


class Turn(_Number):
    """What is measured besides the front. AROUND: one slow turn on the spot; waist, hip and weight gain most. WALK: the
    same, but the person stands still and the camera is carried round; each frame has its pose."""

    NONE = 0
    BACK = 1
    AROUND = 2
    WALK = 3


class Sensor(_Number):
    """How a camera senses depth. UNKNOWN: estimated from the frames. STEREO (RealSense D400, OAK-D) counts as structured
    light, the nearest kind that models have learned."""

    UNKNOWN = 0
    STRUCTURED_LIGHT = 1
    TIME_OF_FLIGHT = 2
    STEREO = 3


class Clothing(_Number):
    """What the person wears. UNKNOWN: estimated from the frames."""

    UNKNOWN = 0
    BARE = 1
    DRESSED = 2


class Sex(_Number):
    """Of Session.set_known."""

    UNKNOWN = 0
    WOMAN = 1
    MAN = 2


class TapeStatus(_Number):
    """Of a TapeValue. REFUSED: never measured. ABSENT: this body has no such section."""

    MEASURED = 0
    REFUSED = 1
    ABSENT = 2


class Verdict(_Number):
    """How a garment fits in a region."""

    TIGHT = 0
    SNUG = 1
    GOOD = 2
    LOOSE = 3
