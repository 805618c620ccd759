"""The site of the documents, made as `cradle.py docs` makes it and read from the disk in a headless Chromium: its
search, the live page on its first screen, and what mkdocs does not check."""

import json
import re
import sys
from pathlib import Path

import newtons_cradle as nc
import pytest

from checkout import LIVE, ROOT, VENV, links
from checkout.site import build

pytestmark = pytest.mark.all

# What readers look for, and a page that has it.
LOOKED_FOR = {
    "dead band": "limits.html",
    "restitution": "loss-laws.html",
    "OMSimulator": "tools.html",
    "t_next": "variables.html",
}


@pytest.fixture(scope="module")
def site(fmu_path, tmp_path_factory) -> Path:
    """The site; a link that leads nowhere, or a page outside the navigation, ends the build."""
    if Path(sys.prefix).resolve() != VENV.resolve():
        pytest.skip("it needs the .venv that cradle.py makes")
    folder = tmp_path_factory.mktemp("site")
    build(folder, fmu_path)
    return folder


@pytest.fixture(scope="module")
def home(browser, site):
    """The browser with the first page, in a window that keeps what the theme stores."""
    browser.set_screen()
    address = (site / "index.html").as_uri()
    browser.get(address)
    browser.js("window.name = 'keeps'")
    browser.get_log("performance")
    browser.get_log("browser")
    browser.get(address)
    yield browser
    browser.js("window.name = ''")


def test_site_shows_the_live_page_on_its_first_screen(home):
    """Or a picture of it, where no engine for browsers has been compiled."""
    shown = home.find("iframe.stage" if LIVE.exists() else "article img")
    assert 0 < shown.location["y"] < 400 and shown.size["width"] > 600
    if LIVE.exists():
        assert shown.location["y"] + shown.size["height"] <= 800
        home.switch_to.frame(shown)
        home.wait("Boolean(window.cradle)", 60)
        home.switch_to.default_content()


@pytest.mark.parametrize("words", LOOKED_FOR)
def test_site_search_finds(home, site, words):
    """A page that has the words, in the index and on the screen."""
    entries = json.loads((site / "search/search_index.json").read_text(encoding="utf-8"))["docs"]
    pages = {entry["location"].partition("#")[0] for entry in entries if words in entry["text"]}
    assert LOOKED_FOR[words] in pages
    home.js("document.querySelector('.md-search__input').focus()")
    home.keys(words)
    results = ".md-search-result__item a"
    home.wait(f"document.querySelectorAll('{results}').length > 0", 60)
    found = [link.get_attribute("href") for link in home.find_all(results)]
    home.js("const field = document.querySelector('.md-search__input'); field.form.reset(); field.blur()")
    assert any(f"/{LOOKED_FOR[words]}" in link for link in found), found


def test_site_takes_nothing_from_the_network(home):
    home.assert_quiet()
    messages = [json.loads(entry["message"])["message"] for entry in home.get_log("performance")]
    requests = {m["params"]["request"]["url"] for m in messages if m["method"] == "Network.requestWillBeSent"}
    assert len(requests) > 5 and all(url.startswith(("file:", "data:", "blob:", "about:")) for url in requests)


def test_site_address_is_in_the_readme():
    assert f"<{links.site(links.repository(ROOT))}>" in (ROOT / "README.md").read_text(encoding="utf-8")


def test_site_references_are_complete(site, fmu):
    """Python's names, and the FMU's variables with a row for each family of them."""
    text = (site / "reference.html").read_text(encoding="utf-8")
    missing = [name for name in nc.__all__ if name != "look" and f'id="newtons_cradle.{name}"' not in text]
    text = (site / "variables.html").read_text(encoding="utf-8")
    families = {re.sub(r"\[\d+]", "[i]", name) for name in (*fmu.parameters, *fmu.inputs, *fmu.outputs)}
    assert missing == [] and len(families) > 40
    assert [name for name in sorted(families) if f"<code>{name}</code>" not in text] == []


def test_site_links_that_mkdocs_does_not_check_lead_somewhere(site):
    """From the lesson into the live page; in the rustdoc the theory, which is a document as well, needs no others."""
    theory = (site / "rust/newtons_cradle/theory/index.html").read_text(encoding="utf-8")
    assert "Glossary" in theory and re.findall(r'href="[^":]*\.md', theory) == []
    if LIVE.exists():
        lesson = (site / "lesson.html").read_text(encoding="utf-8")
        assert len(re.findall(r'href="cradle\.html#', lesson)) > 5
