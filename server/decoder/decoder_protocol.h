#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
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
    struct Text {
        std::uint64_t bytes = 0;       ///< of the file
        std::uint64_t max_pixels = 0;  ///< of the picture
        std::uint32_t colour = 0;      ///< to be decoded to a ColourPicture; else to a Picture
        std::int32_t reduce = 1;       ///< as api::Reading has it
        std::int64_t patience_ms = 0;  ///< for which the order may wait for a helper
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

}  // namespace ccdt::server
