// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/image/colour_profile.h"

#include <lcms2.h>
#include <lcms2_plugin.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "core/base/elementary.h"

namespace ccdt::api {
namespace {

using Space = ColourConversion::Space;

using Context = std::shared_ptr<std::remove_pointer_t<cmsContext>>;
using Curve = std::unique_ptr<cmsToneCurve, decltype(&cmsFreeToneCurve)>;

/// A profile or a transform of Little CMS. Must be destroyed before the context of the library.
using Handle = std::shared_ptr<void>;

Context make_context() {
    return {cmsCreateContext(nullptr, nullptr), cmsDeleteContext};
}

Handle own_profile(const Context& context, cmsHPROFILE profile) {
    if (profile == nullptr) return nullptr;
    return {profile, [context](cmsHPROFILE owned) { cmsCloseProfile(owned); }};
}

Handle own_transform(const Context& context, cmsHTRANSFORM transform) {
    if (transform == nullptr) return nullptr;
    return {transform, [context](cmsHTRANSFORM owned) { cmsDeleteTransform(owned); }};
}

/// Creates an RGB profile with the same curve for red, green and blue.
Handle make_rgb(const Context& context, const cmsCIExyY& white, const cmsCIExyYTRIPLE& primaries, const Curve& curve) {
    if (!curve) return nullptr;
    const std::array<cmsToneCurve*, 3> curves = {curve.get(), curve.get(), curve.get()};
    return own_profile(context, cmsCreateRGBProfileTHR(context.get(), &white, &primaries, curves.data()));
}

constexpr cmsCIExyY kD65{0.3127, 0.3290, 1};
constexpr cmsCIExyYTRIPLE kSrgb{{0.64, 0.33, 1}, {0.30, 0.60, 1}, {0.15, 0.06, 1}};
constexpr cmsCIExyYTRIPLE kDisplayP3{{0.680, 0.320, 1}, {0.265, 0.690, 1}, {0.150, 0.060, 1}};
constexpr cmsCIExyYTRIPLE kBt2020{{0.708, 0.292, 1}, {0.170, 0.797, 1}, {0.131, 0.046, 1}};

/// Creates the curve of sRGB: a power function with a linear part near 0.
Curve make_srgb_curve(const Context& context) {
    constexpr int kPowerWithFoot = 4;
    constexpr std::array<double, 5> kValues = {2.4, 1 / 1.055, 0.055 / 1.055, 1 / 12.92, 0.04045};
    return {cmsBuildParametricToneCurve(context.get(), kPowerWithFoot, kValues.data()), cmsFreeToneCurve};
}

Curve make_power(const Context& context, double gamma) {
    return {cmsBuildGamma(context.get(), gamma), cmsFreeToneCurve};
}

float srgb_light(float share) {
    return share <= 0.04045F ? share / 12.92F : elementary::pow((share + 0.055F) / 1.055F, 2.4F);
}

/// Clamps light to [0, 1], since a broken profile may give any value.
float clamp_light(float light) {
    return light > 0 ? std::min(light, 1.0F) : 0;  // NaN: 0
}

/// Tolerance for recognising profiles of sRGB, whose numbers are rounded and whose curves may be sampled.
constexpr float kRounding = 0.002F;

bool is_srgb(const ToneCurve& curve) {
    constexpr int kSteps = 255;
    for (int i = 0; i <= kSteps; ++i) {
        const float share = static_cast<float>(i) / kSteps;
        if (std::abs(curve(share) - srgb_light(share)) > kRounding) return false;
    }
    return true;
}

bool is_identity(const LightMatrix& matrix) {
    constexpr float kColourRounding = 0.005F;
    for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t j = 0; j < 3; ++j) {
            if (std::abs(matrix[i][j] - (i == j ? 1.0F : 0.0F)) > kColourRounding) return false;
        }
    }
    return true;
}

/// Returns the primaries of a profile in the connection space, as the columns of a matrix: red, green and blue.
std::optional<cmsMAT3> primaries_of(cmsHPROFILE profile) {
    cmsMAT3 matrix;
    constexpr std::array kTags = {cmsSigRedColorantTag, cmsSigGreenColorantTag, cmsSigBlueColorantTag};
    for (std::size_t i = 0; i < kTags.size(); ++i) {
        const auto* colour = static_cast<const cmsCIEXYZ*>(cmsReadTag(profile, kTags[i]));
        if (colour == nullptr) return std::nullopt;
        matrix.v[0].n[i] = colour->X;
        matrix.v[1].n[i] = colour->Y;
        matrix.v[2].n[i] = colour->Z;
    }
    return matrix;
}

