// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/decoder/decoder_protocol.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <new>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include "api/text/text.h"
#include "server/processes/messages.h"

namespace ccdt::server {
namespace {

constexpr std::size_t kLongestMessage = 1000;
constexpr std::size_t kLongestField = 100;

/// Offset of the planes or the text from the beginning of a reply, in bytes.
constexpr std::size_t kHeadSize = 4096;

/// The beginning of a reply. The message and the field name of an error follow it.
struct ReplyHead {
    std::uint32_t is_product = 0;    ///< 1: picture, text or mesh; 0: error
    std::uint32_t code = 0;          ///< for an error
    std::uint64_t message_size = 0;  ///< of an error, or of the texts of SurfaceContents
    std::int32_t width = 0;          ///< for a picture, like `height` and `has_alpha`
    std::int32_t height = 0;
    std::uint32_t has_alpha = 0;
    std::uint64_t field_size = 0;
    std::uint64_t text_size = 0;           ///< for a text
    std::array<std::uint64_t, 7> sizes{};  ///< for a mesh: sizes of its arrays, as in arrays_of()
};
static_assert(sizeof(ReplyHead) + kLongestMessage + kLongestField <= kHeadSize);

UniqueFd make_reply_file(std::size_t size) {
    UniqueFd file(memfd_create("reply", MFD_CLOEXEC | MFD_ALLOW_SEALING));
    // If a child could shrink the file, the server would crash when it reads the mapped memory.
    if (!file || ftruncate(file.get(), static_cast<off_t>(size)) != 0 ||
        fcntl(file.get(), F_ADD_SEALS, F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_SEAL) != 0) {
        return {};
    }
    return file;
}

/// Maps the shared memory of a reply; null on failure.
std::shared_ptr<std::byte> map_reply(const UniqueFd& file, std::size_t size) {
    void* const begin = mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_SHARED, file.get(), 0);
    if (begin == MAP_FAILED) return nullptr;
    return {static_cast<std::byte*>(begin), [size](std::byte* memory) { munmap(memory, size); }};
}

/// Writes an error into the head and, after it, the message and the field.
void write_error(const Error& error, ReplyHead& head, std::byte* memory) {
    const auto message = std::string_view(error.message).substr(0, kLongestMessage);
    const auto field = std::string_view(error.field).substr(0, kLongestField);
    head.code = static_cast<std::uint32_t>(error.code);
    head.message_size = message.size();
    head.field_size = field.size();
    std::memcpy(memory + sizeof(head), message.data(), message.size());
    std::memcpy(memory + sizeof(head) + message.size(), field.data(), field.size());
}

/// Reads an error from a reply; none if the reply is invalid.
std::optional<tl::unexpected<Error>> read_error(const ReplyHead& head, const std::byte* memory) {
    const bool known = head.code <= static_cast<std::uint32_t>(ErrorCode::Internal);
    if (!known || head.message_size == 0 || head.message_size > kLongestMessage || head.field_size > kLongestField)
        return std::nullopt;
    const auto* const message = reinterpret_cast<const char*>(memory + sizeof(head));
    const auto size = static_cast<std::size_t>(head.message_size);
    return failure(static_cast<ErrorCode>(head.code), {message, size},
                   {message + size, static_cast<std::size_t>(head.field_size)});
}

/// Allocates the pages of an array with one system call. This takes half as long as one page fault for each page. If
/// the call fails, each page is allocated when it is first written.
void populate(float* values, std::size_t count, int advice) {
    const std::size_t excess = reinterpret_cast<std::uintptr_t>(values) % static_cast<std::size_t>(getpagesize());
    madvise(reinterpret_cast<std::byte*>(values) - excess, excess + count * sizeof(float), advice);
}

/// Planes of a picture, in the order of its members.
template <class AnyPicture>
auto planes_of(AnyPicture& picture) {
    if constexpr (std::is_same_v<std::remove_const_t<AnyPicture>, Picture>) {
        return std::array{&picture.luminance, &picture.alpha};
    } else {
        return std::array{&picture.red, &picture.green, &picture.blue, &picture.alpha};
    }
}

/// Arrays of a mesh, in the order in which a reply contains them.
template <class Soup>
auto arrays_of(Soup& soup) {
    return std::tie(soup.vertices, soup.colours, soup.texture, soup.triangles, soup.material_of, soup.materials,
                    soup.texels);
}

/// Whether the values of a material are valid, and its picture lies within the texels of a mesh.
bool is_valid(const Material& material, std::size_t texels) {
    return material.wrap[0] <= Wrap::Mirror && material.wrap[1] <= Wrap::Mirror && material.alpha <= AlphaMode::Blend &&
           std::ranges::all_of(material.factor, [](float share) { return share >= 0 && share <= 1; }) &&
           material.first_texel <= texels &&
           std::uint64_t{material.width} * material.height <= texels - material.first_texel &&
           (material.width == 0) == (material.height == 0);
}

/// Whether the arrays of a mesh have matching sizes and all indices are valid.
bool is_consistent(const TriangleSoup& soup) {
    const std::size_t vertices = soup.vertices.size();
    const auto may_have = [](const auto& array, std::size_t size) { return array.empty() || array.size() == size; };
    return may_have(soup.colours, vertices) && may_have(soup.texture, vertices) && !soup.triangles.empty() &&
           soup.material_of.size() == (soup.materials.empty() ? 0 : soup.triangles.size()) &&
           std::ranges::all_of(soup.material_of, [&](std::uint32_t i) { return i < soup.materials.size(); }) &&
           std::ranges::all_of(soup.materials, [&](const Material& m) { return is_valid(m, soup.texels.size()); }) &&
           std::ranges::all_of(soup.triangles, [vertices](const std::array<std::uint32_t, 3>& corners) {
               return std::ranges::all_of(corners, [vertices](std::uint32_t corner) { return corner < vertices; });
           });
}

}  // namespace

