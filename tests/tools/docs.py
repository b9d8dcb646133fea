"""Build the manual as a static web site: `make docs`, or `python tests/tools/docs.py FOLDER`.

The pages are those of `drysim manual`, the pictures those of the gallery, the first page is the
README. The site needs no network: fonts are those of the system, the search is its own.
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

ROOT = Path(__file__).parents[2]
PICTURES = ROOT / "scenarios" / "pictures"
LINK = re.compile(r"(?<=\]\()(?!https?:|#)([^)#]+)")


def write_sources(folder: Path) -> None:
    """Write the pages into a folder, with links that hold in the site."""
    shutil.copytree(PICTURES, folder / "pictures", ignore=shutil.ignore_patterns("*.py", "__*"))
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    (folder / "index.md").write_text(LINK.sub(of_readme, readme), encoding="utf-8")
    for page in pages().values():
        file = folder / page.section / page.file.name
        file.parent.mkdir(exist_ok=True)
        file.write_text(LINK.sub(of_page, page.text), encoding="utf-8")


def of_readme(link: re.Match[str]) -> str:
    """Return a link of the README as the site has it."""
    target = link[0].replace("scenarios/pictures/", "pictures/")
    return target.replace("src/drysim/manual/", "").replace("src/drysim/LICENSE", "LICENSE.txt")


def of_page(link: re.Match[str]) -> str:
    """Return a link of a page as the site has it."""
    return link[0].replace("../../../../scenarios/pictures/", "../pictures/")


def build_site(out: Path) -> None:
    """Build the site; a broken link is an error."""
    with tempfile.TemporaryDirectory() as place:
        sources = Path(place, "docs")
        sources.mkdir()
        write_sources(sources)
        shutil.copy(ROOT / "src" / "drysim" / "LICENSE", sources / "LICENSE.txt")
        config = Path(place, "mkdocs.yml")
        config.write_text("site_name: drysim\n", encoding="utf-8")
        known = pages()
        build(
            load_config(
                str(config),
                docs_dir=str(sources),
                site_dir=str(out),
                use_directory_urls=False,
                strict=True,
                theme={"name": "material", "font": False, "features": ["navigation.sections"]},
                plugins=["search"],
                extra={"generator": False},
                markdown_extensions=["tables", "fenced_code", "toc"],
                validation={"links": {"anchors": "warn"}},
                nav=[
                    {"drysim": "index.md"},
                    *(
                        {shelf: [{known[name].title: f"{shelf}/{name}.md"} for name in names]}
                        for shelf, names in SECTIONS.items()
                    ),
                ],
            )
        )


if __name__ == "__main__":
    logging.basicConfig(level=logging.WARNING, format="%(message)s")
    build_site(Path(sys.argv[1]).resolve())
