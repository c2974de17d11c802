# SPDX-License-Identifier: Apache-2.0
"""Depth folders (docs/cameras/folders-and-recordings.md): 16-bit PNG or PGM in millimetres, and camera.yaml."""

from __future__ import annotations

import csv
import dataclasses
import importlib
import os
import pathlib
import re
import struct
import zlib
from typing import Any, Iterator

import numpy as np
import numpy.typing as npt

from ._camera import Camera

Image: Any = None
try:  # ten times faster than read_png below
    Image = importlib.import_module("PIL.Image")
except ImportError:
    pass


@dataclasses.dataclass(frozen=True)
class DepthFrame:
    """A frame of a folder: arguments of Session.push."""

    depth: npt.NDArray[np.uint16]
    time_ns: int
    sequence: int
    down: tuple[float, ...] | None


class DepthFolder:
    """A depth folder: its `camera`, and its frames, which are read one by one as a loop comes to them."""

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = pathlib.Path(path)
        self.camera = read_camera(self.path / "camera.yaml")
        self._frames, self._times = frames_of(self.path), read_times(self.path)
        self._downs = {} if self.camera.rotate_deg else read_downs(self.path)  # they are of pictures that are stored upright

    def __len__(self) -> int:
        return len(self._frames)

    def __iter__(self) -> Iterator[DepthFrame]:
        for number, path in self._frames:
            time_ns = self._times.get(number, number * 1_000_000_000 // 30)
            yield DepthFrame(read_frame(path), time_ns, number, self._downs.get(number))


def _numbers(text: str, key: str, path: str | os.PathLike[str], required: bool = True) -> list[float]:
    found = re.search(rf"^{key}:\s*\n(?:\s+(?:rows|cols):.*\n)*\s+data:\s*\[([^\]]*)\]", text, re.M)
    if not found:
        if required:
            raise ValueError(f"{path}: no {key} with data: [...]")
        return []
    return [float(word) for word in found.group(1).split(",")]


def read_camera(path: str | os.PathLike[str]) -> Camera:
    text = pathlib.Path(path).read_text(encoding="utf-8")

    def whole(key: str, default: int | None = None) -> int:
        found = re.search(rf"^{key}:\s*(-?\d+)\s*$", text, re.M)
        if found:
            return int(found.group(1))
        if default is None:
            raise ValueError(f"{path}: no {key}")
        return default

    k = _numbers(text, "camera_matrix", path)
    lens = _numbers(text, "distortion_coefficients", path, required=False)
    if any(lens):
        model = re.search(r"^distortion_model:\s*(\S+)\s*$", text, re.M)
        if len(lens) not in (4, 5) or (model and model.group(1) != "plumb_bob"):
            raise ValueError(f"{path}: {len(lens)} distortion_coefficients of {model.group(1) if model else 'no model'}; this "
                             "reader supports plumb_bob's 4 or 5; measure with the program im2fit")
    return Camera(whole("image_width"), whole("image_height"), k[0], k[4], k[2], k[5], whole("im2fit_rotate_deg", 0),
                  tuple(lens) if any(lens) else ())


def _unfilter(raw: bytes, width: int, height: int) -> npt.NDArray[np.uint8]:
    stride = 2 * width
    rows = np.frombuffer(raw, np.uint8).reshape(height, stride + 1)
    out = np.zeros((height + 1, stride), np.uint8)  # a row of zeros above the first
    for y in range(height):
        how, row, above = rows[y, 0], rows[y, 1:], out[y]
        if how == 0:
            out[y + 1] = row
        elif how == 1:  # the difference from the sample before, byte by byte
            out[y + 1] = np.cumsum(row.reshape(-1, 2), axis=0, dtype=np.uint8).reshape(-1)
        elif how == 2:
            out[y + 1] = row + above
        else:
            line, up = bytearray(row.tobytes()), above.tobytes()
            for i in range(stride):
                a, b, left_above = (line[i - 2], up[i], up[i - 2]) if i > 1 else (0, up[i], 0)
                if how == 3:
                    guess = (a + b) // 2
                else:
                    p = a + b - left_above
                    pa, pb, pc = abs(p - a), abs(p - b), abs(p - left_above)
                    guess = a if pa <= pb and pa <= pc else b if pb <= pc else left_above
                line[i] = (line[i] + guess) & 255
            out[y + 1] = np.frombuffer(bytes(line), np.uint8)
    return out[1:].reshape(height, width, 2)


def read_png(path: pathlib.Path) -> npt.NDArray[np.uint16]:
    if Image is not None:
        with Image.open(path) as picture:
            if not picture.mode.startswith("I"):
                raise ValueError(f"{path}: not a 16-bit grey picture")
            return np.asarray(picture).astype(np.uint16)
    data, at, packed, head = pathlib.Path(path).read_bytes(), 8, b"", None
    while at + 8 <= len(data):
        size, kind = struct.unpack(">I4s", data[at:at + 8])
        if kind == b"IHDR":
            head = struct.unpack(">IIBBBBB", data[at + 8:at + 21])
        elif kind == b"IDAT":
            packed += data[at + 8:at + 8 + size]
        at += 12 + size
    if head is None or head[2:4] != (16, 0) or head[6] != 0:
        raise ValueError(f"{path}: not a 16-bit grey PNG without interlacing")
    pairs = _unfilter(zlib.decompress(packed), head[0], head[1]).astype(np.uint16)
    return (pairs[..., 0] << 8 | pairs[..., 1]).astype(np.uint16)


def read_pgm(path: pathlib.Path) -> npt.NDArray[np.uint16]:
    data = pathlib.Path(path).read_bytes()
    head = re.match(rb"P5\s+(?:#[^\n]*\n\s*)*(\d+)\s+(\d+)\s+(\d+)\s", data)
    if not head or int(head.group(3)) < 256:
        raise ValueError(f"{path}: not a 16-bit PGM")
    width, height = int(head.group(1)), int(head.group(2))
    return np.frombuffer(data, ">u2", width * height, head.end()).reshape(height, width).astype(np.uint16)


def frames_of(folder: str | os.PathLike[str]) -> list[tuple[int, pathlib.Path]]:
    """(number, path) of the frames, in order."""
    found = []
    for path in pathlib.Path(folder).iterdir():
        name = re.fullmatch(r"(\d+)\.(png|pgm)", path.name)
        if name:
            found.append((int(name.group(1)), path))
    if not found:
        raise FileNotFoundError(f"{folder} holds no depth frames: expected 16-bit files 000000.png or 000000.pgm, ...")
    return sorted(found)


def read_times(folder: str | os.PathLike[str]) -> dict[int, int]:
    """host_ns by frame number, from timestamps.csv; empty without one."""
    path = pathlib.Path(folder) / "timestamps.csv"
    if not path.exists():
        return {}
    with open(path, newline="", encoding="utf-8") as stream:
        return {int(row["frame"]): int(row["host_ns"]) if "host_ns" in row else 1000 * int(row["device_us"])
                for row in csv.DictReader(stream)}


def read_downs(folder: str | os.PathLike[str]) -> dict[int, tuple[float, ...]]:
    """The direction of gravity by frame number, of the frames for which timestamps.csv has one."""
    path, names = pathlib.Path(folder) / "timestamps.csv", ("down_x", "down_y", "down_z")
    if not path.exists():
        return {}
    with open(path, newline="", encoding="utf-8") as stream:
        return {int(row["frame"]): tuple(float(row[name]) for name in names)
                for row in csv.DictReader(stream) if all(row.get(name) for name in names)}


def read_frame(path: pathlib.Path) -> npt.NDArray[np.uint16]:
    return read_png(path) if path.suffix == ".png" else read_pgm(path)
