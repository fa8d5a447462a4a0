// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/map/shapefile_reader.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <shapefil.h>

#include "api/input/option_reader.h"
#include "api/json/json_document.h"
#include "api/map/code_page.h"
#include "api/map/ring_groups.h"
#include "api/map/shapefile_parts.h"
#include "api/text/numbers.h"
#include "api/text/text.h"

namespace ccdt::api {
namespace {

tl::unexpected<Error> unusable(std::string message) {
    return failure(ErrorCode::Unusable, std::move(message));
}

/// A file in memory that the library has open.
struct OpenFile {
    std::string_view bytes;
    std::size_t position = 0;
};

/// Files that open_file() may open, by their extensions; null except while a shapefile is being opened. The variable is
/// thread-local, because the library passes only a name to open_file().
thread_local const ShapefileParts* files_to_open = nullptr;

OpenFile& file_of(SAFile file) {
    return *reinterpret_cast<OpenFile*>(file);
}

SAFile open_file(const char* name, const char* /*access*/) {
    const std::string_view path = name;
    const std::pair<std::string_view, const std::string*> known[] = {{".shp", &files_to_open->shp},
                                                                     {".shx", &files_to_open->shx},
                                                                     {".dbf", &files_to_open->dbf},
                                                                     {".cpg", &files_to_open->cpg}};
    for (const auto& [ending, bytes] : known) {
        if (path.ends_with(ending) && !bytes->empty()) return reinterpret_cast<SAFile>(new OpenFile{*bytes});
    }
    return nullptr;
}

/// Reads like fread(). Copies an incomplete last item, but does not count it.
SAOffset read_file(void* to, SAOffset size, SAOffset count, SAFile file) {
    OpenFile& open = file_of(file);
    if (size == 0 || open.position >= open.bytes.size()) return 0;
    const std::size_t bytes = open.bytes.copy(static_cast<char*>(to), size * count, open.position);
    open.position += bytes;
    return bytes / size;
}

SAOffset seek_file(SAFile file, SAOffset offset, int whence) {
    OpenFile& open = file_of(file);
    const std::size_t base = whence == SEEK_SET ? 0 : whence == SEEK_CUR ? open.position : open.bytes.size();
    open.position = base + offset;
    return 0;
}

SAHooks hooks_in_memory() {
    SAHooks hooks{};
    hooks.FOpen = open_file;
    hooks.FRead = read_file;
    hooks.FWrite = [](void*, SAOffset, SAOffset, SAFile) { return SAOffset{0}; };
    hooks.FSeek = seek_file;
    hooks.FTell = [](SAFile file) { return SAOffset{file_of(file).position}; };
    hooks.FFlush = [](SAFile) { return 0; };
    hooks.FClose = [](SAFile file) {
        delete &file_of(file);
        return 0;
    };
    hooks.Remove = [](const char*) { return -1; };
    hooks.Error = [](const char*) {};
    hooks.Atof = [](const char* text) { return parse_number<double>(text).value_or(0); };
    return hooks;
}

struct CloseShapes {
    void operator()(SHPInfo* shapes) const { SHPClose(shapes); }
};
struct CloseTable {
    void operator()(DBFInfo* table) const { DBFClose(table); }
};
using Shapes = std::unique_ptr<SHPInfo, CloseShapes>;
using Table = std::unique_ptr<DBFInfo, CloseTable>;

/// A shapefile that the library has open.
struct OpenShapefile {
    Shapes shapes;
    Table table;  ///< null: the shapefile has no table of properties
};

OpenShapefile open_parts(const ShapefileParts& parts) {
    SAHooks hooks = hooks_in_memory();
    files_to_open = &parts;
    OpenShapefile open{Shapes(SHPOpenLL("map.shp", "rb", &hooks)), Table(DBFOpenLL("map.dbf", "rb", &hooks))};
    files_to_open = nullptr;
    return open;
}

/// Field of the table of properties.
struct Field {
    int column = 0;
    std::string name;  ///< name of the field, as a JSON string
    char type = 'C';   ///< letter of the type in the .dbf file
};

/// Whether a type of fields has texts that depend on the code page.
bool is_text(char type) {
    return type != 'N' && type != 'F' && type != 'L' && type != 'D';
}

/// Whether the values of a type of fields are not texts, in FoxPro and later versions of dBASE.
bool is_binary(char type) {
    return std::string_view("IOBYT+@").find(type) != std::string_view::npos;
}

/// Appends an integer as JSON, with all its digits. Returns false if the text is not an integer.
bool append_integer(std::string& out, std::string_view text) {
    const bool is_negative = text.starts_with('-');
    if (is_negative || text.starts_with('+')) text.remove_prefix(1);
    if (text.empty() || text.find_first_not_of("0123456789") != std::string_view::npos) return false;
    text.remove_prefix(std::min(text.find_first_not_of('0'), text.size() - 1));
    out.append(is_negative && text != "0" ? "-" : "").append(text);
    return true;
}

/// Properties of the records, in the .dbf file.
class Properties {
public:
    static Result<Properties> create(Table table, std::string_view dbf, std::size_t records) {
        Properties properties(std::move(table));
        const DBFInfo& info = *properties.table_;
        const auto given = static_cast<std::size_t>(std::max(info.nRecords, 0));
        if (given != records)
            return unusable("the .dbf file has " + std::to_string(given) + " records, the .shp file " +
                            std::to_string(records));
        const auto header = static_cast<std::size_t>(info.nHeaderLength);
        const auto length = static_cast<std::size_t>(info.nRecordLength);
        if (dbf.size() < header || (length > 0 && (dbf.size() - header) / length < records))
            return unusable("the .dbf file is truncated");
        properties.read_fields();
        return properties;
    }

