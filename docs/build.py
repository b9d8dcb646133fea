"""Build the manual as a static web site: `make docs`, or `python docs/build.py FOLDER`.

The pages are those of `drysim manual`, in `src/drysim/manual`, the pictures those of the
gallery, the first page is the README. The site needs no network and no server: fonts are those
of the system, and its search works on pages opened from files, too.
"""

from __future__ import annotations

import logging
import re
import shutil
import sys
import tempfile
from pathlib import Path

from mkdocs.commands.build import build
from mkdocs.config import load_config

from drysim.manual import SECTIONS, pages

HOME = Path(__file__).parent
ROOT = HOME.parent
PICTURES = ROOT / "scenarios" / "pictures"
ADDITIONS = "style.css", "iframe-worker.js"
LINK = re.compile(r"(?<=\]\()(?!https?:|#)([^)#]+)")
CODE = re.compile(r"(?<!<pre>)<code>([^<]+)</code>")
WORD = re.compile(r"(?<!\S)\S{1,40}(?!\S)")
LONG_NAME = re.compile(r"(?<!\S)[\w./]{41,}(?!\S)")
CODE_OR_TEXT = re.compile(r"<(?:pre|code|h\d)\b.*?</(?:pre|code|h\d)>|<[^>]*>|[^<]+", re.S)
PERCENT = re.compile(r"(?<=\d) (?=%)")


def write_sources(folder: Path) -> None:
    """Write the pages into a folder, with links that hold in the site."""
    shutil.copytree(PICTURES, folder / "pictures", ignore=shutil.ignore_patterns("*.py", "__*"))
    (folder / "assets").mkdir()
    for name in ADDITIONS:
        shutil.copy(HOME / name, folder / "assets")
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    (folder / "index.md").write_text(LINK.sub(of_readme, readme), encoding="utf-8")
    for page in pages().values():
        file = folder / page.section / page.file.name
        file.parent.mkdir(exist_ok=True)
        file.write_text(LINK.sub(of_page, page.text), encoding="utf-8")


def of_readme(link: re.Match[str]) -> str:
    """Return a link of the README as the site has it."""
    target = link[0].replace("scenarios/pictures/", "pictures/")
    return target.replace("src/drysim/manual/", "").replace("LICENSE", "LICENSE.txt")


def of_page(link: re.Match[str]) -> str:
    """Return a link of a page as the site has it."""
    return link[0].replace("../../../../scenarios/pictures/", "../pictures/")


def on_page_content(html: str, **_: object) -> str:
    """Mark the words in code, which no line breaks; mkdocs calls this with each page.

    In text, though not in code to be copied, a percent sign stays with its number.
    """
    html = CODE_OR_TEXT.sub(
        lambda part: (
            part[0] if part[0][0] == "<" else PERCENT.sub("\N{NO-BREAK SPACE}", part[0])
        ),
        html,
    )
    return CODE.sub(mark_words, html)


def mark_words(code: re.Match[str]) -> str:
    """Return inline code with its words marked; in tables a bar had to be escaped.

    A long name, as of a test, may break behind an underscore, a long path behind a slash.
    """
    text = WORD.sub(r"<span>\g<0></span>", code[1].replace("\\|", "|"))
    text = LONG_NAME.sub(lambda name: re.sub("[_/]", r"\g<0><wbr>", name[0]), text)
    return f"<code>{text}</code>"


def build_site(out: Path) -> None:
    """Build the site; a broken link is an error."""
    with tempfile.TemporaryDirectory() as place:
        sources = Path(place, "docs")
        sources.mkdir()
        write_sources(sources)
        shutil.copy(ROOT / "LICENSE", sources / "LICENSE.txt")
        config = Path(place, "mkdocs.yml")
        config.write_text("site_name: drysim\n", encoding="utf-8")
        build(
            load_config(
                str(config),
                docs_dir=str(sources),
                site_dir=str(out),
                use_directory_urls=False,
                strict=True,
                theme={"name": "material", "font": False, "features": ["navigation.sections"]},
                plugins=["search", "offline"],
                hooks=[__file__],
                extra={"generator": False, "polyfills": ["assets/iframe-worker.js"]},
                extra_css=["assets/style.css"],
                markdown_extensions=["tables", "fenced_code", "toc"],
                validation={"links": {"anchors": "warn"}},
                nav=[
                    {"drysim": "index.md"},
                    *(
                        {
                            shelf: [
                                {pages()[name].title.replace("`", ""): f"{shelf}/{name}.md"}
                                for name in names
                            ]
                        }
                        for shelf, names in SECTIONS.items()
                    ),
                ],
            )
        )


if __name__ == "__main__":
    logging.basicConfig(level=logging.WARNING, format="%(message)s")
    site = Path(sys.argv[1]).resolve()
    build_site(site)
    print(f"open {site / 'index.html'} in a browser")
