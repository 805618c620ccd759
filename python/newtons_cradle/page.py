"""The page: the cradle in a browser, live or as it was recorded, as one HTML file that needs no network."""

import base64
import hashlib
import json
import re
import zlib
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from .errors import CradleError
from .files import ENGINE, PAGE, in_folder, presets
from .pulses import FIELDS
from .recording import Columns, Recording

# Content security policy: what a page may do, whatever a file or an address brings into it. `data:` is for the modules
# in its import map.
POLICY = (
    "default-src 'none'; script-src 'wasm-unsafe-eval' data: {scripts}; style-src 'unsafe-inline'; "
    "img-src 'self' data:; manifest-src 'self'; worker-src 'self'; base-uri 'none'; form-action 'none'"
)


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
        "modules": json.dumps({"imports": dict(modules())}),
        "texts": json.dumps({path.stem: json.loads(path.read_bytes()) for path in PAGE.glob("texts/*.json")}),
        "presets": json.dumps(presets()),
        "engine": ENGINE.read_text(encoding="utf-8") if ENGINE.is_file() else "",
        # So that no `</script>` in it ends the element.
        "recording": json.dumps(recording and told(recording)).replace("<", "\\u003c"),
    }
    return in_folder(path).write_bytes(filled(PAGE / "template.html", parts).encode("utf-8"))


def filled(template: Path, parts: dict[str, str]) -> str:
    """A template whose slots, such as `{{style}}`, are filled in one pass: nothing in a part is taken for a slot. The
    page runs no other scripts than its own, and asks for nothing but what lies beside it."""
    page = re.sub(r"{{(\w+)}}", lambda slot: parts[slot[1]], template.read_text(encoding="utf-8"))
    scripts = re.findall(r'<script(?: type="(?:module|importmap)")?>(.*?)</script>', page, re.DOTALL)
    digests = (base64.b64encode(hashlib.sha256(script.encode()).digest()).decode() for script in scripts)
    own = " ".join(f"'sha256-{digest}'" for digest in digests)
    policy = POLICY.format(scripts=own)
    return page.replace("<title>", f'<meta http-equiv="Content-Security-Policy" content="{policy}">\n<title>', 1)


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


def modules() -> Iterable[tuple[str, str]]:
    """The scripts by their import names, as addresses of an import map."""
    for room in ("engine", "view", "control"):
        for path in sorted((PAGE / room).glob("*.js")):
            script = base64.b64encode(path.read_bytes()).decode()
            yield f"#{room}/{path.name}", f"data:text/javascript;base64,{script}"