    bool is_deleted(std::size_t record) const {
        return DBFIsRecordDeleted(table_.get(), static_cast<int>(record)) != 0;
    }

    /// Appends the names of fields that are left out, each with the reason, as a JSON object.
    void append_unreadable(std::string& out) const {
        char before = '{';
        for (const auto& [name, reason] : unreadable_) {
            out += std::exchange(before, ',');
            out.append(name) += ':';
            append_json_text(out, reason);
        }
        out += '}';
    }

    bool has_unreadable() const { return !unreadable_.empty(); }

    /// Appends the properties of a record as a JSON object.
    Result<void> append(std::string& out, std::size_t record) const {
        out += '{';
        for (const Field& field : fields_) {
            out.append(&field == fields_.data() ? "" : ",").append(field.name) += ':';
            const int row = static_cast<int>(record);
            if (DBFIsAttributeNULL(table_.get(), row, field.column) != 0) {
                out += "null";
                continue;
            }
            const char* const value = DBFReadStringAttribute(table_.get(), row, field.column);
            if (value == nullptr) return unusable("the .dbf file is truncated");
            // For shapelib, a value of NULs is not null in every type.
            if (*value == '\0')
                out += "null";
            else
                append_value(out, field.type, value);
        }
        out += '}';
        return {};
    }

private:
    explicit Properties(Table table) : table_(std::move(table)) {
        const char* const name = DBFGetCodePage(table_.get());
        page_ = CodePage::find(trim(name == nullptr ? "" : name, " \t\r\n"));
    }

    /// Lists the fields. Leaves out fields whose name is taken, or whose name or texts are in an unknown encoding.
    void read_fields() {
        for (int i = 0; i < DBFGetFieldCount(table_.get()); ++i) {
            std::array<char, XBASE_FLDNAME_LEN_READ + 1> name{};
            DBFGetFieldInfo(table_.get(), i, name.data(), nullptr, nullptr);
            Field field{i, {}, DBFGetNativeFieldType(table_.get(), i)};
            append_json_text(field.name, utf8_of(name.data()));
            const auto leave_out = [&](std::string_view reason) {
                unreadable_.emplace(field.name,
                                    "the field " + excerpt(field.name) + " cannot be read: " + std::string(reason));
            };
            const auto same = std::ranges::find(fields_, field.name, &Field::name);
            if (is_binary(field.type)) {
                leave_out(std::string("fields of the type ") + field.type + " are not supported");
            } else if (same != fields_.end()) {
                fields_.erase(same);
                leave_out("the .dbf file has two fields of this name");
            } else if (!page_ && !(is_ascii(name.data()) && (!is_text(field.type) || has_only_ascii(i)))) {
                leave_out(page_.error().message);
            } else if (!unreadable_.contains(field.name)) {
                fields_.push_back(std::move(field));
            }
        }
    }

