// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "api/input/option_reader.h"
#include "core/base/result.h"

namespace ccdt::api {

/// Reads a list of at most `most` names of properties. Errors: Malformed, also for a repeated name.
/// @param one  noun for a single name in messages, such as "property"
Result<std::vector<std::string>> read_names(const Input& input, std::size_t most, std::string_view one);

/// The feature properties that a request wants its points to carry.
struct PropertyChoice {
    static constexpr std::size_t kMax = 256;

    bool all = false;                ///< whether to carry all properties; `names` is then empty
    std::vector<std::string> names;  ///< names as they are in the features, without repetition
};

/// Reads `*`, which means all properties, or names of properties. Errors: Malformed.
Result<PropertyChoice> read_properties(const Input& input);

/// Feature properties that points carry.
struct CarriedProperties {
    static constexpr std::size_t kMaxOfFeature = std::size_t{64} << 10;  ///< bytes, including names
    static constexpr std::size_t kMaxInAll = std::size_t{1} << 30;       ///< bytes in an answer, including names

    /// Value of a property.
    struct Value {
        std::uint32_t name = 0;  ///< index into the names
        bool is_text = false;
        std::string value;  ///< the text itself; a value of any other type as JSON
    };

    std::vector<std::string> names;              ///< names in answers
    std::vector<std::vector<Value>> of_feature;  ///< [features] in the order of the names; missing values are left out

    /// Returns the approximate number of bytes that the properties of a feature take in an answer.
    std::size_t size_of(std::size_t feature) const;

    /// Appends `"name":value` for each property of a feature, with commas between them.
    void append_members(std::string& out, std::size_t feature) const;
};

/// The features of a document, as JSON values.
struct FeatureSource {
    std::vector<JsonValue> features;
    std::string pointer;  ///< JSON Pointer to the list of features, or to the single feature
    bool is_collection = true;
    /// Properties whose texts could not be read from a shapefile (read_shapefile()): an object with the reasons.
    std::optional<JsonValue> unreadable = {};

    /// Returns the JSON Pointer to a feature.
    std::string pointer_to(std::size_t feature) const;
};

/// Finds the features of GeoJSON that read_geometry() has read: the features of a FeatureCollection, or a single
/// Feature. Returns none for any other GeoJSON.
std::optional<FeatureSource> find_features(const Input& geometry);

/// Finds the features of TopoJSON that read_topology() has read: the geometries of a GeometryCollection, or the object
/// itself if it is a single geometry.
FeatureSource find_geometries(const Input& object);

/// Features of a GeoJSON or TopoJSON document.
struct FeatureList {
    std::vector<std::string> ids;         ///< [features] as JSON; empty for a feature without id
    std::vector<std::size_t> first_part;  ///< [features + 1] index of each feature's first part among all parts
    std::string pointer;                  ///< JSON Pointer to the list of features, or to the single feature
    bool is_collection = true;
    CarriedProperties carried;  ///< empty unless properties were chosen

    std::size_t size() const { return ids.size(); }

    /// Returns the JSON Pointer to a feature.
    std::string pointer_to(std::size_t feature) const;
};

/// Finds the properties of a feature; none if they are missing or null.
/// @param pointer  JSON Pointer to the feature
/// Errors: Malformed if they are neither an object nor null.
Result<std::optional<JsonValue>> properties_of(JsonValue feature, const std::string& pointer);

/// Checks that features have properties with these names. The values may be null.
/// @param option  field of errors
/// Errors: Malformed for a name that no feature has; the message lists the names of all properties. Unusable for a
/// property whose texts could not be read.
Result<void> check_names(const FeatureSource& source, std::span<const std::string> names, const std::string& option);

/// Lists the names of the properties that features have, as the end of a message.
/// @param wanted  a name that no feature has; a similar name is suggested. Empty: none
std::string describe_properties(const FeatureSource& source, std::string_view wanted = {});

/// Lists features, with the properties that their points carry.
///
/// @param first_part  [features] index of each feature's first part, as in PolygonInput; ignored for a single Feature
/// @param parts       number of parts of all features
/// @param choice      properties to carry; null: none
/// @param option      JSON Pointer to the option that chose the properties, or the option's name, for errors
/// Answers have columns and members of their own: x, y, rank, feature, feature_id, class, color, sites. A property with
/// one of these names gets one or more underscores at the end of its name.
/// Errors: Malformed for properties that are neither an object nor null; those of check_names() for the chosen names;
/// LimitExceeded for more than PropertyChoice::kMax different names, or more than CarriedProperties::kMaxOfFeature
/// bytes in a feature.
Result<FeatureList> list_features(const FeatureSource& source, std::vector<std::size_t> first_part, std::size_t parts,
                                  const PropertyChoice* choice, const std::string& option);

/// Checks the total size of the properties in an answer that repeats them for each point.
/// @param points  [features] number of points of each feature
/// @param option  field of the error
/// Errors: LimitExceeded for more than CarriedProperties::kMaxInAll bytes.
Result<void> check_size(const CarriedProperties& carried, const std::vector<std::size_t>& points,
                        const std::string& option);

}  // namespace ccdt::api