std::optional<LightMatrix> light_matrix(const Context& context, cmsHPROFILE profile) {
    const Handle srgb = make_rgb(context, kD65, kSrgb, make_srgb_curve(context));
    const auto to = srgb ? primaries_of(srgb.get()) : std::nullopt;
    const auto from = primaries_of(profile);
    cmsMAT3 inverse, product;
    if (!to || !from || !_cmsMAT3inverse(&*to, &inverse)) return std::nullopt;
    _cmsMAT3per(&product, &inverse, &*from);
    LightMatrix matrix{};
    for (std::size_t i = 0; i < 3; ++i) {
        const auto& row = product.v[i].n;
        const double sum = row[0] + row[1] + row[2];
        if (!(sum > 0.5 && sum < 2)) return std::nullopt;  // the profile's white is not white
        for (std::size_t j = 0; j < 3; ++j) matrix[i][j] = static_cast<float>(row[j] / sum);
        matrix[i][i] = 1 - matrix[i][(i + 1) % 3] - matrix[i][(i + 2) % 3];
    }
    return matrix;
}

ToneCurve read_curve(const Handle& profile, cmsTagSignature tag) {
    const auto* curve = static_cast<const cmsToneCurve*>(cmsReadTag(profile.get(), tag));
    if (curve == nullptr) return {};
    return [profile, curve](float share) { return clamp_light(cmsEvalToneCurveFloat(curve, share)); };
}

/// Removes the matrix if it is the identity. Returns none if, in addition, the curves are those of sRGB.
std::optional<ColourConversion> simplify(ColourConversion conversion) {
    if (conversion.matrix && is_identity(*conversion.matrix)) conversion.matrix.reset();
    if (!conversion.matrix && std::ranges::all_of(conversion.curves, is_srgb)) return std::nullopt;
    return conversion;
}

/// Reads a profile with curves and a matrix.
std::optional<ColourConversion> read_matrix_profile(const Context& context, const Handle& profile) {
    ColourConversion conversion;
    for (const auto tag : {cmsSigRedTRCTag, cmsSigGreenTRCTag, cmsSigBlueTRCTag}) {
        conversion.curves.push_back(read_curve(profile, tag));
        if (!conversion.curves.back()) return std::nullopt;
    }
    conversion.matrix = light_matrix(context, profile.get());
    if (!conversion.matrix) return std::nullopt;
    if (!is_srgb(conversion.curves[1])) conversion.grey = conversion.curves[1];
    return simplify(std::move(conversion));
}

/// Reads a grey profile. Only its curve is used, whether it is parametric or sampled.
std::optional<ColourConversion> read_grey_profile(const Context& context, const Handle& profile) {
    const Handle light = own_profile(context, cmsCreateXYZProfileTHR(context.get()));
    if (!light) return std::nullopt;
    const Handle transform = own_transform(
        context, cmsCreateTransformTHR(context.get(), profile.get(), TYPE_GRAY_FLT, light.get(), TYPE_XYZ_FLT,
                                       INTENT_RELATIVE_COLORIMETRIC, cmsFLAGS_NOOPTIMIZE | cmsFLAGS_NOCACHE));
    if (!transform) return std::nullopt;
    const ToneCurve curve = [transform](float share) {
        std::array<float, 3> xyz{};
        cmsDoTransform(transform.get(), &share, xyz.data(), 1);
        return clamp_light(xyz[1]);
    };
    return simplify({Space::Grey, {}, {curve}, {}, {}});
}

/// Reads a profile with tables. The tables convert to BT.2020, which contains almost all printed and displayed colours,
/// and a matrix then converts to sRGB. So colours outside sRGB are not clipped by the tables.
std::optional<ColourConversion> read_table_profile(const Context& context, const Handle& profile, Space space) {
    const Handle wide = make_rgb(context, kD65, kBt2020, make_srgb_curve(context));
    const auto matrix = wide ? light_matrix(context, wide.get()) : std::nullopt;
    if (!matrix) return std::nullopt;
    const bool is_lab = space == Space::Lab;
    const cmsUInt32Number type = space == Space::Inks ? TYPE_CMYK_16 : is_lab ? TYPE_Lab_16 : TYPE_RGB_16;
    // A table between Lab and RGB, which the library would make, has errors of more than 1 in L*.
    const cmsUInt32Number flags = cmsFLAGS_BLACKPOINTCOMPENSATION | (is_lab ? cmsFLAGS_NOOPTIMIZE : 0);
    const Handle transform =
        own_transform(context, cmsCreateTransformTHR(context.get(), profile.get(), type, wide.get(), TYPE_RGB_16,
                                                     INTENT_RELATIVE_COLORIMETRIC, flags));
    if (!transform) return std::nullopt;
    const auto convert = [transform](const std::uint16_t* from, std::uint16_t* to, std::size_t pixels) {
        cmsDoTransform(transform.get(), from, to, static_cast<cmsUInt32Number>(pixels));
    };
    return ColourConversion{space, convert, {srgb_light, srgb_light, srgb_light}, matrix, {}};
}

