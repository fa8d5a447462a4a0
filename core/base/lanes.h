// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "core/base/pair.h"

// Vector code for SSE2, and for AVX2 if the processor supports it. Both give the same bits.
//
// Why not the library Highway: version 1.0.3, which Debian 12 has, needs at least SSSE3, and compiles each file that
// uses it once for every instruction set.

namespace ccdt {

/// Whether the processor has instructions for two lanes (AVX2).
inline bool has_two_lanes() {
#ifdef __x86_64__
    static const bool has = __builtin_cpu_supports("avx2") != 0;
    return has;
#else
    return false;
#endif
}

/// The counterpart of TwoLanes with one lane. Its operations process one pair (`Pairs`, see pair.h) or one number
/// (`Numbers`), where TwoLanes processes one pair or one number for each lane. The operations have the same names, so
/// that a template can use either type.
struct OneLane {
    static constexpr std::size_t kCount = 1;
    using Pairs = Pair;
    using Numbers = double;

    static Pairs join(const std::array<Pair, kCount>& lanes) { return lanes[0]; }
    static Pair pair(Pairs a, std::size_t) { return a; }
    static Pairs firsts(Pairs a, Pairs b) { return ccdt::firsts(a, b); }
    static Pairs seconds(Pairs a, Pairs b) { return ccdt::seconds(a, b); }
    static Pairs shifted(Pairs a, Pairs b) { return ccdt::shifted(a, b); }
    static Pairs twice(Numbers a) { return Pairs{a, a}; }
    static Pairs whole(Pairs a) { return Pair{ccdt::whole(a[0]), ccdt::whole(a[1])}; }
    static Numbers first(Pairs a) { return a[0]; }
    static Numbers sum(Pairs a) { return ccdt::sum(a); }
    static Numbers each(const std::array<double, kCount>& lanes) { return lanes[0]; }
    static double at(Numbers a, std::size_t) { return a; }
    /// Whether any component of a comparison is true.
    static bool any(decltype(Pairs{} < Pairs{}) found) { return (found[0] | found[1]) != 0; }
};

/// Arithmetic on two lanes at once, each with one pair (`Pairs`) or one number (`Numbers`). The result of each lane is
/// bit for bit the result of OneLane, since products are always rounded before they are added (no fused multiply-add).
struct TwoLanes {
    static constexpr std::size_t kCount = 2;
    using Pairs = double __attribute__((vector_size(2 * sizeof(Pair))));
    using Numbers = Pair;

    CCDT_INLINE static Pairs join(const std::array<Pair, kCount>& lanes) {
        return __builtin_shufflevector(lanes[0], lanes[1], 0, 1, 2, 3);
    }
    CCDT_INLINE static Pair pair(Pairs a, std::size_t lane) { return Pair{a[2 * lane], a[2 * lane + 1]}; }
    CCDT_INLINE static Pairs firsts(Pairs a, Pairs b) { return __builtin_shufflevector(a, b, 0, 4, 2, 6); }
    CCDT_INLINE static Pairs seconds(Pairs a, Pairs b) { return __builtin_shufflevector(a, b, 1, 5, 3, 7); }
    CCDT_INLINE static Pairs shifted(Pairs a, Pairs b) { return __builtin_shufflevector(a, b, 1, 4, 3, 6); }
    CCDT_INLINE static Pairs twice(Numbers a) { return __builtin_shufflevector(a, a, 0, 0, 1, 1); }
    CCDT_INLINE static Pairs whole(Pairs a) {
        using Integers = int __attribute__((vector_size(4 * sizeof(int))));
        const Pairs truncated = __builtin_convertvector(__builtin_convertvector(a, Integers), Pairs);
        return truncated > a ? truncated - 1.0 : truncated;
    }
    CCDT_INLINE static Numbers first(Pairs a) { return Numbers{a[0], a[2]}; }
    CCDT_INLINE static Numbers sum(Pairs a) { return Numbers{a[0], a[2]} + Numbers{a[1], a[3]}; }
    static Numbers each(const std::array<double, kCount>& lanes) { return Numbers{lanes[0], lanes[1]}; }
    static double at(Numbers a, std::size_t lane) { return a[lane]; }
    CCDT_INLINE static bool any(decltype(Pairs{} < Pairs{}) found) {
        const auto either = __builtin_shufflevector(found, found, 0, 1) | __builtin_shufflevector(found, found, 2, 3);
        return (either[0] | either[1]) != 0;
    }
};

/// Returns function(TwoLanes()), compiled for AVX2. Must be called only if has_two_lanes() is true.
/// @param function  marked CCDT_INLINE
template <class Function>
#ifdef __x86_64__
__attribute__((target("avx2")))
#endif
auto by_two_lanes(Function&& function) {
    return function(TwoLanes{});
}

/// Returns function(TwoLanes()), compiled for AVX2, if the processor supports it; otherwise function(OneLane()).
/// @param function  marked CCDT_INLINE
/// @param wide      whether TwoLanes may be used
template <class Function>
CCDT_INLINE inline auto with_lanes(Function&& function, bool wide = has_two_lanes()) {
    return wide ? by_two_lanes(function) : function(OneLane{});
}

/// Eight 32-bit numbers, which the compiler keeps in one or several vector registers.
struct EightLanes {
    static constexpr std::uint32_t kCount = 8;
    using Floats = float __attribute__((vector_size(kCount * sizeof(float))));
    using Ints = std::int32_t __attribute__((vector_size(kCount * sizeof(std::int32_t))));
    using Counts = std::uint32_t __attribute__((vector_size(kCount * sizeof(std::uint32_t))));

    /// Loads eight successive numbers from memory, which need not be aligned.
    template <class Numbers, class Number>
    CCDT_INLINE static void load(const Number& first, Numbers& numbers) {
        std::memcpy(&numbers, &first, sizeof numbers);
    }
    template <class Numbers, class Number>
    CCDT_INLINE static void store(const Numbers& numbers, Number& first) {
        std::memcpy(&first, &numbers, sizeof numbers);
    }
    /// Returns first, first + 1, ..., first + 7.
    CCDT_INLINE static Ints from(std::uint32_t first) {
        return Ints{0, 1, 2, 3, 4, 5, 6, 7} + static_cast<std::int32_t>(first);
    }
};

}  // namespace ccdt
