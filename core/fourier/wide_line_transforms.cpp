#include "core/fourier/wide_line_transforms.h"

#if defined(__x86_64__) && !defined(__clang__)

// All of the standard library that pocketfft includes comes before the pragma: other files share what is compiled of
// it, and are for every processor.
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

// pocketfft asks the second one how much it may do at once; the pragma does not define it. The third one keeps what is
// compiled here apart from what is compiled for every processor.
#pragma GCC push_options
#pragma GCC target("avx2")
#define __AVX__ 1
#define pocketfft pocketfft_by_avx2
#include "core/fourier/pocketfft_lines.h"
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
