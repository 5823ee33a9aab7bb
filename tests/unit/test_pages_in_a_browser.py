"""Pages of diagnoses as Chromium shows them: on a desk, on a phone, in the dark, on paper."""

import json
import os
import re
import shutil
import subprocess
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from test_diagnosis_page import page

OWN = Path(__file__).parents[2] / ".chromium" / "bin" / "chromium"  # of scripts/chromium
NAMES = (str(OWN), "chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome")
BROWSER = os.environ.get("CHROMIUM") or next(filter(None, map(shutil.which, NAMES)), None)
CASES = ("consistent", "explained", "ambiguous", "partial", "unexplained")
WIDTHS = {"desk": (1280, 900), "phone": (390, 844)}
SCHEMES = {"dark": 0, "light": 1}
READABLE = 4.5  # contrast of text, WCAG 2 level AA

pytestmark = pytest.mark.skipif(
    BROWSER is None, reason="no Chromium: scripts/chromium fetches it, CHROMIUM=PATH names one"
)

# Shows every page in a frame of every width, and writes what it measures into the document.
MEASURING = """<!DOCTYPE html><meta charset="utf-8"><pre id="found"></pre><script>
const pages = PAGES, widths = WIDTHS, found = {};
const light = c => c.map(v => v / 255).map(v => v <= .04045 ? v / 12.92 : ((v + .055) / 1.055) ** 2.4);
const luminance = c => { const [r, g, b] = light(c); return .2126 * r + .7152 * g + .0722 * b; };
const rgb = text => text.match(/[\\d.]+/g).map(Number);
function ground(view, node) {
  for (; node; node = node.parentElement) {
    const c = rgb(view.getComputedStyle(node).backgroundColor);
    if (c.length < 4 || c[3] > 0) return c;
  }
  return [255, 255, 255];
}
function contrast(view, node) {
  const [a, b] = [rgb(view.getComputedStyle(node).color), ground(view, node)].map(luminance);
  return (Math.max(a, b) + .05) / (Math.min(a, b) + .05);
}
function scrolls(view, node) {
  for (; node; node = node.parentElement) if (view.getComputedStyle(node).overflowX === "auto") return true;
  return false;
}
function measure(frame, width) {
  const view = frame.contentWindow, doc = frame.contentDocument, said = node => node.textContent.trim().slice(0, 40);
  const texts = [...doc.querySelectorAll("h1,h2,h3,p,li,dt,dd,td,th,figcaption,caption,summary,nav a")];
  const shown = texts.filter(node => said(node) && node.getClientRects().length);
  const outside = [...shown, ...doc.querySelectorAll("svg")].filter(node => {
    const box = node.getBoundingClientRect();
    return (box.right > width + 1 || box.left < -1) && !scrolls(view, node);
  }).map(node => node.tagName + " " + said(node));
  const header = [...doc.querySelectorAll("header > *")].map(node => node.getBoundingClientRect());
  return {
    wide: doc.documentElement.scrollWidth, outside,
    cut: [...doc.querySelectorAll(".size")].filter(node => node.scrollWidth > node.clientWidth + 1).map(said),
    overlaps: header.filter((box, k) => k && box.top < header[k - 1].bottom - 1).length,
    answered: doc.querySelector("header").getBoundingClientRect().bottom,
    pale: shown.filter(node => !node.closest("[style]") && contrast(view, node) < READABLE).map(said),
    dark: luminance(ground(view, doc.body)) < .1, sections: doc.querySelectorAll("section").length,
    fetched: view.performance.getEntriesByType("resource").map(entry => entry.name),
    scale: Math.min(...[...doc.querySelectorAll(".drawing svg")].map(
      node => node.getBoundingClientRect().width / node.viewBox.baseVal.width)),
    tall: Math.max(...[...doc.querySelectorAll("tr")].map(node => node.getBoundingClientRect().height)),
    drawn: [...doc.querySelectorAll("svg")].every(node => node.getBoundingClientRect().height > 5),
  };
}
async function all() {
  for (const [name, text] of Object.entries(pages)) for (const [where, [width, height]] of Object.entries(widths)) {
    const frame = document.createElement("iframe");
    frame.width = width; frame.height = height; frame.style.border = 0; frame.srcdoc = text;
    const ready = new Promise(done => frame.onload = done);
    document.body.append(frame);
    await ready;
    found[name + " " + where] = measure(frame, width);
    frame.remove();
  }
  document.getElementById("found").textContent = JSON.stringify(found);
}
all();
</script>"""


