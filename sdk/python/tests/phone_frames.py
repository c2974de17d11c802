#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""phone_frames.py FOLDER: what one person measures through frames as phones deliver them (docs/notebook/phones.md).

FOLDER is of `im2fit-lab render --frames 40`, a Kinect at rest. Its samples are seen again by a smaller camera that is at rest or
trembles in the hand, with a focal length that breathes by 1 %. The same pictures are pushed as plain U16, as ARCore delivers them
(U16, confidence, pose, intrinsics) and as ARKit does (metres, confidence, pose, intrinsics). Where a picture has no depth, those
two have wrong depth of low confidence in three of ten samples. Models are found as `im2fit.Models.find()` does."""

import pathlib
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
import im2fit  # noqa: E402

TREMOR_DEG, TREMOR_MM, BREATH = 1.5, 15.0, 0.01


def rotation(axis_angle):
    angle = float(np.linalg.norm(axis_angle))
    if angle == 0:
        return np.eye(3)
    x, y, z = axis_angle / angle
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def seen(points, turn, place, size, k):
    """The depth of points (3 x n, mm) in a picture of a camera at turn and place: the nearest sample of each pixel, 0 for none."""
    x, y, z = turn.T @ (points - place[:, None])
    u, v = np.rint(k[0] * x / z + k[2]).astype(int), np.rint(k[1] * y / z + k[3]).astype(int)
    inside = (u >= 0) & (v >= 0) & (u < size[0]) & (v < size[1])
    depth = np.full((size[1], size[0]), np.inf)
    np.minimum.at(depth, (v[inside], u[inside]), z[inside])
    return np.where(np.isfinite(depth), depth, 0)


def measured(folder, size, kind, moving):
    camera = folder.camera
    scale = size[0] / camera.width
    base = np.array([camera.fx * scale, camera.fy * scale, (camera.cx + 0.5) * scale - 0.5, (camera.cy + 0.5) * scale - 0.5])
    v, u = np.mgrid[0:camera.height, 0:camera.width]
    random = np.random.default_rng(3)
    with im2fit.Session(*size, *base, rotate_deg=camera.rotate_deg, frames_wanted=30) as session:
        for i, frame in enumerate(folder):
            turn, place, k, phase = np.eye(3), np.zeros(3), base.copy(), 2 * np.pi * i / 30
            if moving:
                turn = rotation(np.radians(TREMOR_DEG) * np.sin([1.3 * phase, 1.7 * phase + 1.6, 2.1 * phase]))
                place = TREMOR_MM * np.sin([phase, 0.7 * phase + 1.6, 0.5 * phase])
                k[:2] *= 1 + BREATH * np.sin(0.9 * phase)
            has = frame.depth > 0
            z = frame.depth[has].astype(float)
            points = np.stack([(u[has] - camera.cx) / camera.fx * z, (v[has] - camera.cy) / camera.fy * z, z])
            depth = seen(points, turn, place, size, k)
            pose = np.eye(4)
            pose[:3, :3], pose[:3, 3] = turn, place / 1000
            words = {"time_ns": i * 33_333_333, "pose": pose, "intrinsics": k}
            wrong = (depth == 0) & (random.random(depth.shape) < 0.3)
            sure = np.where(wrong, 0, 2).astype(np.uint8)
            if kind == "ARKit":
                progress = session.push(np.where(wrong, 0.9, depth / 1000).astype(np.float32), confidence=sure, confidence_min=1, **words)
            elif kind == "ARCore":
                progress = session.push(np.where(wrong, 900, np.rint(depth)).astype(np.uint16), confidence=127 * sure,
                                        confidence_min=128, **words)
            else:
                progress = session.push(np.rint(depth).astype(np.uint16), **words)
            if progress.measured:
                break
        person = session.finish()
    if not person.measured:
        sys.exit(f"phone_frames: {kind}, {size}: not measured: {person.guidance}")
    return {name: value.value for name, value in person.measurements.items() if value.unit == "mm"}


def main(path):
    folder = im2fit.read_folder(path)
    for size in ((256, 192), (160, 120)):
        for moving in (False, True):
            plain = measured(folder, size, "U16", moving)
            for kind in ("ARCore", "ARKit"):
                differences = {name: value - plain[name] for name, value in measured(folder, size, kind, moving).items()}
                worst = max(differences, key=lambda name: abs(differences[name]))
                print(f"{size[0]}x{size[1]} {'in the hand' if moving else 'at rest'}, {kind} minus U16: at most "
                      f"{differences[worst]:+.1f} mm ({worst})", flush=True)


if __name__ == "__main__":
    if len(sys.argv) != 2 or sys.argv[1].startswith("-"):
        sys.exit(__doc__)
    main(sys.argv[1])
