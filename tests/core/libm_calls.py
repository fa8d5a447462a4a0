# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks that no result depends on the elementary functions of the C library, which differ between machines.
core/base/elementary.h replaces them.

Usage: libm_calls.py OBJECT...
"""

import re
import subprocess
import sys

INEXACT = re.compile(r"(c?(a?(cos|sin|tan)h?|exp(2|10|m1)?|log(10|1p|2)?|pow)|atan2|sincos|cbrt|hypot|cabs|carg|erfc?|"
                     r"[lt]gamma)[fl]?")
EXACT = re.compile(r"(sqrt|l?l?round|floor|fmod|remainder|ldexp|frexp)f?")


def main(paths):
    listing = subprocess.run(["nm", "-u", "-P", "-A", *paths], capture_output=True, text=True, check=True).stdout
    calls = [line.split()[:2] for line in listing.splitlines()]
    inexact = [f"{path} {name}()" for path, name in calls if INEXACT.fullmatch(name)]
    exact = {name for _, name in calls if EXACT.fullmatch(name)}
    print("\n".join(inexact) or f"{len(paths)} files call none; exact functions that they call: {sorted(exact)}")
    return 1 if inexact or not exact else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