bool send_order(int socket, const Order& order) {
    const std::array files = {order.file.get(), order.reply.get(), order.outcome.get()};
    return send_message(socket, bytes_of(order.text), files);
}

void Order::take(Files files) {
    file = std::move(files[0]);
    reply = std::move(files[1]);
    outcome = std::move(files[2]);
}

std::optional<Order> receive_order(int socket) {
    Order order;
    Order::Files files;
    if (receive_message(socket, writable_bytes_of(order.text), files) == 0) return std::nullopt;
    order.take(std::move(files));
    return order;
}

template <class AnyPicture>
UniqueFd ReplyMemory<AnyPicture>::make_file(std::size_t max_pixels) {
    return make_reply_file(size(max_pixels));
}

template <class AnyPicture>
std::size_t ReplyMemory<AnyPicture>::size(std::size_t max_pixels) {
    return kHeadSize + kPlanes * sizeof(float) * max_pixels;
}

template <class AnyPicture>
ReplyMemory<AnyPicture>::ReplyMemory(const UniqueFd& file, std::size_t max_pixels)
    : max_pixels_(max_pixels), memory_(map_reply(file, size(max_pixels))) {}

template <class AnyPicture>
float* ReplyMemory<AnyPicture>::plane(std::size_t offset) const {
    return reinterpret_cast<float*>(memory_.get() + kHeadSize) + offset;
}

template <class AnyPicture>
std::shared_ptr<float[]> ReplyMemory<AnyPicture>::new_plane(std::size_t size) {
    if (size > kPlanes * max_pixels_ - used_) throw std::bad_alloc();
    float* const begin = plane(used_);
    used_ += size;
    populate(begin, size, MADV_POPULATE_WRITE);
    return {memory_, begin};
}

template <class AnyPicture>
bool ReplyMemory<AnyPicture>::write(const Result<AnyPicture>& result) {
    ReplyHead head;
    if (result) {
        const auto planes = planes_of(*result);
        for (std::size_t i = 0; i < kPlanes; ++i) {
            const bool may_lack = i + 1 == kPlanes && planes[i]->empty();
            if (!may_lack && planes[i]->begin() != plane(i * planes[0]->size())) return false;
        }
        head.is_product = 1;
        head.width = result->width;
        head.height = result->height;
        head.has_alpha = result->alpha.empty() ? 0 : 1;
    } else {
        write_error(result.error(), head, memory_.get());
    }
    std::memcpy(memory_.get(), &head, sizeof(head));
    return true;
}

template <class AnyPicture>
std::optional<Result<AnyPicture>> ReplyMemory<AnyPicture>::read() const {
    ReplyHead head;
    std::memcpy(&head, memory_.get(), sizeof(head));
    if (head.is_product == 0) return read_error(head, memory_.get());
    if (head.width < 1 || head.height < 1) return std::nullopt;
    const auto width = static_cast<std::size_t>(head.width);
    const auto height = static_cast<std::size_t>(head.height);
    if (width > max_pixels_ / height) return std::nullopt;
    const std::size_t pixels = width * height;
    const std::size_t count = head.has_alpha != 0 ? kPlanes : kPlanes - 1;
    populate(plane(0), count * pixels, MADV_POPULATE_READ);
    AnyPicture picture;
    picture.width = head.width;
    picture.height = head.height;
    const auto planes = planes_of(picture);
    for (std::size_t i = 0; i < count; ++i)
        *planes[i] = Plane(std::shared_ptr<const float[]>(memory_, plane(i * pixels)), pixels);
    return picture;
}

template class ReplyMemory<Picture>;
template class ReplyMemory<ColourPicture>;