    /// Whether the texts of a column are pure ASCII.
    bool has_only_ascii(int column) const {
        for (int row = 0; row < table_->nRecords; ++row) {
            const char* const value = DBFReadStringAttribute(table_.get(), row, column);
            if (value != nullptr && !is_ascii(value)) return false;
        }
        return true;
    }

    std::string utf8_of(std::string_view text) const { return page_ ? page_->to_utf8(text) : std::string(text); }

    /// @param value  neither empty nor the null value of its type
    void append_value(std::string& out, char type, std::string_view value) const {
        if (type == 'N' || type == 'F') {
            if (append_integer(out, trim(value))) return;
            const auto number = parse_number<double>(trim(value));
            if (number && std::isfinite(*number)) return append_shortest(out, *number);
        }
        if (type == 'L') {
            const char c = value.front();
            out += c == 'T' || c == 't' || c == 'Y' || c == 'y' ? "true" : "false";
        } else if (type == 'D' && value.size() == 8) {
            const std::string day(value);
            append_json_text(out, day.substr(0, 4) + '-' + day.substr(4, 2) + '-' + day.substr(6));
        } else {
            append_json_text(out, utf8_of(value));
        }
    }

    Table table_;
    Result<CodePage> page_ = tl::unexpected(Error{});  ///< encoding of the texts, or why it is unknown
    std::vector<Field> fields_;
    std::map<std::string, std::string> unreadable_;  ///< names of fields that are left out, as JSON, and the reasons
};

struct DestroyShape {
    void operator()(SHPObject* shape) const { SHPDestroyObject(shape); }
};
using Shape = std::unique_ptr<SHPObject, DestroyShape>;

bool is_polygon(int type) {
    return type == SHPT_POLYGON || type == SHPT_POLYGONZ || type == SHPT_POLYGONM;
}

std::string describe_record(std::size_t record) {
    return "record " + std::to_string(record + 1) + " of the .shp file";
}

/// Writes the features of a shapefile.
class Writer {
public:
    Writer(const OpenShapefile& open, const Properties* properties, std::size_t max_bytes, const TakeText& take)
        : shapes_(*open.shapes), properties_(properties), max_bytes_(max_bytes), take_(take) {}

    /// @param system  well-known text of the reference system; empty if there is none
    Result<void> write(std::string_view system) {
        text_ = R"({"type":"FeatureCollection",)";
        if (!system.empty()) {
            text_ += R"("crs":{"type":"name","properties":{"name":)";
            append_json_text(text_, system);
            text_ += "}},";
        }
        if (properties_ != nullptr && properties_->has_unreadable()) {
            text_ += R"("unreadable":)";
            properties_->append_unreadable(text_);
            text_ += ',';
        }
        text_ += R"("features":[)";
        bool is_first = true;
        for (std::size_t i = 0; i < static_cast<std::size_t>(shapes_.nRecords); ++i) {
            if (properties_ != nullptr && properties_->is_deleted(i)) continue;
            if (!std::exchange(is_first, false)) text_ += ',';
            if (auto written = write_feature(i); !written) return written;
        }
        text_ += "]}";
        return flush(0);
    }

private:
    /// Number of bytes that are collected before the text is passed on.
    static constexpr std::size_t kPiece = 65'536;

    Result<void> write_feature(std::size_t record) {
        text_ += R"({"type":"Feature","properties":)";
        if (properties_ == nullptr) {
            text_ += "null";
        } else if (auto appended = properties_->append(text_, record); !appended) {
            return appended;
        }
        text_ += R"(,"geometry":)";
        if (auto written = write_shape(record); !written) return written;
        text_ += '}';
        return flush(kPiece);
    }

