# SPDX-License-Identifier: Apache-2.0
"""The answer of a session: a Person and its values."""

from __future__ import annotations

import dataclasses
import html
import importlib
import math
from typing import TYPE_CHECKING, Any, Callable, Literal, Mapping

from . import _c
from ._enums import GuidanceCode, TapeStatus

if TYPE_CHECKING:
    import matplotlib.axes
    import pandas

AvatarKind = Literal["glb", "obj", "bvh"]


@dataclasses.dataclass(frozen=True)
class Estimate:
    """A value with its 95 % interval; NaN where the interval is not known."""

    value: float
    low: float
    high: float
    unit: str


@dataclasses.dataclass(frozen=True)
class TapeValue:
    """A measurement of the tape (docs/tape.md). `value` and its 95 % interval are NaN unless `status` is MEASURED; `reason`
    then says why. `iso` is the clause of ISO 8559-1:2017, or ""."""

    status: TapeStatus
    value: float
    low: float
    high: float
    unit: str
    iso: str
    reason: str


class Person:
    """The result of a session, measured or not. `result` is result.json as a dictionary (docs/result.md), `json` its text."""

    def __init__(self, result: dict[str, Any], json: str, tape: dict[str, TapeValue], sizes: dict[str, float],
                 make_avatar: Callable[[AvatarKind], bytes]) -> None:
        self.result, self.json = result, json
        self._tape, self._sizes = tape, sizes
        self._make_avatar: Callable[[AvatarKind], bytes] | None = make_avatar
        self._avatars: dict[AvatarKind, bytes] = {}

    @property
    def measured(self) -> bool:
        return bool(self.result["state"] == "MEASURED")

    @property
    def guidance(self) -> tuple[GuidanceCode, ...]:
        """What the person or the scene must change. Codes of a newer library, which this package does not know, are left out;
        `result` has them."""
        return tuple(GuidanceCode[name] for name in self.result["guidance"] if name in GuidanceCode.__members__)

    @property
    def measurements(self) -> dict[str, Estimate]:
        """The eleven main measurements by id, "chest_girth"."""
        unknown = (math.nan, math.nan)
        return {key: Estimate(entry["value"], low, high, entry["unit"])
                for key, entry in self.result.get("measurements", {}).items()
                for low, high in [entry.get("interval") or unknown]}

    def tape(self) -> dict[str, TapeValue]:
        """All measurements of the tape by id, "thigh_girth", taken on the mesh of the fitted body. {} without a measurement or
        a body file."""
        return dict(self._tape)

    @property
    def size(self) -> str | None:
        """The most probable size."""
        best: str | None = (self.result.get("size") or {}).get("best")
        return best

    @property
    def sizes(self) -> dict[str, float]:
        """The sizes of the chart, small to large, with their probabilities. {} without a measurement."""
        return dict(self._sizes)

    @property
    def female(self) -> float | None:
        """Probability, 0 to 1."""
        female: float | None = (self.result.get("sex") or {}).get("female")
        return female

    @property
    def doubted(self) -> tuple[str, ...]:
        """The facts of Session.set_known() that do not fit what was seen: "stature" or "weight"."""
        return tuple((self.result.get("known") or {}).get("doubted", ()))

    def avatar(self, kind: AvatarKind = "glb") -> bytes:
        """The bytes of a .glb, .obj or .bvh. The first call makes them: while the session is open, and before it goes on to
        another person or other facts. `measure(..., avatars=("glb",))` makes them at once, because it closes its session.
        Raises ValueError without a measurement or too late, and Error without a body file."""
        check_avatar_kind(kind)
        if kind not in self._avatars:
            if not self.measured:
                raise ValueError(f"no avatar: {self!r}")
            if self._make_avatar is None:
                raise too_late(kind)
            self._avatars[kind] = self._make_avatar(kind)
        return self._avatars[kind]

    def to_frame(self, tape: bool = False) -> pandas.DataFrame:
        """A pandas.DataFrame with a row for each of `measurements`, or of tape(): value, low, high and unit, and for the tape
        status, iso and reason. Needs pandas."""
        data_frame = _optional("pandas", "to_frame").DataFrame
        values: Mapping[str, object] = self.measurements
        if tape:
            values = self.tape()
        columns = [field.name for field in dataclasses.fields(TapeValue if tape else Estimate)]
        rows = [[getattr(value, name) for name in columns] for value in values.values()]
        return data_frame(rows, list(values), columns).rename_axis("measurement")

    def plot(self, axes: matplotlib.axes.Axes | None = None) -> matplotlib.axes.Axes:
        """Draws the measurements in mm with their 95 % intervals into `axes`, None: new ones. Returns them. Needs
        matplotlib."""
        if axes is None:
            axes = _optional("matplotlib.pyplot", "plot").subplots(layout="constrained")[1]
        shown = {key: e for key, e in self.measurements.items() if e.unit == "mm"}
        # NaN, an interval that is not known, draws no bar.
        errors = [[e.value - e.low for e in shown.values()], [e.high - e.value for e in shown.values()]]
        axes.errorbar([e.value for e in shown.values()], range(len(shown)), xerr=errors if shown else None, fmt="o", capsize=3)
        axes.set_yticks(range(len(shown)), [key.replace("_", " ") for key in shown])
        axes.invert_yaxis()  # the first measurement on top, as in a table
        axes.set_xlabel("mm, with 95 % interval")
        axes.set_title(repr(self)[1:-1])
        return axes

    def __getstate__(self) -> dict[str, Any]:
        # A copy in another process has the avatars that were made, and no session to make others.
        return {**vars(self), "_make_avatar": None}

    def __repr__(self) -> str:
        if not self.measured:
            return f"<im2fit.Person not measured: {', '.join(self.result['guidance']) or self.result['state']}>"
        m = self.measurements
        return (f"<im2fit.Person {m['stature'].value:.0f} mm, {m['weight'].value:.1f} kg, "
                f"chest {m['chest_girth'].value:.0f} mm, size {self.size}>")

    def _repr_html_(self) -> str:
        rows = "".join(
            f"<tr><td>{html.escape(key)}</td><td>{e.value:.1f} {e.unit}</td><td>{e.low:.1f} – {e.high:.1f}</td></tr>"
            for key, e in self.measurements.items() if not math.isnan(e.low))
        return (f"<p>{html.escape(repr(self))}</p><table><tr><th>measurement</th><th>value</th><th>95 %</th></tr>"
                f"{rows}</table>")


def check_avatar_kind(kind: str) -> None:
    if kind not in _c.AVATAR_FORMATS:
        raise ValueError(f"no avatar of kind {kind!r}: expected one of {', '.join(_c.AVATAR_FORMATS)}")


def too_late(kind: AvatarKind) -> ValueError:
    return ValueError(f"the session has ended or gone on, so the avatar {kind!r} cannot be made: call avatar({kind!r}) "
                      f"before, or measure(..., avatars=({kind!r},))")


def _optional(module: str, method: str) -> Any:
    """A package that only `method` needs."""
    try:
        return importlib.import_module(module)
    except ImportError as error:
        package = module.partition(".")[0]
        raise ImportError(f"Person.{method} needs {package}: install python3-{package} ({error})") from None
