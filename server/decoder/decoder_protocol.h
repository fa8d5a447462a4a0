// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>

#include "api/surface/surface_reader.h"
#include "core/base/result.h"
#include "core/halftone/inks/overprint.h"
#include "core/picture/picture.h"
#include "server/decoder/decoder_confinement.h"
#include "server/decoder/decoder_sandbox.h"
#include "server/processes/unique_fd.h"

namespace ccdt::server {

/// Messages between the server, the decoder's helper and its children. These programs are built together, so structs
/// are sent as they are in memory. The server trusts the helper, and validates the data from children.

/// First message from the helper, sent once it is ready.
struct Hello {
    Confinement confinement;  ///< confinement of the helper and its children
};

/// Message from the server to the helper: a file to decode.
struct Order {
    /// Type of the result: a Picture, a ColourPicture, the GeoJSON of a shapefile, or the triangles of a mesh.
    enum class Product : std::uint32_t { Grey, Colour, Map, Surface };

    /// Maximum length of a shapefile's name, in bytes.
    static constexpr std::size_t kLongestName = 1000;

    struct Text {
        std::uint64_t bytes = 0;     ///< size of the file
        std::uint64_t max_size = 0;  ///< maximum number of pixels of the picture, or of bytes of the map or the mesh
        Product product = Product::Grey;
        std::int32_t reduce = 1;                         ///< as in api::Reading
        std::int32_t is_stack = 0;                       ///< as in api::Reading
        std::optional<Light> ground = {};                ///< as in api::Reading
        std::array<char, kLongestName + 1> object = {};  ///< as in api::ShapefileReading; padded with zeros
        api::SurfaceHeader surface = {};                 ///< for a mesh
        std::int64_t patience_ms = 0;                    ///< maximum wait for a helper, in milliseconds
        DecoderLimits limits;
    };
    Text text;
    UniqueFd file;
    UniqueFd reply;    ///< memory made by ReplyMemory, ReplyText or ReplySurface
    UniqueFd outcome;  ///< socket for Outcomes; when its other end is closed, the child is ended

    using Files = std::array<UniqueFd, 3>;

    /// Moves received files into the members. They must be in the sequence in which send_order() sends them.
    void take(Files files);
};

/// A report about an order. The child sends reports with `begun` set, the first at once and others while it decodes.
/// Then it sends a report with all members 0, which means that the reply is written. The helper reports that the child
/// has ended or could not be forked. The server reports that no helper was available. Only the first report without
/// `begun` counts.
struct Outcome {
    static constexpr int kMaxBegun = 32;  ///< maximum number of reports of a child with `begun`

    std::int32_t fork_error = 0;  ///< errno if a child could not be forked or prepared; otherwise 0
    std::int32_t ended = 0;       ///< 1: the child has ended; without a reply, if this report counts
    std::int32_t no_helper = 0;   ///< 1: there was no helper by the time limit of the order
    std::int32_t begun = 0;       ///< 1: the child has the order; another report follows
    std::int32_t too_slow = 0;    ///< 1: the child ended because it used up its processor time
    std::int32_t killed = 0;      ///< 1: the child was killed from outside
    std::int64_t used_us = 0;     ///< processor time of the child, in microseconds; 0 in reports with `begun`
    double decoded = 0;           ///< share of the file that is decoded, in reports with `begun`
};

/// Sends an order with its files.
/// @returns  false if the helper has ended
bool send_order(int socket, const Order& order);

/// Waits for an order. Files that did not arrive are empty.
/// @returns  none once the server has ended
std::optional<Order> receive_order(int socket);

/// A child's reply that is a picture, in memory shared with the server, so that no pixel is copied.
/// @tparam AnyPicture  Picture or ColourPicture, according to the order
template <class AnyPicture>
class ReplyMemory {
public:
    /// Creates the shared memory as a file of fixed size. The system allocates its pages when they are written.
    static UniqueFd make_file(std::size_t max_pixels);

    /// Maps the memory. After a failure, the object converts to false.
    ReplyMemory(const UniqueFd& file, std::size_t max_pixels);
    explicit operator bool() const { return memory_ != nullptr; }

    static std::size_t size(std::size_t max_pixels);

    /// Allocates a plane of the picture: see api::NewPlane. Called by the child.
    std::shared_ptr<float[]> new_plane(std::size_t size);

    /// Writes a result. Called by the child.
    /// @returns  false if the planes were not allocated by new_plane() in the order of the picture's members
    bool write(const Result<AnyPicture>& result);

    /// Reads the result. Called by the server once the child is done. The planes have the size of the picture, which is
    /// within the limit. The values are not checked. A child under an attacker's control could change them even later.
    /// @returns  none if the reply is invalid
    std::optional<Result<AnyPicture>> read() const;

private:
    static constexpr std::size_t kPlanes = std::is_same_v<AnyPicture, Picture> ? 2 : 4;  ///< alpha is the last one

    float* plane(std::size_t offset) const;

    std::size_t max_pixels_;
    std::size_t used_ = 0;  ///< number of values that were allocated
    std::shared_ptr<std::byte> memory_;
};

/// A child's reply of limited size, in memory shared with the server.
class ReplyBytes {
public:
    /// Creates the shared memory, like ReplyMemory::make_file.
    static UniqueFd make_file(std::size_t max_bytes);

    /// Maps the memory. After a failure, the object converts to false.
    ReplyBytes(const UniqueFd& file, std::size_t max_bytes);
    explicit operator bool() const { return memory_ != nullptr; }

    static std::size_t size(std::size_t max_bytes);

protected:
    std::size_t max_bytes_;
    std::shared_ptr<std::byte> memory_;
};

/// A child's reply that is a text.
class ReplyText : public ReplyBytes {
public:
    using ReplyBytes::ReplyBytes;

    /// Appends a piece of the text. Called by the child.
    /// @returns  false if the text would exceed the limit
    bool append(std::string_view piece);

    /// Ends the text or replaces it by an error. Called by the child.
    void write(const Result<void>& result);

    /// Reads the result. Called by the server. Copies the text, because the child could still change it.
    /// @returns  none if the reply is invalid
    std::optional<Result<std::string>> read() const;

private:
    std::size_t used_ = 0;
};

/// A child's reply that is a mesh.
class ReplySurface : public ReplyBytes {
public:
    using ReplyBytes::ReplyBytes;

    /// Returns the maximum total size of the arrays of a mesh, in bytes.
    static std::size_t max_bytes(const api::SurfaceHeader& header);

    /// Writes a result. Called by the child.
    /// @returns  false if the arrays do not fit
    bool write(const Result<api::SurfaceContents>& result);

    /// Reads the result. Called by the server. Copies the arrays, because the child could still change them. The
    /// indices of the triangles are valid. Other values are not checked.
    /// @returns  none if the reply is invalid
    std::optional<Result<api::SurfaceContents>> read() const;
};

}  // namespace ccdt::server
