# SPDX-License-Identifier: Apache-2.0
"""Growth as a picture: millions of instructions a frame over each axis, three panels of one SVG."""
from pathlib import Path

PANEL, HEIGHT, MARGIN = 300, 220, 46
AXES = {"pixels": ("pixels, millions", lambda v: int(v.split("x")[0]) * int(v.split("x")[1]) / 1e6),
        "people": ("people in view, 640x480, 4.5 m", float),
        "distance": ("distance, m", lambda v: int(v) / 1000)}


def points(rows):
    """{axis: [(x, value as named, millions of instructions)]} of rows of bench/count."""
    by_axis = {}
    for row in rows:
        _, axis, value = row["kernel"].split("/")
        by_axis.setdefault(axis, []).append((AXES[axis][1](value), value, row["instructions"] / 1e6))
    return {axis: sorted(by_axis[axis]) for axis in AXES if axis in by_axis}


def ceiling(value):
    """A round number above."""
    step = 10 ** (len(str(int(value))) - 1)
    return next(step * k for k in (1, 2, 3, 4, 5, 6, 8, 10) if step * k >= value)


def panel(axis, line, left):
    x_max = ceiling(max(x for x, _, _ in line) * 10) / 10
    y_max = ceiling(max(y for _, _, y in line))
    width, height = PANEL - MARGIN - 14, HEIGHT - MARGIN - 24

    def place(x, y):
        return left + MARGIN + width * x / x_max, 24 + height * (1 - y / y_max)
    out = []
    for part in range(5):
        y = y_max * part / 4
        px, py = place(0, y)
        out.append(f'<line x1="{px:.1f}" y1="{py:.1f}" x2="{px + width:.1f}" y2="{py:.1f}" stroke="#ddd"/>')
        out.append(f'<text x="{px - 6:.1f}" y="{py + 4:.1f}" text-anchor="end">{y:g}</text>')
        tx, ty = place(x_max * part / 4, 0)
        out.append(f'<text x="{tx:.1f}" y="{ty + 16:.1f}" text-anchor="middle">{x_max * part / 4:g}</text>')
    path = " ".join("{:.1f},{:.1f}".format(*place(x, y)) for x, _, y in line)
    out.append(f'<polyline points="{path}" fill="none" stroke="#1f6fb4" stroke-width="2"/>')
    out += ['<circle cx="{:.1f}" cy="{:.1f}" r="3" fill="#1f6fb4"/>'.format(*place(x, y)) for x, _, y in line]
    out.append(f'<text x="{left + MARGIN + width / 2:.1f}" y="{HEIGHT - 8}" text-anchor="middle">{AXES[axis][0]}</text>')
    return out


def write(rows, path):
    lines = points(rows)
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{PANEL * len(lines)}" height="{HEIGHT}" '
           'font-family="sans-serif" font-size="11">', '<!-- SPDX-License-Identifier: Apache-2.0; written by bench/report -->',
           '<rect width="100%" height="100%" fill="#fff"/>',
           f'<text x="{MARGIN - 30}" y="14">a guided frame, millions of instructions, aarch64</text>']
    for index, (axis, line) in enumerate(lines.items()):
        out += panel(axis, line, PANEL * index)
    Path(path).write_text("\n".join([*out, "</svg>", ""]))
