"""The HTML file of an animation: template, style, scripts, three.js and the run's numbers, compressed."""

import base64
import hashlib
import json
import re
import zipfile
import zlib
from html import escape
from importlib.resources import files
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from .. import look
from ..pulses import Array, impact_sequences
from .recording import Recording

ASSETS = files(__package__) / "assets"
#: three.js r140 as trimesh 5.2.0 carries it: what is made of another text would go into pages that nobody has looked
#: at.
THREE_JS_SHA256 = "1baf8525cd80caceabd6eb50da7961aa47f191ac7a68adb454c3a761b29244e2"
SCRIPTS = ("run.js", "eye.js", "scene.js", "strips.js", "player.js", "controls.js")


class PageError(RuntimeError):
    """The page cannot be made; the message says what to install."""


def save_page(path: str | Path, recording: Recording) -> int:
    """Writes the page; returns its size in bytes. Raises PageError, OSError."""
    parts = {
        "{{title}}": escape(recording.title),
        "{{style}}": look.STYLE + asset("animation.css"),
        # Its licence asks for its text in every copy.
        "{{three}}": f"/*\n{asset('three-license.txt')}*/\n{three_js()}",
        "{{script}}": "\n".join([look.SCRIPT, *map(asset, SCRIPTS)]),
        "{{data}}": json.dumps(numbers(recording)).replace("<", "\\u003c"),
    }
    # One pass, so that nothing in three.js or the data is taken for a mark.
    page = re.sub(r"{{\w+}}", lambda mark: parts[mark[0]], asset("template.html"))
    return Path(path).write_bytes(page.encode("utf-8"))


def asset(name: str) -> str:
    return (ASSETS / name).read_text(encoding="utf-8")


def three_js() -> str:
    """three.js (r140, MIT licence) as one classic script: that of the wheel, else from the viewer in trimesh."""
    packaged = files(__package__) / "three.js"
    if packaged.is_file():
        return packaged.read_text(encoding="utf-8")
    # The package is not imported: that would take half a second and compile all of it, for one file.
    package = find_spec("trimesh")
    archive = package and package.origin and Path(package.origin).parent / "resources/templates/viewer.zip"
    if not archive or not archive.is_file():
        raise PageError("three.js is taken from the package trimesh: `pip install trimesh==5.2.0`")
    with zipfile.ZipFile(archive) as viewer:
        page = viewer.read("viewer.html.template").decode("utf-8")
    # Its only script begins with three.js, whose last statement marks it as a module; loaders follow.
    ends = r"/\*\*\s*\* @license\s*\* Copyright [-\d]+ Three\.js", r'"__esModule",{value:!0}\)}\)\);'
    script = re.search(".*?".join(ends), page, re.DOTALL)
    if not script or hashlib.sha256(script[0].encode()).hexdigest() != THREE_JS_SHA256:
        cure = "`pip install trimesh==5.2.0`"
        raise PageError(f"this version of trimesh carries no or another three.js: {cure}")
    return script[0]


def numbers(recording: Recording) -> dict[str, Any]:
    """The run as the scripts read it."""
    pulses = np.sort(recording.pulses, order=["contact", "onset"])
    # Rigid impacts have no force: their impulse shows how hard they are.
    strength = "peak" if np.any(pulses["peak"] > 0) else "impulse"
    impacts = [[s["onset"].min(), s["release"].max()] for s in impact_sequences(recording.pulses)]
    return {
        **{name: getattr(recording, name) for name in ("title", "parameters", "length", "radius")},
        "balls": recording.x.shape[1],
        "time": packed(recording.time, "f8"),
        **{name: packed(getattr(recording, name).T, "f4") for name in "xvF"},
        "energy": {name: packed(values, "f4") for name, values in recording.energy.items()},
        "pulses": {
            "contact": packed(pulses["contact"], "f4"),
            **{name: packed(pulses[name], "f8") for name in ("onset", "release")},
            "peak": packed(pulses[strength], "f4"),
        },
        "strength": ["contact forces", "N"] if strength == "peak" else ["impulses", "N.s"],
        "impacts": packed(np.array(impacts), "f8"),
    }


def packed(array: Array, kind: str) -> dict[str, str]:
    """An array as bytes, the first ones of all numbers, then the second ones, ...: so they deflate better."""
    values = np.ascontiguousarray(array, dtype=f"<{kind}").ravel()
    planes = values.view(np.uint8).reshape(len(values), values.itemsize).T
    data = base64.b64encode(zlib.compress(planes.tobytes(), 9)).decode("ascii")
    return {"kind": kind, "data": data}
