// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/base/line_transforms.h"

#include <complex>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/random.h"

namespace ccdt {
namespace {

using Complex = std::complex<double>;

std::vector<double> noise(std::size_t size) {
    Random random(2, 0);
    std::vector<double> values(size);
    for (double& value : values) value = random.uniform() - 0.5;
    return values;
}

std::vector<Complex> complex_noise(std::size_t size) {
    const auto parts = noise(2 * size);
    std::vector<Complex> values;
    for (std::size_t i = 0; i < size; ++i) values.push_back({parts[2 * i], parts[2 * i + 1]});
    return values;
}

/// Returns the results of all transforms of some numbers, concatenated.
std::vector<double> transformed(const LineTransforms& transforms, const LineSet& lines) {
    std::vector<double> found;
    const auto keep = [&](const std::vector<double>& values) {
        found.insert(found.end(), values.begin(), values.end());
    };
    const auto keep_complex = [&](const std::vector<Complex>& values) {
        for (const Complex value : values) keep({value.real(), value.imag()});
    };
    std::vector<double> values = noise(lines.size * lines.count);
    transforms.cosine(lines, values.data());
    keep(values);
    transforms.cosine_back(lines, values.data());
    keep(values);
    const std::size_t kept = lines.size / 2 + 1;
    std::vector<Complex> coefficients(kept * lines.count);
    transforms.real(lines, values.data(), kept, coefficients.data());
    keep_complex(coefficients);
    transforms.real_back(lines, values.data(), kept, coefficients.data());
    keep(values);
    std::vector<Complex> both = complex_noise(lines.size * lines.count);
    transforms.complex(lines, both.data());
    keep_complex(both);
    transforms.complex_back(lines, both.data());
    keep_complex(both);
    return found;
}

TEST(LineTransforms, AreIdenticalOnAnyProcessor) {
    for (const std::size_t size : {1, 2, 3, 7, 16, 60, 243, 1000, 1024}) {
        for (const std::size_t count : {1, 2, 3, 4, 5, 16}) {
            for (const LineSet& lines : {LineSet{size, 1, count, size}, LineSet{size, count, count, 1}}) {
                EXPECT_EQ(transformed(line_transforms(), lines), transformed(common_line_transforms(), lines))
                    << count << " lines of " << size;
            }
        }
    }
}

TEST(LineTransforms, AreIndependentOfOtherLines) {
    constexpr std::size_t kSize = 90, kCount = 7;
    const auto values = noise(kSize * kCount);
    auto together = values;
    line_transforms().cosine({kSize, 1, kCount, kSize}, together.data());
    for (std::size_t line = 0; line < kCount; ++line) {
        auto alone = values;
        line_transforms().cosine({kSize, 1, 1, kSize}, &alone[line * kSize]);
        for (std::size_t i = line * kSize; i < (line + 1) * kSize; ++i) EXPECT_EQ(together[i], alone[i]);
    }
}

}  // namespace
}  // namespace ccdt
