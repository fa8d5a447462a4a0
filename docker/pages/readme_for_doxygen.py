# SPDX-License-Identifier: GPL-3.0-or-later
"""Prints a README with anchors and links for Doxygen, whose version in Debian 12 does not resolve GitHub's.

Each heading gets an anchor that consists of the path of the page and the heading's anchor on GitHub, which numbers
repeated headings. Links to READMEs and their headings become links to their pages. A link to a file that is not part of
the documentation becomes the text of the link, because the pages do not contain that file. A picture is shown from the
folder `pictures`, where make.py puts it.
"""

import collections
import pathlib
import re
import sys

import pictures

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
PICTURE = re.compile(r"!\[([^\]]*)\]\(([^)\s]+)\)")
LINK = re.compile(r"\[([^\[\]]*)\]\(([^)\s]+)\)")


def slug(title):
    """Returns a heading's anchor on GitHub."""
    return re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-")


def anchor(readme, name):
    path = readme.parent if readme.name == "README.md" else readme.with_suffix("")
    return "-".join([*path.relative_to(ROOT).parts, name])


def page(readme):
    """Returns the page that Doxygen makes of a README."""
    name = readme.relative_to(ROOT).with_suffix("").as_posix()
    return "index.html" if name == "README" else f"md_{re.sub('[/.]', '_', name)}.html"


def link(readme, text, target):
    """Returns a link to a page, or the text if the target is not part of the documentation."""
    name, _, heading = target.partition("#")
    if ":" in name:
        return f"[{text}]({target})"
    path = (readme.parent / name).resolve() if name else readme
    if path.suffix != ".md":
        return text
    place = "#" + anchor(path, heading) if heading else ""
    return f'<a href="{page(path)}{place}">{text}</a>'


def converted(readme):
    """Yields the parts of a README: texts, which are converted, and blocks of code, which are not."""
    seen = collections.Counter()

    def heading(found):
        name = slug(found[2])
        seen[name] += 1
        place = name if seen[name] == 1 else f"{name}-{seen[name] - 1}"
        return f"{found[1]} {{#{anchor(readme, place)}}}"

    parts = re.split(r"(^ *```.*?^ *```$)", readme.read_text(), flags=re.MULTILINE | re.DOTALL)
    for number, part in enumerate(parts):
        if number % 2 == 0:
            part = PICTURE.sub(lambda m: pictures.element((readme.parent / m[2]).resolve(), m[1], "pictures"), part)
            part = LINK.sub(lambda m: link(readme, m[1], m[2]), part)
            part = re.sub(r"^(##+ +(.*))$", heading, part, flags=re.MULTILINE)
        yield part


if __name__ == "__main__":
    print("".join(converted(pathlib.Path(sys.argv[1]).resolve())), end="")