    Result<void> write_shape(std::size_t record) {
        const auto rings = read_rings(record);
        if (!rings) return tl::unexpected(rings.error());
        const auto polygons = group_rings(*rings);
        if (polygons.empty()) {
            text_ += "null";
            return {};
        }
        const bool is_multiple = polygons.size() > 1;
        text_ += is_multiple ? R"({"type":"MultiPolygon","coordinates":[)" : R"({"type":"Polygon","coordinates":)";
        for (std::size_t i = 0; i < polygons.size(); ++i) {
            if (i > 0) text_ += ',';
            if (auto written = write_polygon(*rings, polygons[i]); !written) return written;
        }
        text_ += is_multiple ? "]}" : "}";
        return {};
    }

    Result<void> write_polygon(std::span<const Ring> rings, std::span<const std::size_t> indices) {
        char before = '[';
        for (const std::size_t index : indices) {
            text_ += std::exchange(before, ',');
            append_ring(rings[index]);
            if (auto flushed = flush(kPiece); !flushed) return flushed;
        }
        text_ += ']';
        return {};
    }

    void append_ring(const Ring& ring) {
        char before = '[';
        for (const Point& p : ring) {
            text_ += std::exchange(before, ',');
            text_ += '[';
            append_shortest(text_, p.x);
            text_ += ',';
            append_shortest(text_, p.y);
            text_ += ']';
        }
        text_ += ']';
    }

    Result<std::vector<Ring>> read_rings(std::size_t record) {
        const Shape shape(SHPReadObject(&shapes_, static_cast<int>(record)));
        if (shape == nullptr) return unusable(describe_record(record) + " is damaged");
        if (shape->nSHPType == SHPT_NULL) return std::vector<Ring>();
        if (!is_polygon(shape->nSHPType)) return unusable(describe_record(record) + " is not a polygon");
        std::vector<Ring> rings;
        for (int part = 0; part < shape->nParts; ++part) {
            const int end = part + 1 < shape->nParts ? shape->panPartStart[part + 1] : shape->nVertices;
            Ring ring;
            for (int i = shape->panPartStart[part]; i < end; ++i) ring.push_back({shape->padfX[i], shape->padfY[i]});
            const auto is_finite = [](const Point& p) { return std::isfinite(p.x) && std::isfinite(p.y); };
            if (!std::ranges::all_of(ring, is_finite))
                return unusable(describe_record(record) + " has a coordinate that is not a finite number");
            if (!ring.empty()) rings.push_back(std::move(ring));
        }
        return rings;
    }

    /// Passes the collected text on if it has at least `least` bytes.
    Result<void> flush(std::size_t least) {
        if (text_.size() < least) return {};
        if (text_.size() > max_bytes_ - written_ || !take_(text_))
            return too_many_bytes("the shapefile, converted to GeoJSON, is larger", max_bytes_);
        written_ += text_.size();
        text_.clear();
        return {};
    }

    SHPInfo& shapes_;
    const Properties* properties_;  ///< null: no properties
    const std::size_t max_bytes_;
    const TakeText& take_;
    std::string text_;  ///< collected text that has not been passed on yet
    std::size_t written_ = 0;
};

}  // namespace

Result<void> read_shapefile(std::string_view archive, const ShapefileReading& reading, const TakeText& take) {
    const auto parts = read_parts(archive, reading);
    if (!parts) return tl::unexpected(parts.error());
    OpenShapefile open = open_parts(*parts);
    if (open.shapes == nullptr) return unusable("the .shp file is damaged");
    const int type = open.shapes->nShapeType;
    if (type != SHPT_NULL && !is_polygon(type))
        return unusable(std::string("only shapefiles of polygons are read; the type of this one is ") +
                        SHPTypeName(type));
    if (!parts->dbf.empty() && open.table == nullptr) return unusable("the .dbf file is damaged");
    std::optional<Properties> properties;
    if (open.table != nullptr) {
        auto read =
            Properties::create(std::move(open.table), parts->dbf, static_cast<std::size_t>(open.shapes->nRecords));
        if (!read) return tl::unexpected(read.error());
        properties = *std::move(read);
    }
    return Writer(open, properties ? &*properties : nullptr, reading.max_bytes, take).write(parts->prj);
}

}  // namespace ccdt::api