std::optional<ColourConversion> read_profile(const Context& context, const Handle& profile) {
    constexpr std::array kClasses = {cmsSigInputClass, cmsSigDisplayClass, cmsSigOutputClass, cmsSigColorSpaceClass};
    if (std::ranges::find(kClasses, cmsGetDeviceClass(profile.get())) == kClasses.end()) return std::nullopt;
    switch (cmsGetColorSpace(profile.get())) {
        case cmsSigGrayData:
            return read_grey_profile(context, profile);
        case cmsSigRgbData:
            if (cmsIsTag(profile.get(), cmsSigAToB0Tag) != 0 || cmsIsTag(profile.get(), cmsSigAToB1Tag) != 0)
                return read_table_profile(context, profile, Space::Rgb);
            return read_matrix_profile(context, profile);
        case cmsSigCmykData:
            return read_table_profile(context, profile, Space::Inks);
        default:
            return std::nullopt;
    }
}

constexpr std::uint8_t kPq = 16, kHlg = 18;  ///< code numbers of ITU-T H.273

/// Creates the curve of a transfer function; null: not supported.
Curve make_transfer_curve(const Context& context, std::uint8_t code) {
    constexpr int kPowerWithFoot = 4;
    // The inverses of SMPTE 240M and of digital cinema (SMPTE 428). The white of the latter, 48 cd/m2, is below its
    // largest value.
    constexpr std::array<double, 5> k240 = {1 / 0.45, 1 / 1.1115, 0.1115 / 1.1115, 0.25, 0.0913};
    const std::array<double, 5> cinema = {2.6, elementary::pow(52.37 / 48, 1 / 2.6), 0, 0, 0};
    switch (code) {
        case 4:
            return make_power(context, 2.2);
        case 5:
            return make_power(context, 2.8);
        case 7:
            return {cmsBuildParametricToneCurve(context.get(), kPowerWithFoot, k240.data()), cmsFreeToneCurve};
        case 8:
            return make_power(context, 1);
        case 17:
            return {cmsBuildParametricToneCurve(context.get(), kPowerWithFoot, cinema.data()), cmsFreeToneCurve};
        case 1:  // BT.709, BT.601, BT.2020 and xvYCC describe cameras; their values are taken as those of sRGB
        case 6:
        case 11:
        case 12:
        case 13:
        case 14:
        case 15:
        case kPq:
        case kHlg:
            return make_srgb_curve(context);
        default:
            return {nullptr, cmsFreeToneCurve};
    }
}

/// Creates the profile that code points describe; for high dynamic range, a profile with the primaries alone. Returns
/// null for unsupported code points.
Handle make_profile(const Context& context, const ColourTags::CodePoints& code) {
    constexpr cmsCIExyY kC{0.310, 0.316, 1}, kCinema{0.314, 0.351, 1};
    const auto make = [&](const cmsCIExyY& white, const cmsCIExyYTRIPLE& primaries) {
        return make_rgb(context, white, primaries, make_transfer_curve(context, code.transfer));
    };
    switch (code.primaries) {
        case 1:
        case 2:  // unspecified
            return make(kD65, kSrgb);
        case 4:  // BT.470, system M
            return make(kC, {{0.67, 0.33, 1}, {0.21, 0.71, 1}, {0.14, 0.08, 1}});
        case 5:  // BT.601 with 625 lines
            return make(kD65, {{0.64, 0.33, 1}, {0.29, 0.60, 1}, {0.15, 0.06, 1}});
        case 6:  // BT.601 with 525 lines, SMPTE 240M
        case 7:
            return make(kD65, {{0.630, 0.340, 1}, {0.310, 0.595, 1}, {0.155, 0.070, 1}});
        case 8:  // film
            return make(kC, {{0.681, 0.319, 1}, {0.243, 0.692, 1}, {0.145, 0.049, 1}});
        case 9:
            return make(kD65, kBt2020);
        case 11:  // digital cinema
            return make(kCinema, kDisplayP3);
        case 12:
            return make(kD65, kDisplayP3);
        case 22:  // EBU 3213
            return make(kD65, {{0.630, 0.340, 1}, {0.295, 0.605, 1}, {0.155, 0.077, 1}});
        default:
            return nullptr;
    }
}

/// Light of high dynamic range, relative to a diffuse white of 203 cd/m2.
class WideRange {
public:
    enum class Curve { Pq = kPq, Hlg = kHlg };

    explicit WideRange(Curve curve) : curve_(curve), light_(std::size_t{kFull} + 1) {
        for (std::size_t i = 0; i < light_.size(); ++i)
            light_[i] = light_of(static_cast<float>(i) / static_cast<float>(kFull));
    }

    /// Returns the compressed light of a grey sample.
    float operator()(float share) const {
        const float light = light_of(share);
        return std::min(light * factor(light, light), 1.0F);
    }

