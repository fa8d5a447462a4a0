#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "api/input/feature_list.h"
#include "api/input/option_reader.h"
#include "core/result.h"

namespace ccdt::api {

/// What of the features of a map is counted, as a request has it: one property, or several, each a class of its own.
struct Counting {
    std::optional<std::string> property;
    std::optional<double> per;         ///< of the property's unit to a point, > 0; none: 1
    std::vector<std::string> classes;  ///< properties; at most one for each of the colours of a drawing

    bool is_asked_for() const { return property || per || !classes.empty(); }
};

/// Reads what `sites` counts: a property's name, or `{"property":name,"per":number}`. Errors: Malformed.
Result<void> read_counted(const Input& input, Counting& counting);

/// Tells whether `sites` counts: whether it is no number, nor a text that looks like one.
bool is_counted(const Input& input);

Result<double> read_per(const Input& input);

/// Reads names of properties, each once. Errors: Malformed.
Result<std::vector<std::string>> read_classes(const Input& input);

/// How many points of each class a map's features have.
struct FeatureCounts {
    /// Features that have no count of a class.
    struct Missing {
        std::size_t features = 0;
        std::string first;  ///< JSON Pointer to where the first one's should be
    };

    std::vector<std::string> classes;  ///< properties, as they are called
    bool are_told = false;             ///< answers tell of classes: they were asked for
    std::vector<std::size_t> counts;   ///< [features * classes]
    std::vector<Missing> missing;      ///< [classes]

    std::size_t features() const { return counts.size() / classes.size(); }
    std::size_t count(std::size_t feature, std::size_t number) const {
        return counts[feature * classes.size() + number];
    }

    /// Counts the points of a feature, of all classes.
    std::size_t points_of(std::size_t feature) const;
    std::size_t total() const;
};

/// Counts the points of each feature: a property over `per`, rounded so that they add up to the rounded sum (the method
/// of largest remainders; of equal ones the first). A number may stand in a string, as in files of a census; null, or
/// no property, is 0.
///
/// @param features  of a collection
/// @param sites     pointer or name of the option, for errors
/// Errors: Malformed, with a JSON Pointer to what is no number of at least 0; Unusable if there is no point at all;
/// LimitExceeded for more than limits.max_sites, naming it.
Result<FeatureCounts> count_features(const FeatureSource& features, const Counting& counting, const Limits& limits,
                                     const std::string& sites);

}  // namespace ccdt::api
