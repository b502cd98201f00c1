"""Checks every link of a built site that stays within it: `python docs/_ext/check_links.py out/docs`."""

from __future__ import annotations

import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit


class Page(HTMLParser):
    """Anchors and links of one page."""

    def __init__(self) -> None:
        super().__init__()
        self.anchors: set[str] = set()
        self.links: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Note what can be pointed at, and what points."""
        for name, value in attrs:
            if value and (name == "id" or (tag == "a" and name == "name")):
                self.anchors.add(value)
            elif value and name in ("href", "src"):
                self.links.append(value)


def read_site(folder: Path) -> dict[Path, Page]:
    """All pages below a folder."""
    pages = {}
    for path in sorted(folder.rglob("*.html")):
        page = Page()
        page.feed(path.read_text(encoding="utf-8"))
        pages[path.resolve()] = page
    return pages


def find_broken(folder: Path) -> list[str]:
    """Links to files or anchors that are not there, each with its page."""
    pages = read_site(folder)
    broken = []
    for path, page in pages.items():
        for link in page.links:
            parts = urlsplit(link)
            if parts.scheme or parts.netloc:
                continue
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            target = target / "index.html" if target.is_dir() else target
            is_there = target.exists()
            if is_there and parts.fragment and target in pages:
                is_there = unquote(parts.fragment) in pages[target].anchors
            if not is_there:
                broken.append(f"{path.relative_to(folder.resolve())}: {link}")
    return broken


def main(arguments: list[str]) -> int:
    """Print what is broken; 1 where anything is, 2 where there is no site."""
    folder = Path(arguments[0]) if arguments else Path("out/docs")
    if not (folder / "index.html").exists():
        print(f"check_links: no site in {folder}; run make docs first", file=sys.stderr)
        return 2
    broken = find_broken(folder)
    print(*broken, sep="\n", end="\n" if broken else "")
    return 1 if broken else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
