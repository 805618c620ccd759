"""The page: the cradle in a browser, live or as it was recorded, as one HTML file that needs no network."""

import base64
import hashlib
import json
import re
import zlib
from graphlib import TopologicalSorter
from pathlib import Path
from typing import Any

import numpy as np

from .errors import CradleError
from .files import ENGINE, PAGE, in_folder, presets
from .pulses import FIELDS
from .recording import LENGTH, RADIUS, Columns, Recording

# What the page's scripts import and export.
IMPORT = re.compile(r'^import ({[^}]*}) from "(.*)";$', re.MULTILINE)
EXPORT = re.compile(r"^export (?:async )?(?:class|const|function) (\w+)", re.MULTILINE)


class PageError(CradleError, RuntimeError):
    """The page cannot be made; the message says what is missing."""


def save_page(
    path: str | Path, recording: Recording | None = None, head: str = '<link rel="icon" href="data:,">'
) -> int:
    """Writes the page, which plays the `recording` and, where the engine for browsers is there, runs live. `head`: what
    else its head has. Returns its size in bytes. Raises PageError, OSError."""
    if recording is None and not ENGINE.is_file():
        raise PageError(
            "the engine for browsers is missing: the wheels of a release have it; in the folder of the sources, "
            "`rustup target add wasm32-unknown-unknown` and `python3 cradle.py page` make it, for `cradle.py wheel` too"
        )
    parts = {
        "head": head,
        "style": (PAGE / "style.css").read_text(encoding="utf-8"),
        "script": bundled(),
        "texts": json.dumps({path.stem: json.loads(path.read_bytes()) for path in PAGE.glob("texts/*.json")}),
        "presets": json.dumps(presets()),
        "sizes": json.dumps({"pendulum.length": LENGTH, "ball.radius": RADIUS}),
        "engine": ENGINE.read_text(encoding="utf-8") if ENGINE.is_file() else "",
        # So that no `</script>` in it ends the element.
        "recording": json.dumps(recording and told(recording)).replace("<", "\\u003c"),
    }
    return in_folder(path).write_bytes(filled(PAGE / "template.html", parts).encode("utf-8"))


def filled(template: Path, parts: dict[str, str]) -> str:
    """A template whose slots, such as `{{style}}`, are filled in one pass: nothing in a part is taken for a slot. Its
    policy knows the scripts and styles that the template has, by their digests, so that browsers take no others."""
    text = template.read_text(encoding="utf-8")
    own = {}
    for slot, name in {"scripts": "script", "styles": "style"}.items():
        found = re.findall(rf'<{name}(?: type="module")?>(.*?)</{name}>', text, re.DOTALL)
        digests = (hashlib.sha256(_in_slots(part, parts).encode()).digest() for part in found)
        own[slot] = " ".join(f"'sha256-{base64.b64encode(digest).decode()}'" for digest in digests)
    return _in_slots(text, parts | own)


def _in_slots(text: str, parts: dict[str, str]) -> str:
    return re.sub(r"{{(\w+)}}", lambda slot: parts[slot[1]], text)


def save_site(folder: str | Path) -> int:
    """Writes the page as index.html into a folder for a web server; returns its size in bytes. Raises as `save_page`.

    Browsers can install what is served from there, and keep it for when there is no network.
    """
    source, folder = PAGE / "site", Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    for name in ("cradle.webmanifest", "icon.svg", "worker.js"):
        in_folder(folder / name).write_bytes((source / name).read_bytes())
    return save_page(folder / "index.html", head=(source / "head.html").read_text(encoding="utf-8"))


def told(recording: Recording) -> dict[str, Any]:
    """The recording in the form of web/page/engine/recording.js."""
    samples = dict(recording.energy)
    for name in "xvF":
        samples |= {f"{name}[{i}]": column for i, column in enumerate(getattr(recording, name).T, start=1)}
    known = {name: getattr(recording, name) for name in ("title", "parameters", "length", "radius", "start")}
    pulses = {name: recording.pulses[name] for name in FIELDS}
    exact = {"time": packed({"time": recording.time}, "f8"), "pulses": packed(pulses, "f8")}
    return {**known, **exact, "samples": packed(samples, "f4")}


def packed(columns: Columns, kind: str) -> dict[str, Any]:
    """Columns as bytes: the first byte of all numbers, then the second, ..., which deflates better."""
    values = np.array(list(columns.values()), dtype=f"<{kind}").reshape(-1, 1)
    data = base64.b64encode(zlib.compress(values.view(np.uint8).T.tobytes(), 9)).decode("ascii")
    return {"names": list(columns), "kind": kind, "data": data}


def bundled() -> str:
    """All scripts as one: `modules` has what each exports to others by its import name, once those it imports have run.
    As files of their own, browsers would not load them from a disk, nor could a digest say which may run."""
    paths = (path for room in ("engine", "view", "control") for path in sorted((PAGE / room).glob("*.js")))
    texts = {f"#{path.relative_to(PAGE).as_posix()}": path.read_text(encoding="utf-8") for path in paths}
    imports = {name: IMPORT.findall(text) for name, text in texts.items()}
    exports = {name: set(EXPORT.findall(text)) for name, text in texts.items()}
    for names, source in (each for found in imports.values() for each in found):
        exports[source] |= set(re.findall(r"\w+", names))  # if it has none of that name, the page says so as it loads
    order = TopologicalSorter({name: [source for _, source in found] for name, found in imports.items()})
    script = '"use strict";\nconst modules = {};\n'
    for name in order.static_order():
        body = re.sub(r"(?m)^export ", "", IMPORT.sub(r'const \1 = modules["\2"];', texts[name]))
        script += f'modules["{name}"] = (() => {{\n{body}return {{ {", ".join(sorted(exports[name]))} }};\n}})();\n'
    return script
