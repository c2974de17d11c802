# SPDX-License-Identifier: Apache-2.0
"""Growth as a picture: what a frame, a query and a long run cost, panel by panel of one SVG."""
import math
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


def panel(line, left, label, shown=None):
    """`line`: [(x, y)]. Without `shown` the x axis is linear from 0; else it has these ticks, [(x, text)]."""
    x_max = shown[-1][0] if shown else ceiling(max(x for x, _ in line) * 10) / 10
    x_min = shown[0][0] if shown else 0
    y_max = ceiling(max(y for _, y in line))
    width, height = PANEL - MARGIN - 14, HEIGHT - MARGIN - 24

    def place(x, y):
        return left + MARGIN + width * (x - x_min) / (x_max - x_min), 24 + height * (1 - y / y_max)
    out = []
    for part in range(5):
        y = y_max * part / 4
        px, py = place(x_min, y)
        out.append(f'<line x1="{px:.1f}" y1="{py:.1f}" x2="{px + width:.1f}" y2="{py:.1f}" stroke="#ddd"/>')
        out.append(f'<text x="{px - 6:.1f}" y="{py + 4:.1f}" text-anchor="end">{y:g}</text>')
    for x, text in shown or [(x_max * part / 4, f"{x_max * part / 4:g}") for part in range(5)]:
        tx, ty = place(x, 0)
        out.append(f'<text x="{tx:.1f}" y="{ty + 16:.1f}" text-anchor="middle">{text}</text>')
    path = " ".join("{:.1f},{:.1f}".format(*place(x, y)) for x, y in line)
    out.append(f'<polyline points="{path}" fill="none" stroke="#1f6fb4" stroke-width="2"/>')
    out += ['<circle cx="{:.1f}" cy="{:.1f}" r="3" fill="#1f6fb4"/>'.format(*place(x, y)) for x, y in line]
    out.append(f'<text x="{left + MARGIN + width / 2:.1f}" y="{HEIGHT - 8}" text-anchor="middle">{label}</text>')
    return out


def picture(panels, title, path):
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{PANEL * len(panels)}" height="{HEIGHT}" '
           'font-family="sans-serif" font-size="11">', '<!-- SPDX-License-Identifier: Apache-2.0; written by bench/report -->',
           '<rect width="100%" height="100%" fill="#fff"/>', f'<text x="{MARGIN - 30}" y="14">{title}</text>']
    for index, (line, label, shown) in enumerate(panels):
        out += panel(line, PANEL * index, label, shown)
    Path(path).write_text("\n".join([*out, "</svg>", ""]))


def write(rows, path):
    """What a guided frame costs."""
    picture([([(x, y) for x, _, y in line], AXES[axis][0], None) for axis, line in points(rows).items()],
            "a guided frame, millions of instructions, aarch64", path)


def query(references):
    """[(models, p50 us, p99 us)] of the index in bench/results/index-references.json."""
    return sorted((row["models"], row["p50_us"], row["p99_us"]) for row in references["rows"]
                  if row["peer"] == "im2fit" and row["p50_us"])


def write_long(references, memory, path):
    """What a query costs by the size of the index, and what memory a long run takes. `memory`: [[frame, kB]]."""
    models = query(references)
    panels = [([(math.log10(n), us) for n, us, _ in models], "models in the index: a query, us, half are faster",
               [(math.log10(n), f"{n:,}") for n, _, _ in models])]
    if memory:
        panels.append(([(frame / 1e3, kb / 1024) for frame, kb in memory], "thousands of frames: resident memory, MB", None))
    picture(panels, "growth with the index, and with time", path)
