# SPDX-License-Identifier: GPL-3.0-or-later
"""Prints a README with anchors for Doxygen, whose version in Debian 12 does not resolve GitHub's.

Each heading gets an anchor that consists of the README's folder and the heading's anchor on GitHub. Links to headings
are changed accordingly.
"""

import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
HEADING = re.compile(r"^(#+) +(.*)$")
LINK = re.compile(r"\]\(([^)\s:#]*)#([^)\s]+)\)")


def slug(title):
    """Returns a heading's anchor on GitHub."""
    return re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-")


def anchor(readme, name):
    folder = readme.parent.relative_to(ROOT)
    return "-".join([*folder.parts, name])


def converted(readme):
    is_code = False
    for line in readme.read_text().splitlines():
        is_code ^= line.lstrip().startswith("```")
        if not is_code:
            line = LINK.sub(
                lambda m: f"](#{anchor((readme.parent / m[1]).resolve() if m[1] else readme, m[2])})", line)
            heading = HEADING.match(line)
            if heading and len(heading[1]) > 1:
                line += f" {{#{anchor(readme, slug(heading[2]))}}}"
        yield line


print("\n".join(converted(pathlib.Path(sys.argv[1]).resolve())))
