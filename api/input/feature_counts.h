// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "api/input/feature_list.h"
#include "api/input/option_reader.h"
#include "core/base/result.h"
#include "core/geometry/point3.h"

namespace ccdt::api {

/// The feature properties that hold the dot counts of a map, as a request names them: one property, or one property for
/// each class.
struct Counting {
    std::optional<std::string> property;
    std::optional<double> per;         ///< units of the property per point, > 0; none: 1
    std::vector<std::string> classes;  ///< names of the properties; at most as many as a drawing has colours

    bool is_requested() const { return property || per || !classes.empty(); }
};

/// Reads the option `sites` of a dot map: a property's name, or `{"property":name,"per":number}`. Errors: Malformed.
Result<void> read_counted(const Input& input, Counting& counting);

/// Returns whether the option `sites` names a property instead of being a number. A text names a property unless it is
/// empty or a number. A JSON value names a property if it is a string or an object.
bool is_counted(const Input& input);

/// Reads the option `per`: units of the property per point. Errors: Malformed.
Result<double> read_per(const Input& input);

/// Reads names of properties, each of which may occur once. Errors: Malformed.
Result<std::vector<std::string>> read_classes(const Input& input);

/// Number of points of each class in each feature.
struct FeatureCounts {
    /// Features for which the count of a class is missing or null.
    struct Missing {
        std::size_t features = 0;
        std::string first;  ///< JSON Pointer to the first missing count
    };

    std::vector<std::string> classes;  ///< names of the properties that hold the counts, as in the features
    double per = 1;                    ///< units of the properties per point
    bool are_named = false;            ///< whether the request named the classes; if so, answers name them too
    std::vector<std::size_t> counts;   ///< [features][classes], one feature after the other
    std::vector<Missing> missing;      ///< [classes]

    std::size_t features() const { return counts.size() / classes.size(); }
    /// Returns the number of points of a class in a feature.
    /// @param number  index of the class
    std::size_t count(std::size_t feature, std::size_t number) const {
        return counts[feature * classes.size() + number];
    }

    /// Returns the sum of a feature's counts over all classes.
    std::size_t points_of(std::size_t feature) const;
    std::size_t total() const;
};

/// Computes the number of points of each class in each feature: a property divided by `per`, then rounded by
/// apportion(). The rounded numbers of a class thus add up to its rounded sum. Features without a middle are rounded
/// one by one. A number may be given as a string, as in census files. A property that is null or missing counts as 0.
///
/// @param features  features of a collection
/// @param places    [features] result of middle_of()
/// @param sites     JSON Pointer to the option `sites`, or the option's name, for errors
/// Errors: Malformed, with a JSON Pointer to a value that is not a number of at least 0; Unusable if all numbers are 0;
/// LimitExceeded, with the limit in the message, for more than limits.max_sites points.
Result<FeatureCounts> count_features(const FeatureSource& features, std::span<const std::optional<Point3>> places,
                                     const Counting& counting, const Limits& limits, const std::string& sites);

}  // namespace ccdt::api
