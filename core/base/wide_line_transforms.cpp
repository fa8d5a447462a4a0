// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/base/wide_line_transforms.h"

#if defined(__x86_64__) && !defined(__clang__)

// All standard headers that pocketfft includes are included before the pragma. Their inline functions are shared with
// other files, which must run on every processor.
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>
#include <vector>

// pocketfft derives its vector width from __AVX__, which the pragma does not define. The last macro renames
// pocketfft's namespace, to keep this code apart from the code compiled for every processor.
#pragma GCC push_options
#pragma GCC target("avx2")
#define __AVX__ 1
#define pocketfft pocketfft_by_avx2
#include "core/base/pocketfft_lines.h"
#pragma GCC pop_options

namespace ccdt {

const LineTransforms* wide_line_transforms() {
    return &kLineTransforms;
}

}  // namespace ccdt

#else

namespace ccdt {

const LineTransforms* wide_line_transforms() {
    return nullptr;
}

}  // namespace ccdt

#endif
