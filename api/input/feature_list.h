#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "api/input/option_reader.h"
#include "core/result.h"

namespace ccdt::api {

/// Reads names of properties, each once. Errors: Malformed.
/// @param one  what messages call one of them
Result<std::vector<std::string>> read_names(const Input& input, std::size_t most, std::string_view one);

/// Properties of features that a request wants its points to have.
struct PropertyChoice {
    static constexpr std::size_t kMost = 256;

    bool all = false;                ///< then there are no names
    std::vector<std::string> names;  ///< as the features call them, each once
};

/// Reads `*`, which stands for all properties, or names of properties. Errors: Malformed.
Result<PropertyChoice> read_properties(const Input& input);

/// Properties of features that answers repeat for each of their points.
struct CarriedProperties {
    static constexpr std::size_t kMostOfFeature = std::size_t{64} << 10;  ///< bytes, with names
    static constexpr std::size_t kMostInAll = std::size_t{1} << 30;       ///< bytes of an answer, with names

    /// Value of a property.
    struct Value {
        std::uint32_t name = 0;  ///< its index
        bool is_text = false;
        std::string value;  ///< the text, or JSON
    };

    std::vector<std::string> names;              ///< as answers call them
    std::vector<std::vector<Value>> of_feature;  ///< [features], in the order of the names; what is missing is left out

    /// Counts the bytes that the properties of a feature take, about.
    std::size_t size_of(std::size_t feature) const;

    /// Appends `"name":value` for each property of a feature, with commas between them.
    void append_members(std::string& out, std::size_t feature) const;
};

/// Features as the text of a document has them.
struct FeatureSource {
    JsonValue value;      ///< the list of features, or the only one
    std::string pointer;  ///< to it
    bool is_collection = true;
};

/// Finds the features of GeoJSON that read_geometry() has read: those of a FeatureCollection, or the Feature that it
/// is.
std::optional<FeatureSource> find_features(const Input& geometry);

/// Finds the features of TopoJSON: the geometries of an object that read_topology() has read, or the only one.
FeatureSource find_geometries(const Input& object);

/// Features of a GeoJSON document.
struct FeatureList {
    std::vector<std::string> ids;         ///< [features] as JSON; empty where there is none
    std::vector<std::size_t> first_part;  ///< of each feature among the parts of all [features + 1]
    std::string pointer;                  ///< to the list of features, or to the only one
    bool is_collection = true;
    CarriedProperties carried;  ///< none, unless they were chosen

    std::size_t size() const { return ids.size(); }

    /// Makes the JSON Pointer to a feature.
    std::string locate(std::size_t feature) const;
};

/// Finds the properties of a feature; none if there are none, or null.
/// @param pointer  to the feature
/// Errors: Malformed for what is neither an object nor null.
Result<std::optional<JsonValue>> properties_of(JsonValue feature, const std::string& pointer);

/// Lists features.
///
/// @param first_part  of each feature of a collection, as PolygonInput has them; empty for a Feature alone
/// @param parts       of all features
/// @param choice      properties to carry; null: none
/// @param option      pointer or name of the option that chose them, for errors
/// A property whose name answers use themselves (x, y, rank, feature, feature_id, class, color, sites) gets an
/// underscore at the end of its name.
/// Errors: Malformed for properties that are neither an object nor null, and for a name that no feature has;
/// LimitExceeded for more than PropertyChoice::kMost different names, or CarriedProperties::kMostOfFeature bytes.
Result<FeatureList> list_features(const FeatureSource& source, std::vector<std::size_t> first_part, std::size_t parts,
                                  const PropertyChoice* choice, const std::string& option);

/// Checks how much properties take in an answer that has them for each point.
/// @param points  of each feature [features]
/// Errors: LimitExceeded for more than CarriedProperties::kMostInAll bytes, with the field `option`.
Result<void> check_size(const CarriedProperties& carried, const std::vector<std::size_t>& points,
                        const std::string& option);

}  // namespace ccdt::api
