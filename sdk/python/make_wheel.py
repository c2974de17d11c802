#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""make_wheel.py LIBRARY OUT: the wheel of this package with libim2fit.so inside, into the directory OUT. No other tool is
needed; the same files give the same bytes."""

import base64
import hashlib
import pathlib
import re
import sys
import zipfile

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
MACHINES = {62: "x86_64", 183: "aarch64", 40: "armv7l"}  # e_machine of ELF


def machine_of(library):
    if library[:4] != b"\x7fELF":
        sys.exit("make_wheel: the library is no ELF file")
    number = int.from_bytes(library[18:20], "little")
    return MACHINES.get(number) or sys.exit(f"make_wheel: the library is for machine {number}")


def main(library_path, out):
    library = pathlib.Path(library_path).read_bytes()
    version = re.search(r"^project\(im2fit VERSION ([\d.]+)", (ROOT / "CMakeLists.txt").read_text(), re.M).group(1)
    tag, info = f"py3-none-linux_{machine_of(library)}", f"im2fit-{version}.dist-info"
    files = {f"im2fit/{path.name}": path.read_bytes() for path in sorted((HERE / "im2fit").glob("*.py"))}
    files["im2fit/py.typed"] = b""  # type checkers read the annotations
    files["im2fit/libim2fit.so.0"] = library
    files[f"{info}/licenses/LICENSE"] = (ROOT / "LICENSE").read_bytes()
    files[f"{info}/licenses/NOTICE"] = (ROOT / "NOTICE").read_bytes()
    files[f"{info}/METADATA"] = (
        f"Metadata-Version: 2.1\nName: im2fit\nVersion: {version}\nSummary: Body measurements from a depth camera\n"
        "License: Apache-2.0\nRequires-Python: >=3.9\nRequires-Dist: numpy>=1.20\nClassifier: Typing :: Typed\n"
        "Description-Content-Type: text/markdown\n\n" +
        (HERE / "README.md").read_text()).encode()
    files[f"{info}/WHEEL"] = f"Wheel-Version: 1.0\nGenerator: im2fit\nRoot-Is-Purelib: false\nTag: {tag}\n".encode()
    record = f"{info}/RECORD"
    files[record] = "".join(
        f"{name},sha256={base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b'=').decode()},{len(data)}\n"
        for name, data in files.items()).encode() + f"{record},,\n".encode()
    path = pathlib.Path(out) / f"im2fit-{version}-{tag}.whl"
    path.parent.mkdir(parents=True, exist_ok=True)
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as wheel:
        for name, data in files.items():
            entry = zipfile.ZipInfo(name, (1980, 1, 1, 0, 0, 0))
            entry.compress_type, entry.external_attr = zipfile.ZIP_DEFLATED, 0o644 << 16
            wheel.writestr(entry, data)
    print(path)


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(*sys.argv[1:])