UniqueFd ReplyBytes::make_file(std::size_t max_bytes) {
    return make_reply_file(size(max_bytes));
}

std::size_t ReplyBytes::size(std::size_t max_bytes) {
    return kHeadSize + max_bytes;
}

ReplyBytes::ReplyBytes(const UniqueFd& file, std::size_t max_bytes)
    : max_bytes_(max_bytes), memory_(map_reply(file, size(max_bytes))) {}

bool ReplyText::append(std::string_view piece) {
    if (piece.size() > max_bytes_ - used_) return false;
    std::memcpy(memory_.get() + kHeadSize + used_, piece.data(), piece.size());
    used_ += piece.size();
    return true;
}

void ReplyText::write(const Result<void>& result) {
    ReplyHead head;
    if (result) {
        head.is_product = 1;
        head.text_size = used_;
    } else {
        write_error(result.error(), head, memory_.get());
    }
    std::memcpy(memory_.get(), &head, sizeof(head));
}

std::optional<Result<std::string>> ReplyText::read() const {
    ReplyHead head;
    std::memcpy(&head, memory_.get(), sizeof(head));
    if (head.is_product == 0) return read_error(head, memory_.get());
    if (head.text_size > max_bytes_) return std::nullopt;
    return std::string(reinterpret_cast<const char*>(memory_.get()) + kHeadSize,
                       static_cast<std::size_t>(head.text_size));
}

std::size_t ReplySurface::max_bytes(const api::SurfaceHeader& header) {
    using Soup = TriangleSoup;
    constexpr std::size_t kVertex = sizeof(Soup::vertices[0]) + sizeof(Soup::colours[0]) + sizeof(Soup::texture[0]);
    constexpr std::size_t kTriangle = sizeof(Soup::triangles[0]) + sizeof(Soup::material_of[0]);
    return static_cast<std::size_t>(header.max_vertices) * kVertex +
           static_cast<std::size_t>(header.max_triangles) * kTriangle +
           static_cast<std::size_t>(header.max_materials) * sizeof(Soup::materials[0]) +
           static_cast<std::size_t>(header.texels) * sizeof(Soup::texels[0]);
}

bool ReplySurface::write(const Result<api::SurfaceContents>& result) {
    ReplyHead head;
    if (result) {
        const auto arrays = arrays_of(result->soup);
        std::size_t used = 0;
        const auto append = [&](const auto& array) {
            const auto bytes = std::as_bytes(std::span(array));
            if (bytes.size() > max_bytes_ - used) return false;
            if (!bytes.empty()) std::memcpy(memory_.get() + kHeadSize + used, bytes.data(), bytes.size());
            used += bytes.size();
            return true;
        };
        if (!std::apply([&](const auto&... array) { return (append(array) && ...); }, arrays)) return false;
        head.is_product = 1;
        head.sizes =
            std::apply([](const auto&... array) { return std::array{std::uint64_t{array.size()}...}; }, arrays);
        std::string texts = result->picture_error;
        for (const std::string& warning : result->warnings) texts += '\n' + warning;
        texts.resize(std::min(texts.size(), kLongestMessage));
        head.message_size = texts.size();
        std::memcpy(memory_.get() + sizeof(head), texts.data(), texts.size());
    } else {
        write_error(result.error(), head, memory_.get());
    }
    std::memcpy(memory_.get(), &head, sizeof(head));
    return true;
}

std::optional<Result<api::SurfaceContents>> ReplySurface::read() const {
    ReplyHead head;
    std::memcpy(&head, memory_.get(), sizeof(head));
    if (head.is_product == 0) return read_error(head, memory_.get());
    api::SurfaceContents contents;
    if (head.message_size > kLongestMessage) return std::nullopt;
    const std::string text(reinterpret_cast<const char*>(memory_.get() + sizeof(head)),
                           static_cast<std::size_t>(head.message_size));
    std::string_view warnings = text;
    contents.picture_error = api::take_until(warnings, "\n");
    while (!warnings.empty()) contents.warnings.emplace_back(api::take_until(warnings, "\n"));
    std::size_t used = 0;
    const auto take = [&](auto& array, std::uint64_t size) {
        if (size > (max_bytes_ - used) / sizeof(array[0])) return false;
        array.resize(static_cast<std::size_t>(size));
        const auto bytes = std::as_writable_bytes(std::span(array));
        if (!bytes.empty()) std::memcpy(bytes.data(), memory_.get() + kHeadSize + used, bytes.size());
        used += bytes.size();
        return true;
    };
    const bool fits =
        std::apply([&, i = std::size_t{0}](auto&... array) mutable { return (take(array, head.sizes[i++]) && ...); },
                   arrays_of(contents.soup));
    if (!fits || !is_consistent(contents.soup)) return std::nullopt;
    return contents;
}

}  // namespace ccdt::server
