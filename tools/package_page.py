"""Writes PACKAGE.md, README.md as a package index shows it, or checks that it is fresh (--check).

There relative links and pictures lead nowhere, and this project has no address that they could begin with:
pictures are left out, links become their text, and what is for readers of the repository is cut.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import Final

ROOT: Final = Path(__file__).parents[1]
README: Final = ROOT / "README.md"
PAGE: Final = ROOT / "PACKAGE.md"
CUT: Final = "## Documentation"
"""From here on the README speaks of its own folder."""
END: Final = "Documentation, examples and tests are in the source distribution (`docs/`). Apache-2.0.\n"

PICTURE: Final = re.compile(r"^!\[[^\]]*\]\([^)]*\)\n\n", re.M)
COMMENT: Final = re.compile(r"^<!--.*-->\n", re.M)
LINK: Final = re.compile(r"\[([^\]]+)\]\((?!https?:)[^)]*\)")


def package_page(readme: str) -> str:
    """The README without what needs its folder."""
    text = COMMENT.sub("", PICTURE.sub("", readme.partition(CUT)[0]))
    return LINK.sub(r"\1", text) + END


def main(check: bool) -> int:
    """Writes or checks the page; 1 if it is stale."""
    page = package_page(README.read_text(encoding="utf-8"))
    if not check:
        PAGE.write_text(page, encoding="utf-8")
    elif page != PAGE.read_text(encoding="utf-8"):
        print(f"error: {PAGE.name} is stale; run: make tables", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main("--check" in sys.argv[1:]))
