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

#include "core/halftone/picture.h"
#include "core/result.h"
#include "server/decoder/decoder_confinement.h"
#include "server/decoder/decoder_sandbox.h"
#include "server/processes/unique_fd.h"

namespace ccdt::server {

/// Messages between server, helper and decoding children. They are built together, so structs travel as they are.
/// The server trusts the helper; it takes from a child only what makes sense.

/// Message from the helper, once: it is ready.
struct Hello {
    Confinement confinement;  ///< of itself and its children
};

/// Message from the server to the helper: a file to decode.
struct Order {
    /// Result that the file is decoded to: a Picture, a ColourPicture, or the GeoJSON of a shapefile.
    enum class Product : std::uint32_t { Grey, Colour, Map };

    /// Bytes that the name of a shapefile may have.
    static constexpr std::size_t kLongestName = 1000;

    struct Text {
        std::uint64_t bytes = 0;  ///< of the file
        std::uint64_t most = 0;   ///< pixels of the picture, or bytes of the map
        Product product = Product::Grey;
        std::int32_t reduce = 1;                         ///< as api::Reading has it
        std::array<char, kLongestName + 1> object = {};  ///< as api::ShapefileReading has it; zeros after its end
        std::int64_t patience_ms = 0;                    ///< for which the order may wait for a helper
        DecoderLimits limits;
    };
    Text text;
    UniqueFd file;
    UniqueFd reply;       ///< made by ReplyMemory
    UniqueFd outcome;     ///< socket for Outcomes; once its other end is closed nobody waits for the child
    UniqueFd probe = {};  ///< socket to answer at; none, unless the message was a probe instead
};

/// The end of an order, of which the first counts: from the child, that its reply is written, from the helper, that the
/// child has ended or there was none, or from the server, that there was no helper.
struct Outcome {
    std::int32_t fork_error = 0;  ///< errno for why there was none, or none that could begin; 0: there was
    std::int32_t ended = 0;       ///< it crashed, was killed or gave up, unless it has said that it is done
    std::int32_t no_helper = 0;   ///< there was none for as long as the order might wait
};

/// Sends an order; false if there is no helper any more.
bool send_order(int socket, const Order& order);

/// Waits for an order. One whose descriptors did not arrive has none.
/// @returns  none once the server has gone
std::optional<Order> receive_order(int socket);

/// A child's reply, in memory that it shares with the server: no pixel is copied.
/// @tparam AnyPicture  Picture or ColourPicture, whichever the order asked for
template <class AnyPicture>
class ReplyMemory {
public:
    /// Memory for it: takes no more than is written to, and can neither shrink nor grow.
    static UniqueFd make_file(std::size_t max_pixels);

    /// Maps it; false afterwards if that failed.
    ReplyMemory(const UniqueFd& file, std::size_t max_pixels);
    explicit operator bool() const { return memory_ != nullptr; }

    static std::size_t size(std::size_t max_pixels);

    /// Makes room for the planes of the picture, as api::NewPlane; in the child.
    std::shared_ptr<float[]> new_plane(std::size_t size);

    /// Writes a result, in the child. Planes must come from `new_plane`, in the order of the picture's members; false
    /// if they do not.
    bool write(const Result<AnyPicture>& result);

    /// Reads the result, in the server, once the child is done. Whatever the child wrote, the picture is of the size
    /// that it says, not over the limit. Its values may be anything, and a child that was taken over can still change
    /// them.
    /// @returns  none for what no honest child writes
    std::optional<Result<AnyPicture>> read() const;

private:
    static constexpr std::size_t kPlanes = std::is_same_v<AnyPicture, Picture> ? 2 : 4;  ///< that of alpha is the last

    float* plane(std::size_t offset) const;

    std::size_t max_pixels_;
    std::size_t used_ = 0;  ///< values that were given room
    std::shared_ptr<std::byte> memory_;
};

/// A child's reply that is a text, in memory that it shares with the server.
class ReplyText {
public:
    /// Memory for it, as that of a picture.
    static UniqueFd make_file(std::size_t max_bytes);

    /// Maps it; false afterwards if that failed.
    ReplyText(const UniqueFd& file, std::size_t max_bytes);
    explicit operator bool() const { return memory_ != nullptr; }

    static std::size_t size(std::size_t max_bytes);

    /// Appends a piece of the text, in the child.
    /// @returns  false if there is no room for it
    bool append(std::string_view piece);

    /// Ends the text, or replaces it by an error, in the child.
    void write(const Result<void>& result);

    /// Copies the result, in the server, once the child is done: the child could still change the text.
    /// @returns  none for what no honest child writes
    std::optional<Result<std::string>> read() const;

private:
    std::size_t max_bytes_;
    std::size_t used_ = 0;
    std::shared_ptr<std::byte> memory_;
};

}  // namespace ccdt::server
