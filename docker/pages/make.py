# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes the pages of the documentation: make.py DOXYGEN PROGRAMS VERSION OUT

Doxygen makes the reference and the pages of the READMEs. The gallery and the list of headers are inserted into two
pages of their own. Then the pages are completed: headings are put in order, and inline styles and scripts are removed,
because the content security policy of the server forbids them. Files to which no page refers are left out. The same
sources and programs give the same bytes.
"""

import collections
import html
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import xml.etree.ElementTree

import gallery
import readme_for_doxygen

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent

# Pages whose content is inserted after Doxygen has run.
INSERTED = {"gallery": "Gallery", "reference": "Reference"}

# Folders of headers, in the order of the reference: those that programs include, then the internals.
PUBLIC = ("core/include", "api/include")
INTERNAL = ("core", "api", "server")

# READMEs in the order in which one learns. Those of the folders inside a folder follow its own.
READMES = ("", "api", "core", "server", "docker", "tests", ".github")

TAG = re.compile(r"<[a-zA-Z/][^>]*>")
REFERENCE = re.compile(r'(?:href|src)="([^"]*)"')


def run_doxygen(program, version, folder):
    """Writes the pages into `folder / "html"`, and a list of their contents to `folder / "tags.xml"`."""
    for name, title in INSERTED.items():
        (folder / f"{name}.md").write_text(
            f"# {title} {{#{name}}}\n\n\\htmlonly[block]\n<div>@{name}@</div>\n\\endhtmlonly\n")
    settings = (HERE / "Doxyfile").read_text() + "\n".join([
        f"OUTPUT_DIRECTORY = {folder}", "HTML_OUTPUT = html", f"GENERATE_TAGFILE = {folder / 'tags.xml'}",
        f"PROJECT_NUMBER = {version}", f"STRIP_FROM_PATH = {ROOT} {folder}",
        *(f"INPUT += {folder / name}.md" for name in INSERTED)])
    done = subprocess.run([program, "-"], input=settings, cwd=ROOT, text=True, check=False)
    if done.returncode != 0:
        sys.exit("Doxygen reports the faults above")


def read_headers(tags):
    """Yields the path, the page and the symbols of each header in a list of contents. Symbols are names with pages."""
    root = xml.etree.ElementTree.parse(tags).getroot()
    classes = {compound.findtext("name"): compound.findtext("filename") for compound in root
               if compound.get("kind") in ("class", "struct")}
    for compound in root.iterfind("compound[@kind='file']"):
        path = pathlib.Path(compound.findtext("path")) / compound.findtext("name")
        if path.suffix != ".h":
            continue
        symbols = {re.sub("^ccdt::(?:(?:api|server|v2)::)?", "", found.text): classes[found.text]
                   for found in compound.iterfind("class")}
        for member in compound.iterfind("member"):
            name = member.findtext("name")
            symbols.setdefault(name, member.findtext("anchorfile") + "#" + member.findtext("anchor"))
        yield path.relative_to(ROOT), compound.findtext("filename"), symbols


def readme_pages(tags):
    """Yields the path of each README, the empty page that Doxygen makes for the file, and the page of its contents."""
    for compound in xml.etree.ElementTree.parse(tags).iterfind("compound[@kind='file']"):
        path = pathlib.Path(compound.findtext("path")) / compound.findtext("name")
        if path.suffix == ".md" and path.is_relative_to(ROOT):
            yield path.relative_to(ROOT), compound.findtext("filename"), readme_for_doxygen.page(path)


def learned(path):
    """Returns the key by which pages are sorted: first READMEs in their order, then others of their folders."""
    top = path.parts[0] if len(path.parts) > 1 else ""
    return READMES.index(top), path.name == "CHANGELOG.md", path.parent.parts, path.name != "README.md", path.name


def reference(tags):
    """Returns the content of the reference: the pages, and all headers by folder with the symbols that they declare."""
    folders = collections.defaultdict(list)
    for path, page, symbols in sorted(read_headers(tags)):
        names = ", ".join(f'<a href="{target}">{html.escape(name)}</a>' for name, target in sorted(symbols.items()))
        folders[path.parent.as_posix()].append(
            f'<dt><a href="{page}">{path.name}</a></dt><dd>{names}</dd>')
    is_public = {name: name.startswith(PUBLIC) for name in folders}
    titles = {page.findtext("filename"): page.findtext("title")
              for page in xml.etree.ElementTree.parse(tags).iterfind("compound[@kind='page']")}
    readmes = [f'<li><a href="{page}">{html.escape(titles[page], quote=False)}</a> <small>{path}</small></li>'
               for path, _, page in sorted(readme_pages(tags), key=lambda found: learned(found[0]))]
    parts = ["<h2>Pages</h2>", "<ul>", *readmes, "</ul>"]
    for title, public in (("Public headers", True), ("Internals", False)):
        chosen = [name for name in folders if is_public[name] == public]
        if chosen:
            parts.append(f"<h2>{title}</h2>")
        for name in sorted(chosen, key=lambda name: ((PUBLIC if public else INTERNAL).index(
                next(top for top in (PUBLIC if public else INTERNAL) if name.startswith(top))), name)):
            parts += [f"<h3>{name}</h3>", '<dl class="headers">', *folders[name], "</dl>"]
    return "\n".join(parts) + "\n"


def without_scripts(tag):
    """Returns a tag without inline styles, handlers, and attributes of layout that pages.css replaces."""
    removed = "style|onclick" if tag.startswith("<img") else "style|onclick|align|valign|width"
    return re.sub(rf' (?:{removed})="[^"]*"', "", tag)


def summary(text):
    """Removes links to parts that Doxygen has left out from the list of the parts of a page."""
    def is_part(link):
        return not link[1].startswith("#") or f'id="{link[1][1:]}"' in text

    def shortened(found):
        links = [link[0] for link in re.finditer(r'<a href="([^"]*)">.*?</a>', found[0])
                 if is_part(link) and "-members.html" not in link[1]]
        return f'<div class="summary">{" ".join(links)}</div>'

    return re.sub(r'<div class="summary">.*?</div>', shortened, text, count=1, flags=re.DOTALL)


def completed(text, inserted, readmes):
    """Returns the text of a page with headings in order, and without scripts and inline styles."""
    text = summary(text)
    # Rows between members, links of headings to themselves, pictures of buttons, second names of anchors, and anchors
    # of lines are not needed.
    text = re.sub(r'<tr class="separator:.*?</tr>\n|<span class="permalink">.*?</span>|'
                  r'<img src="(?:closed|open).png"[^>]*>|(?<=[0-9a-z]") name="[^"]*"(?=></a>)|<a id="l\d+"></a>|'
                  r'<span class="comment"></span>', "", text)
    text = re.sub(r'(<span class="lineno">)<a [^>]*>( *\d+)</a>', r"\1\2", text)
    text = TAG.sub(lambda tag: without_scripts(tag[0]), text)
    # Columns of long texts must not become narrow on a phone.
    text = re.sub(r'class="markdownTableBodyNone">((?:(?!</td>).){60})', r'class="markdownTableBodyNone long">\1', text)
    # Parts that scroll must be reachable by keyboard.
    text = re.sub(r'class="(?:fragment|markdownTable|memproto|memberdecls|params)"', r'\g<0> tabindex="0"', text)
    text = REFERENCE.sub(lambda link: link[0].replace(link[1], readmes.get(link[1], link[1])), text)
    if "<h1>" in text:  # the page of a README, whose title is above these headings
        text = re.sub(r"(</?h)([1-5])\b", lambda tag: tag[1] + str(int(tag[2]) + 1), text)
    text = re.sub(r'<h2 class="memtitle">(.*?)</h2>', r'<h3 class="memtitle">\1</h3>', text, flags=re.DOTALL)
    text = re.sub(r'<div class="title">(.*?)</div>', r"<h1>\1</h1>", text, flags=re.DOTALL)
    for name, content in inserted.items():
        text = text.replace(f"<div>@{name}@</div>", content)
    return text


def reachable(folder):
    """Returns the files that pages refer to, directly or indirectly, from the first page on."""
    found, left = set(), ["index.html"]
    while left:
        name = left.pop()
        path = folder / name
        if name in found or not path.is_file():
            continue
        found.add(name)
        if path.suffix == ".html":
            left += (link.partition("#")[0] for link in REFERENCE.findall(path.read_text()))
    return found


def main(doxygen, programs, version, out):
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name).resolve()
        run_doxygen(doxygen, version, folder)
        pages = folder / "html"
        (pages / "gallery").mkdir()
        (pages / "pictures").mkdir()
        for readme in (ROOT / path for path, _, _ in readme_pages(folder / "tags.xml")):
            for _, target in readme_for_doxygen.PICTURE.findall(readme.read_text()):
                shutil.copy(readme.parent / target, pages / "pictures")
        inserted = {"gallery": gallery.make(programs, pages / "gallery"), "reference": reference(folder / "tags.xml")}
        readmes = {empty: page for _, empty, page in readme_pages(folder / "tags.xml")}
        for page in pages.glob("*.html"):
            page.write_text(completed(page.read_text(), inserted, readmes))
        new = out.with_name(out.name + ".new")
        shutil.rmtree(new, ignore_errors=True)
        for path in sorted(reachable(pages)):
            (new / path).parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(pages / path, new / path)
        shutil.rmtree(out, ignore_errors=True)
        new.rename(out)


if __name__ == "__main__":
    main(sys.argv[1], pathlib.Path(sys.argv[2]).resolve(), sys.argv[3], pathlib.Path(sys.argv[4]).resolve())