def browse(*words: str) -> subprocess.CompletedProcess[str]:
    assert BROWSER is not None
    options = ("--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--enable-logging=stderr")
    return subprocess.run([BROWSER, *options, *words], capture_output=True, text=True, timeout=120)


@cache
def seen(scheme: str, folder: Path) -> tuple[dict[str, Any], list[str]]:
    """What the measuring script found, by case and width, and what the console said."""
    pages = json.dumps({case: page(case) for case in CASES}).replace("</", r"<\/").replace("<!--", r"<\!--")
    text = MEASURING.replace("PAGES", pages).replace("WIDTHS", json.dumps(WIDTHS)).replace("READABLE", str(READABLE))
    (folder / "all.html").write_text(text)
    done = browse(
        f"--blink-settings=preferredColorScheme={SCHEMES[scheme]}",
        "--virtual-time-budget=20000",
        "--dump-dom",
        (folder / "all.html").as_uri(),
    )
    (found,) = re.findall(r'<pre id="found">(.*?)</pre>', done.stdout, re.S)
    return json.loads(found.replace("&lt;", "<").replace("&gt;", ">").replace("&amp;", "&")), [
        line for line in done.stderr.splitlines() if "CONSOLE" in line
    ]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("browser")


@pytest.mark.parametrize("scheme", SCHEMES)
def test_pages_fit_are_readable_and_fetch_nothing(scheme: str, folder: Path) -> None:
    found, console = seen(scheme, folder)
    assert console == [] and len(found) == len(CASES) * len(WIDTHS)
    for name, one in found.items():
        width, _ = WIDTHS[name.split()[-1]]
        assert one["wide"] <= width, f"{name} scrolls sideways"
        assert {key: one[key] for key in ("outside", "cut", "overlaps", "pale", "fetched")} == {
            "outside": [],
            "cut": [],
            "overlaps": 0,
            "pale": [],
            "fetched": [],
        }, name
        assert one["tall"] < 160, f"{name}: a row of a table is squeezed"
        assert one["scale"] > 0.75, f"{name}: letters of pictures are too small"
        assert one["dark"] == (scheme == "dark") and one["sections"] >= 6 and one["drawn"], name


def test_the_first_screen_of_a_desk_has_the_whole_answer(folder: Path) -> None:
    found, _ = seen("light", folder)
    for case in CASES:
        assert found[f"{case} desk"]["answered"] <= WIDTHS["desk"][1], case


def test_the_page_prints(folder: Path) -> None:
    (folder / "one.html").write_text(page("explained"))
    browse("--no-pdf-header-footer", f"--print-to-pdf={folder / 'one.pdf'}", (folder / "one.html").as_uri())
    pdf = (folder / "one.pdf").read_bytes()
    pages = len(re.findall(rb"/Type\s*/Page\b(?!s)", pdf))
    assert pdf.startswith(b"%PDF") and 2 <= pages <= 12
    assert re.search(rb"/MediaBox\s*\[0 0 59[45](?:\.\d+)? 84[12]", pdf)  # A4


def test_what_does_not_fit_is_found(folder: Path) -> None:
    text = '<body><header><p>a</p></header><p style="width: 900px">wide</p><p class="x">pale</p>'
    text += "<style>body { margin: 0; } .x { color: #ccc; }</style>"
    whole = MEASURING.replace("PAGES", json.dumps({"bad": text})).replace("WIDTHS", json.dumps(WIDTHS))
    (folder / "bad.html").write_text(whole.replace("READABLE", str(READABLE)))
    done = browse("--virtual-time-budget=5000", "--dump-dom", (folder / "bad.html").as_uri())
    (found,) = re.findall(r'<pre id="found">(.*?)</pre>', done.stdout, re.S)
    phone = json.loads(found)["bad phone"]
    assert phone["wide"] > 390 and phone["outside"] == ["P wide"] and phone["pale"] == ["pale"]
