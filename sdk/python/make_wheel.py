#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""make_wheel.py LIBRARY OUT [NEEDED LICENCE]...: the wheel of this package with libim2fit.so inside, into the directory OUT, and
with libraries that it needs and other systems may lack, and their licences. No other tool is needed; the same files give the same bytes.

The tag says on which systems it runs: manylinux_2_X for glibc 2.X and newer, by the versions of the names that the
libraries ask for, where they need nothing else but what those systems all have (PEP 600)."""

import base64
import hashlib
import pathlib
import re
import sys
import zipfile

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
MACHINES = {62: "x86_64", 183: "aarch64", 40: "armv7l"}  # e_machine of ELF


# What every system of a manylinux tag has, of that which our libraries may need; and its versions, oldest first.
EVERYWHERE = {"libc.so.6", "libm.so.6", "libpthread.so.0", "libdl.so.2", "librt.so.1", "libgcc_s.so.1", "libstdc++.so.6",
              "ld-linux-x86-64.so.2", "ld-linux-aarch64.so.1"}
POLICIES = [("2_28", {"GLIBC": (2, 28), "GLIBCXX": (3, 4, 25), "CXXABI": (1, 3, 11), "GCC": (7, 0, 0)}),
            ("2_34", {"GLIBC": (2, 34), "GLIBCXX": (3, 4, 29), "CXXABI": (1, 3, 13), "GCC": (7, 0, 0)}),
            ("2_35", {"GLIBC": (2, 35), "GLIBCXX": (3, 4, 30), "CXXABI": (1, 3, 13), "GCC": (12, 0, 0)})]


def tag_of(libraries):
    """The platform's part of the wheel's tag, for libraries by their names (DT_SONAME)."""
    text = b"".join(libraries.values())
    machine = machine_of(next(iter(libraries.values())))
    needed = {name.decode() for name in re.findall(rb"(?<=\0)((?:lib[\w+-]+|ld-linux[\w-]*)\.so\.\d+)(?=\0)", text)}
    versions = {}
    for kind, number in re.findall(rb"(?<=\0)(GLIBC|GLIBCXX|CXXABI|GCC)_(\d+(?:\.\d+)+)(?=\0)", text):
        versions.setdefault(kind.decode(), set()).add(tuple(map(int, number.split(b"."))))
    if needed <= EVERYWHERE | set(libraries):
        for name, most in POLICIES:
            if all(max(found) <= most[kind] for kind, found in versions.items()):
                return f"manylinux_{name}_{machine}"
    return f"linux_{machine}"


def machine_of(library):
    if library[:4] != b"\x7fELF":
        sys.exit("make_wheel: the library is no ELF file")
    number = int.from_bytes(library[18:20], "little")
    return MACHINES.get(number) or sys.exit(f"make_wheel: the library is for machine {number}")


def main(library_path, out, *needed):
    libraries = {"libim2fit.so.0": pathlib.Path(library_path).read_bytes()}
    libraries.update((pathlib.Path(path).name, pathlib.Path(path).read_bytes()) for path in needed[::2])
    version = re.search(r"^project\(im2fit VERSION ([\d.]+)", (ROOT / "CMakeLists.txt").read_text(), re.M).group(1)
    tag, info = f"py3-none-{tag_of(libraries)}", f"im2fit-{version}.dist-info"
    files = {f"im2fit/{path.name}": path.read_bytes() for path in sorted((HERE / "im2fit").glob("*.py"))}
    files["im2fit/py.typed"] = b""  # type checkers read the annotations
    files.update((f"im2fit/{name}", library) for name, library in libraries.items())
    files[f"{info}/licenses/LICENSE"] = (ROOT / "LICENSE").read_bytes()
    files[f"{info}/licenses/NOTICE"] = (ROOT / "NOTICE").read_bytes()
    files.update((f"{info}/licenses/{pathlib.Path(path).name}", pathlib.Path(licence).read_bytes())
                 for path, licence in zip(needed[::2], needed[1::2]))
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
    if len(sys.argv) < 3 or len(sys.argv) % 2 == 0:
        sys.exit(__doc__)
    main(*sys.argv[1:])
