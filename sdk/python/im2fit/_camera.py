# SPDX-License-Identifier: Apache-2.0
"""A depth camera: where its lens, its mounting and its pose are brought into the terms of im2fit.h."""

from __future__ import annotations

import dataclasses
import math
from typing import Sequence

import numpy as np
import numpy.typing as npt


@dataclasses.dataclass
class Camera:
    """A depth camera: the first arguments of Session. In pixels of the frames as stored; `rotate_deg` makes them upright."""

    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float
    rotate_deg: int = 0
    distortion: tuple[float, ...] = ()  # OpenCV's order: k1, k2, p1, p2, k3


def upright(width: int, height: int, fx: float, fy: float, cx: float, cy: float,
             rotate_deg: int) -> tuple[int, int, float, float, float, float]:
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


def lens_of(distortion: Sequence[float]) -> tuple[float, ...]:
    """k1, k2, p1, p2, k3: OpenCV's order."""
    numbers = [float(number) for number in np.ravel(distortion)]
    if len(numbers) not in (0, 4, 5):
        raise ValueError(f"distortion has {len(numbers)} numbers, expected k1, k2, p1, p2 and perhaps k3")
    return tuple(numbers + [0.0] * (5 - len(numbers)))


def pose_of(pose: npt.ArrayLike) -> list[float]:
    """The seven numbers of im2fit_frame, of themselves or of a 4x4 matrix with metres."""
    given = np.asarray(pose, np.float64)
    if given.shape == (7,):
        return [float(number) for number in given]
    if given.shape != (4, 4):
        raise ValueError(f"pose is {given.shape}, expected a 4x4 matrix, or 7 numbers: x, y, z, w of the turn and mm")
    turn = given[:3, :3]
    if not (np.allclose(turn @ turn.T, np.eye(3), atol=1e-3) and np.linalg.det(turn) > 0
            and np.array_equal(given[3], (0, 0, 0, 1))):
        raise ValueError("pose is not a rigid motion: expected the 3x3 of a rotation, not mirrored or scaled, and 0 0 0 1 in the "
                         f"last row, found {given.tolist()}")
    # Four times the squares of w, x, y, z. The largest divides: a small one would amplify rounding.
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = turn
    which = int(np.argmax((1 + xx + yy + zz, 1 + xx - yy - zz, 1 - xx + yy - zz, 1 - xx - yy + zz)))
    w, x, y, z = ((1 + xx + yy + zz, zy - yz, xz - zx, yx - xy), (zy - yz, 1 + xx - yy - zz, xy + yx, xz + zx),
                  (xz - zx, xy + yx, 1 - xx + yy - zz, yz + zy), (yx - xy, xz + zx, yz + zy, 1 - xx - yy + zz))[which]
    length = math.sqrt(w * w + x * x + y * y + z * z)
    return [float(n) for n in (x / length, y / length, z / length, w / length, *(1000 * given[:3, 3]))]
