// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Marks functions that are inlined into code compiled for AVX2. All functions that take or return vectors of two pairs
// must be marked.
#define CCDT_INLINE __attribute__((always_inline))

namespace ccdt {

/// Two numbers in one vector register.
using Pair = double __attribute__((vector_size(16)));

inline Pair firsts(Pair a, Pair b) {
    return Pair{a[0], b[0]};
}
inline Pair seconds(Pair a, Pair b) {
    return Pair{a[1], b[1]};
}
inline Pair shifted(Pair a, Pair b) {
    return Pair{a[1], b[0]};
}
inline double sum(Pair a) {
    return a[0] + a[1];
}
inline Pair magnitude(Pair a) {
    return a < Pair{} ? -a : a;
}

/// Rounds v down to a whole number; |v| < 2^31.
inline double whole(double v) {
    const int truncated = static_cast<int>(v);
    return truncated > v ? truncated - 1 : truncated;
}

}  // namespace ccdt
