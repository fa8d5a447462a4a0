# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks that code compiled for AVX2 is only called on processors with AVX2.

The linker keeps one copy of an inline function for all files, such as those of the standard library. So no such
function may contain AVX instructions.

Usage: wide_code.py OBJECT...
"""

import re
import subprocess
import sys

FUNCTION = re.compile(r"^[0-9a-f]+ <(.*)>:$")
WIDE = re.compile(r"^\s+[0-9a-f]+:\s+v[a-z]")  # mnemonics of AVX and later extensions
SHARED = re.compile(r"^(?:[^(]* )?(?:std|__gnu_cxx)::")
KEPT_APART = re.compile(r"pocketfft_by_avx2")


def functions_with_wide_code(path):
    command = ["objdump", "-d", "-C", "--no-show-raw-insn", path]
    listing = subprocess.run(command, capture_output=True, text=True, check=True)
    name = None
    for line in listing.stdout.splitlines():
        if found := FUNCTION.match(line):
            name = found[1]
        elif name and WIDE.match(line):
            yield name
            name = None  # reports each function once


def main(paths):
    wide = [(path, name) for path in paths for name in functions_with_wide_code(path)]
    shared = [f"{path}: {name}" for path, name in wide if SHARED.match(name) and not KEPT_APART.search(name)]
    print("\n".join(shared) or f"{len(wide)} functions with AVX code, none of them shared")
    return 1 if shared or not wide else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