    /// Converts red, green and blue to square roots of compressed light.
    void operator()(const std::uint16_t* from, std::uint16_t* to, std::size_t pixels) const {
        for (std::size_t i = 0; i < pixels; ++i, from += 3, to += 3) {
            const float red = light_[from[0]], green = light_[from[1]], blue = light_[from[2]];
            const float times = factor(std::max({red, green, blue}), 0.2627F * red + 0.6780F * green + 0.0593F * blue);
            const std::array<float, 3> light = {red * times, green * times, blue * times};
            std::ranges::transform(light, to, [](float value) {
                return static_cast<std::uint16_t>(std::lround(std::sqrt(std::min(value, 1.0F)) * kFull));
            });
        }
    }

private:
    static constexpr std::uint16_t kFull = 0xFFFF;
    static constexpr float kWhite = 203, kPeak = 1000 / kWhite;

    /// Returns the light of a PQ sample, or the scene light of a HLG sample.
    float light_of(float share) const {
        if (curve_ == Curve::Pq) {
            const float root = elementary::pow(share, 1 / 78.84375F);
            return elementary::pow(std::max(root - 0.8359375F, 0.0F) / (18.8515625F - 18.6875F * root),
                                   1 / 0.1593017578125F) *
                   10'000 / kWhite;
        }
        return share <= 0.5F ? share * share / 3
                             : (elementary::exp((share - 0.55991073F) / 0.17883277F) + 0.28466892F) / 12;
    }

    /// Returns the factor on a colour.
    /// @param most       largest of red, green and blue
    /// @param luminance  of the scene, for HLG
    float factor(float most, float luminance) const {
        constexpr float kGamma = 1.2F;
        const float display = curve_ == Curve::Pq ? 1
                              : luminance > 0     ? kPeak * elementary::pow(luminance, kGamma - 1)
                                                  : 0;
        const float seen = most * display;
        return display * (1 + seen / (kPeak * kPeak)) / (1 + seen);
    }

    Curve curve_;
    std::vector<float> light_;  ///< [kFull + 1] light of each sample
};

/// Creates the conversion of a file with high dynamic range.
ColourConversion read_wide_range(WideRange::Curve curve, std::optional<LightMatrix> matrix) {
    const auto range = std::make_shared<const WideRange>(curve);
    const ToneCurve square = [](float root) { return root * root; };
    return {Space::Rgb,
            [range](const std::uint16_t* from, std::uint16_t* to, std::size_t pixels) { (*range)(from, to, pixels); },
            {square, square, square},
            matrix,
            [range](float share) { return (*range)(share); }};
}

/// Creates the conversion that code points describe; none for sRGB.
/// @param profile  result of make_profile() for the code points
std::optional<ColourConversion> read_code_points(const Context& context, const ColourTags::CodePoints& code,
                                                 const Handle& profile) {
    if (code.transfer == kPq || code.transfer == kHlg)
        return read_wide_range(WideRange::Curve{code.transfer}, light_matrix(context, profile.get()));
    return read_matrix_profile(context, profile);
}

/// Creates the conversion for a file that gives primaries but no profile. The curve remains that of the file format.
std::optional<ColourConversion> read_primaries(const Context& context, const std::array<double, 8>& xy) {
    const cmsCIExyYTRIPLE primaries{{xy[2], xy[3], 1}, {xy[4], xy[5], 1}, {xy[6], xy[7], 1}};
    const Handle profile = make_rgb(context, {xy[0], xy[1], 1}, primaries, make_srgb_curve(context));
    if (!profile) return std::nullopt;
    return simplify({Space::Rgb, {}, {}, light_matrix(context, profile.get()), {}});
}

}  // namespace

std::optional<ColourConversion> convert_colours(const ColourTags& tags) {
    if (!tags.code_points && tags.profile.empty() && !tags.primaries) return std::nullopt;
    const Context context = make_context();
    if (!context) return std::nullopt;
    if (tags.code_points) {
        if (const Handle profile = make_profile(context, *tags.code_points))
            return read_code_points(context, *tags.code_points, profile);
    }
    if (!tags.profile.empty()) {
        const auto size = static_cast<cmsUInt32Number>(tags.profile.size());
        const Handle profile = own_profile(context, cmsOpenProfileFromMemTHR(context.get(), tags.profile.data(), size));
        if (profile) return read_profile(context, profile);
    }
    return tags.primaries ? read_primaries(context, *tags.primaries) : std::nullopt;
}

std::optional<ColourConversion> convert_lab() {
    const Context context = make_context();
    if (!context) return std::nullopt;
    const Handle profile = own_profile(context, cmsCreateLab4ProfileTHR(context.get(), nullptr));
    return profile ? read_table_profile(context, profile, Space::Lab) : std::nullopt;
}

}  // namespace ccdt::api
