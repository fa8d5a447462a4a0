# SPDX-License-Identifier: GPL-3.0-or-later
"""Elements that show picture files on a page."""

import html
import xml.etree.ElementTree

from PIL import Image


def size_of(path):
    """Returns width and height of a picture in CSS pixels, as whole numbers."""
    if path.suffix != ".svg":
        with Image.open(path) as image:
            return image.size
    root = xml.etree.ElementTree.parse(path).getroot()
    if "viewBox" in root.attrib and not root.get("width", "mm").isdecimal():
        _, _, width, height = map(float, root.get("viewBox").split())
        return 1000, round(1000 * height / width)
    return int(root.get("width")), int(root.get("height"))


def element(path, alt, folder, scale=1.0):
    """Returns an element that shows a picture of a folder, and is loaded when it becomes visible.

    `scale` is the number of CSS pixels per pixel of the picture.
    """
    width, height = (round(scale * size) for size in size_of(path))
    return (f'<img src="{folder}/{html.escape(path.name)}" alt="{html.escape(alt)}" width="{width}" height="{height}" '
            f'loading="lazy">')
