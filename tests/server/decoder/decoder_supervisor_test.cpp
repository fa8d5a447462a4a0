// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/decoder/decoder_supervisor.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cctype>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <future>
#include <initializer_list>
#include <iterator>
#include <limits>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include "api/decode/decode.h"
#include "api/image/decoder_warm_up.h"
#include "api/image/image_codec.h"
#include "server/decoder/decoder_client.h"
#include "server/decoder/decoder_helper.h"
#include "server/decoder/decoder_protocol.h"
#include "tests/server/waiting.h"
#include "tests/support/mesh_files.h"

namespace ccdt::server {
namespace {

constexpr std::size_t kMaxPixels = 1'000'000;
constexpr DecoderLimits kLimits{std::size_t{64} << 20, std::chrono::seconds(60)};

/// Returns an error whose message tells whether a system call succeeded.
Result<Picture> outcome(long returned) {
    return failure(ErrorCode::Unsupported, returned < 0 ? "refused" : "done");
}

[[noreturn]] void spin() {
    for (volatile unsigned turns = 0;;) turns = turns + 1;
}

/// Allocates memory until std::bad_alloc is thrown.
void eat_memory() {
    std::vector<std::vector<char>> eaten;
    while (true) eaten.emplace_back(1 << 20, 'x');
}

Plane plane_of(std::initializer_list<float> values, const api::NewPlane& make_plane) {
    const auto plane = make_plane(values.size());
    std::ranges::copy(values, plane.get());
    return {plane, values.size()};
}

Picture picture_of(int width, std::initializer_list<float> luminance, const api::NewPlane& make_plane) {
    return {width, 1, plane_of(luminance, make_plane), {}};
}

/// Replaces the decoding of grey pictures: performs the action that the content of the file names.
Result<Picture> obey(std::string_view file, const api::Reading& reading, const api::NewPlane& make_plane) {
    if (file == "picture") {
        Picture picture = picture_of(3, {0, 0.5F, 1}, make_plane);
        picture.alpha = plane_of({1, 0.25F, 0}, make_plane);
        return picture;
    }
    if (file == "opaque") return picture_of(2, {0.125F, 1}, make_plane);
    if (file == "limit") return failure(ErrorCode::LimitExceeded, std::to_string(reading.max_pixels));
    if (file == "reduce") return failure(ErrorCode::LimitExceeded, std::to_string(reading.reduce));
    if (file == "steps") {
        for (const double share : {0.25, 0.5, 0.5, 0.51, 0.75}) reading.progress(share);
        return picture_of(2, {0, 1}, make_plane);
    }
    if (file == "flood") {
        for (const Outcome step{.begun = 1, .decoded = 0.5};;)
            static_cast<void>(write(STDOUT_FILENO, &step, sizeof(step)));
    }
    if (file == "crash") *static_cast<volatile int*>(nullptr) = 1;
    if (file == "abort") std::abort();
    if (file == "throw") throw std::runtime_error("thrown");
    if (file == "exit") _exit(0);
    if (file == "spin") spin();
    if (file == "eat") eat_memory();
    if (file == "open") return outcome(open("/proc/self/status", O_RDONLY | O_CLOEXEC));
    if (file == "socket") return outcome(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
    if (file == "fork") return outcome(fork());
    if (file == "exec") return outcome(execl("/bin/true", "true", nullptr));
    if (file == "kill") return outcome(kill(getppid(), 0));
    if (file == "write") return outcome(write(STDERR_FILENO, "x", 1));
    if (file == "elsewhere") return Picture{2, 1, {0, 1}, {}};
    if (file == "too large") return picture_of(2'000'000, {0}, make_plane);
    if (file == "no size") return picture_of(-1, {0}, make_plane);
    if (file == "greedy") make_plane(2 * reading.max_pixels + 1);
    return failure(ErrorCode::Internal, "no such order");
}

/// Replaces the decoding of colour pictures. Files that yield no picture have the same effect as in obey().
Result<ColourPicture> obey_in_colour(std::string_view file, const api::Reading& reading,
                                     const api::NewPlane& make_plane) {
    ColourPicture picture;
    picture.width = 2;
    picture.height = 1;
    if (file == "too large" || file == "no size") picture.width = file == "no size" ? -1 : 2'000'000;
    if (file == "greedy") make_plane(4 * reading.max_pixels + 1);
    if (file == "picture" || file == "opaque" || picture.width != 2) {
        picture.red = plane_of({0, 0.5F}, make_plane);
        picture.green = plane_of({0.25F, 1}, make_plane);
        picture.blue = plane_of({0.125F, 0}, make_plane);
        if (file == "picture") picture.alpha = plane_of({1, 0.75F}, make_plane);
        return picture;
    }
    if (file == "disorder") {
        picture.green = plane_of({0, 0}, make_plane);
        picture.red = plane_of({0, 0}, make_plane);
        picture.blue = plane_of({0, 0}, make_plane);
        return picture;
    }
    if (file == "elsewhere") {
        picture.red = plane_of({0, 0}, make_plane);
        picture.green = plane_of({0, 0}, make_plane);
        picture.blue = {0, 0};
        return picture;
    }
    return tl::unexpected(obey(file, reading, make_plane).error());
}

/// Replaces the reading of shapefiles.
Result<void> obey_as_map(std::string_view file, const api::ShapefileReading& reading, const api::TakeText& take) {
    if (file == "crash") std::abort();
    if (file == "refuse") return failure(ErrorCode::Unusable, "choose", "object");
    const std::string text = std::string(file) + ' ' + std::string(reading.object);
    while (take(text)) {
        if (file != "fill") return {};
    }
    return failure(ErrorCode::LimitExceeded, std::to_string(reading.max_bytes));
}

/// Replaces api::read_surface_with_pictures. The content of a file determines the reply.
Result<api::SurfaceContents> obey_as_surface(std::string_view file, const api::SurfaceHeader& header) {
    if (file == "crash") std::abort();
    if (file == "eat") eat_memory();
    if (file == "spin") spin();
    if (file == "refuse") return failure(ErrorCode::Unusable, "refused");
    api::SurfaceContents contents;
    contents.soup.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0.5}};
    contents.soup.triangles = {{0, 1, 2}};
    if (file == "colours") contents.soup.colours = {{1, 0, 0}, {0, 1, 0}, {0, 0, 0.5F}};
    if (file == "colours") contents.soup.texture = {{0, 0}, {1, 0}, {0, 0.25F}};
    if (file == "colours") contents.warnings = {"first", "second"};
    if (file == "few colours") contents.soup.colours = {{1, 0, 0}};
    if (file == "few texture") contents.soup.texture = {{1, 0}};
    if (file == "index") contents.soup.triangles = {{0, 1, 3}};
    if (file == "empty") contents.soup.triangles.clear();
    if (file.starts_with("material")) {
        contents.soup.materials = {{.first_texel = 1, .width = 2, .height = 1, .wrap = {Wrap::Clamp, Wrap::Mirror}}};
        contents.soup.material_of = {0};
        contents.soup.texels.resize(3, {1, 2, 3, 4});
        contents.picture_error = "broken";
    }
    if (file == "material: index") contents.soup.material_of = {1};
    if (file == "material: few indices") contents.soup.material_of = {};
    if (file == "material: texels") contents.soup.materials[0].first_texel = 2;
    if (file == "material: many texels") contents.soup.materials[0].width = 0xffffffff;
    if (file == "material: height") contents.soup.materials[0].height = 0;
    if (file == "material: wrap") contents.soup.materials[0].wrap[1] = static_cast<Wrap>(3);
    if (file == "material: factor") contents.soup.materials[0].factor[0] = std::numeric_limits<float>::quiet_NaN();
    if (file == "many") contents.soup.triangles.resize(static_cast<std::size_t>(100 * header.max_triangles));
    return contents;
}

/// Returns a launcher that forks a process. The process becomes the helper with the given decoder.
SupervisedProgram::Launch forking(Decoder decoder) {
    return [decoder = std::move(decoder)](UniqueFd orders) -> Result<ChildProgram> {
        const pid_t process = fork();
        if (process == 0) run_decoder_helper(std::move(orders), decoder);
        return ChildProgram(process);
    };
}

void ignore(const std::string&) {}

/// A DecoderSupervisor, and a client that sends orders to it.
class BoxOfTests {
public:
    BoxOfTests(const SupervisedProgram::Launch& launch, const DecoderClient::LimitsOf& limits,
               const SupervisedProgram::Report& report = ignore)
        : supervisor_(DecoderSupervisor::start(launch, report).value()),
          client_([this](const Order& order, const std::stop_token& stop) { return supervisor_->relay(order, stop); },
                  limits) {
        EXPECT_TRUE(supervisor_->wait_until_ready());
    }

    bool relay(const Order& order, const std::stop_token& stop) { return supervisor_->relay(order, stop); }

    Result<Picture> decode(std::string_view bytes, const api::Reading& reading, const std::stop_token& stop) {
        return client_.decode(bytes, reading, stop);
    }
    Result<ColourPicture> decode_colour(std::string_view bytes, const api::Reading& reading,
                                        const std::stop_token& stop) {
        return client_.decode_colour(bytes, reading, stop);
    }
    Result<std::string> read_shapefile(std::string_view bytes, const api::ShapefileReading& reading) {
        return client_.read_shapefile(bytes, reading, {});
    }
    Result<api::SurfaceContents> read_surface(std::string_view bytes, const api::SurfaceHeader& header) {
        return client_.read_surface(bytes, header, {});
    }
    std::uint64_t deaths() const { return client_.deaths(); }
    std::chrono::microseconds processor_time() const { return client_.processor_time(); }
    std::uint64_t restarts() const { return supervisor_->restarts(); }
    bool is_ready() const { return supervisor_->is_ready(); }
    const Confinement& confinement() const { return supervisor_->confinement(); }

private:
    const std::unique_ptr<DecoderSupervisor> supervisor_;
    DecoderClient client_;
};

DecoderLimits limits_of_tests(std::string_view, std::size_t) {
    return kLimits;
}

std::unique_ptr<BoxOfTests> make_box(const DecoderLimits& limits = kLimits) {
    return std::make_unique<BoxOfTests>(forking({obey, obey_in_colour, {}}),
                                        [limits](std::string_view, std::size_t) { return limits; });
}

/// Creates a supervisor that decodes real pictures.
std::unique_ptr<BoxOfTests> make_true_box() {
    return std::make_unique<BoxOfTests>(forking({api::decode_image, api::decode_colour_image, api::warm_up_decoder}),
                                        decoder_limits);
}

template <class AnyPicture>
void expect_unusable(const Result<AnyPicture>& result, const std::string& file) {
    ASSERT_FALSE(result) << file;
    EXPECT_EQ(result.error().code, ErrorCode::Unusable) << file;
    EXPECT_NE(result.error().message.find("could not be decoded"), std::string::npos) << result.error().message;
}

void expect_death_in_colour(BoxOfTests& supervisor, const std::string& file) {
    const auto deaths = supervisor.deaths();
    expect_unusable(supervisor.decode_colour(file, kMaxPixels, {}), file);
    EXPECT_EQ(supervisor.deaths(), deaths + 1) << file;
    EXPECT_TRUE(supervisor.decode_colour("picture", kMaxPixels, {})) << "after " << file;
}

void expect_death(BoxOfTests& supervisor, const std::string& file) {
    const auto deaths = supervisor.deaths();
    expect_unusable(supervisor.decode(file, kMaxPixels, {}), file);
    EXPECT_EQ(supervisor.deaths(), deaths + 1) << file;
    EXPECT_TRUE(supervisor.decode("picture", kMaxPixels, {})) << "after " << file;
    expect_death_in_colour(supervisor, file);
}

struct Process {
    pid_t id = 0;
    pid_t parent = 0;
    char state = 0;
};

/// Returns all processes, including zombies.
std::vector<Process> processes() {
    std::vector<Process> found;
    for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
        std::ifstream file(entry.path() / "stat");
        Process process;
        std::string name;
        if (file >> process.id >> name >> process.state >> process.parent) found.push_back(process);
    }
    return found;
}

std::vector<pid_t> children_of(pid_t parent) {
    std::vector<pid_t> children;
    for (const Process& process : processes()) {
        if (process.parent == parent) children.push_back(process.id);
    }
    return children;
}

bool is_running(pid_t id) {
    return std::ranges::any_of(processes(), [id](const Process& p) { return p.id == id && p.state != 'Z'; });
}

pid_t keeper() {
    return children_of(getpid()).at(0);
}

std::string name_of(pid_t process) {
    std::string name;
    std::ifstream("/proc/" + std::to_string(process) + "/comm") >> name;
    return name;
}

/// Finds the helper, if it has a child.
std::optional<pid_t> find_helper() {
    for (const pid_t keeper : children_of(getpid())) {
        for (const pid_t helper : children_of(keeper)) {
            if (name_of(helper) == "decoder-helper" && !children_of(helper).empty()) return helper;
        }
    }
    return std::nullopt;
}

/// Waits until the helper has a child, which it forks a moment after a restart, and returns the helper. Throws if there
/// is none, because callers pass the process to kill().
pid_t helper() {
    std::optional<pid_t> found;
    const auto waited = test::wait_until("a helper with a waiting child", [&] {
        found = find_helper();
        return found.has_value();
    });
    EXPECT_TRUE(waited);
    return found.value();
}

testing::AssertionResult wait_for_decoding(pid_t helper) {
    return test::wait_until("a decoding child beside the waiting one",
                            [helper] { return children_of(helper).size() >= 2; });
}

testing::AssertionResult wait_for_end_of_decoding() {
    return test::wait_until("the end of the decoding child", [] { return children_of(helper()).size() == 1; });
}

testing::AssertionResult wait_for_restart(const BoxOfTests& supervisor, unsigned restarts = 1) {
    return test::wait_until("a new helper", [&] { return supervisor.restarts() >= restarts && supervisor.is_ready(); });
}

/// Returns the value of a key in /proc/PID/status.
std::string status_of(pid_t process, const std::string& key) {
    std::ifstream file("/proc/" + std::to_string(process) + "/status");
    for (std::string line; std::getline(file, line);) {
        if (line.starts_with(key + ":\t")) return line.substr(key.size() + 2);
    }
    return {};
}

/// Returns the identifier of a namespace of a process; empty if it cannot be read.
std::string namespace_of(pid_t process, const std::string& kind) {
    std::error_code error;
    return std::filesystem::read_symlink("/proc/" + std::to_string(process) + "/ns/" + kind, error);
}

std::ptrdiff_t open_files(pid_t process) {
    const std::filesystem::directory_iterator files("/proc/" + std::to_string(process) + "/fd");
    return std::distance(begin(files), end(files));
}

std::string bytes_at(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

std::string bytes_of(const std::string& name) {
    return bytes_at(std::filesystem::path(CCDT_TEST_DATA) / "images" / name);
}

TEST(DecoderSupervisor, TransfersPicturesAndErrors) {
    const auto supervisor = make_box();
    ASSERT_TRUE(supervisor);
    const auto picture = supervisor->decode("picture", kMaxPixels, {});
    ASSERT_TRUE(picture) << picture.error().message;
    EXPECT_EQ(picture->width, 3);
    EXPECT_EQ(picture->height, 1);
    EXPECT_EQ(picture->luminance, (Plane{0, 0.5F, 1}));
    EXPECT_EQ(picture->alpha, (Plane{1, 0.25F, 0}));
    EXPECT_TRUE(supervisor->decode("opaque", kMaxPixels, {})->alpha.empty());

    const auto refused = supervisor->decode("limit", 1234, {});
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, ErrorCode::LimitExceeded);
    EXPECT_EQ(refused.error().message, "1234");
    EXPECT_EQ(supervisor->decode("reduce", 1234, {}).error().message, "1");
    EXPECT_EQ(supervisor->decode("reduce", {1234, 2}, {}).error().message, "2");
    EXPECT_EQ(supervisor->deaths(), 0U);
}

TEST(DecoderSupervisor, TransfersColourPictures) {
    const auto supervisor = make_box();
    ASSERT_TRUE(supervisor);
    const auto picture = supervisor->decode_colour("picture", kMaxPixels, {});
    ASSERT_TRUE(picture) << picture.error().message;
    EXPECT_EQ(picture->width, 2);
    EXPECT_EQ(picture->height, 1);
    EXPECT_EQ(picture->red, (Plane{0, 0.5F}));
    EXPECT_EQ(picture->green, (Plane{0.25F, 1}));
    EXPECT_EQ(picture->blue, (Plane{0.125F, 0}));
    EXPECT_EQ(picture->alpha, (Plane{1, 0.75F}));
    EXPECT_TRUE(supervisor->decode_colour("opaque", kMaxPixels, {})->alpha.empty());
    EXPECT_EQ(supervisor->decode_colour("limit", 1234, {}).error().message, "1234");
    EXPECT_EQ(supervisor->decode_colour("reduce", {1234, 3}, {}).error().message, "3");
    EXPECT_EQ(supervisor->deaths(), 0U);
}

TEST(DecoderSupervisor, DecodesPhotographsIdentically) {
    const auto supervisor = make_true_box();
    for (const auto* name : {"camera.png", "chelsea.png", "astronaut.png"}) {
        const std::string file = bytes_of(name);
        const auto expected = api::decode_image(file, kMaxPixels);
        const auto picture = supervisor->decode(file, kMaxPixels, {});
        ASSERT_TRUE(picture && expected) << name;
        EXPECT_EQ(picture->width, expected->width);
        EXPECT_TRUE(picture->luminance == expected->luminance) << name;
        EXPECT_TRUE(picture->alpha == expected->alpha) << name;

        const auto colours = api::decode_colour_image(file, kMaxPixels);
        const auto decoded = supervisor->decode_colour(file, kMaxPixels, {});
        ASSERT_TRUE(decoded && colours) << name;
        EXPECT_EQ(decoded->height, colours->height);
        EXPECT_TRUE(decoded->red == colours->red && decoded->green == colours->green) << name;
        EXPECT_TRUE(decoded->blue == colours->blue && decoded->alpha == colours->alpha) << name;
    }
    EXPECT_EQ(supervisor->decode("no image", kMaxPixels, {}).error().code, ErrorCode::Unsupported);
    EXPECT_EQ(supervisor->decode("", kMaxPixels, {}).error().code, ErrorCode::Malformed);
}

/// Checks that two decoders yield the same picture or the same error.
void expect_same(const Result<Picture>& decoded, const Result<Picture>& expected, const std::string& name) {
    ASSERT_EQ(decoded.has_value(), expected.has_value()) << name;
    if (!decoded) {
        EXPECT_EQ(decoded.error().code, expected.error().code) << name;
        EXPECT_EQ(decoded.error().message, expected.error().message) << name;
        return;
    }
    EXPECT_EQ(decoded->width, expected->width) << name;
    EXPECT_TRUE(decoded->luminance == expected->luminance) << name;
    EXPECT_TRUE(decoded->alpha == expected->alpha) << name;
}

TEST(DecoderSupervisor, DecodesWholeAndTruncatedFilesIdentically) {
    const auto supervisor = make_true_box();
    int files = 0;
    for (const auto& entry : std::filesystem::directory_iterator(CCDT_API_TEST_DATA)) {
        const std::string file = bytes_at(entry.path());
        for (const std::size_t size : {file.size(), file.size() / 2, std::size_t{40}, std::size_t{12}}) {
            const auto part = file.substr(0, size);
            const auto name = entry.path().filename().string() + " of " + std::to_string(size);
            expect_same(supervisor->decode(part, kMaxPixels, {}), api::decode_image(part, kMaxPixels), name);
        }
        ++files;
    }
    EXPECT_GT(files, 30);
    EXPECT_EQ(supervisor->deaths(), 0U);
}

TEST(DecoderSupervisor, ReportsTheProgressOfADecoder) {
    const auto supervisor = make_box();
    std::vector<double> shares;
    api::Reading reading(kMaxPixels);
    reading.progress = [&](double share) { shares.push_back(share); };
    EXPECT_TRUE(supervisor->decode("steps", reading, {}));
    EXPECT_EQ(shares, (std::vector{0.25, 0.5, 0.75}));
}

TEST(DecoderSupervisor, EndsADecoderThatReportsTooOften) {
    const auto supervisor = make_box();
    expect_death(*supervisor, "flood");
}

TEST(DecoderSupervisor, SurvivesADecoderThatFails) {
    const auto supervisor = make_box();
    ASSERT_TRUE(supervisor);
    for (const auto* file : {"crash", "abort", "throw", "exit"}) expect_death(*supervisor, file);
}

TEST(DecoderSupervisor, RefusesInvalidOutputOfTheDecoder) {
    const auto supervisor = make_box();
    ASSERT_TRUE(supervisor);
    for (const auto* file : {"elsewhere", "too large", "no size", "greedy"}) {
        expect_death(*supervisor, file);
    }
    expect_death_in_colour(*supervisor, "disorder");
}

TEST(DecoderSupervisor, KillsADecoderThatHangs) {
    const auto supervisor = make_box({kLimits.memory, std::chrono::seconds(1)});
    ASSERT_TRUE(supervisor);
    const auto result = supervisor->decode("spin", kMaxPixels, {});
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().code, ErrorCode::Unusable);
    EXPECT_NE(result.error().message.find("too long"), std::string::npos);
    EXPECT_EQ(supervisor->deaths(), 1U);
    EXPECT_TRUE(wait_for_end_of_decoding());
}

TEST(DecoderSupervisor, KillsADecoderThatExceedsItsMemory) {
    if (!Sandbox::kIsWhole) GTEST_SKIP() << "the memory of sanitizers cannot be limited";
    const auto supervisor = make_box();
    ASSERT_TRUE(supervisor);
    expect_death(*supervisor, "eat");
}

TEST(DecoderSupervisor, ReportsLimitsOnTheServerAsInternalErrors) {
    if (!Sandbox::kIsWhole) GTEST_SKIP() << "sanitizers reserve terabytes of address space";
    for (const std::size_t remaining : {std::size_t{8} << 20, std::size_t{40} << 20}) {
        const auto limited = [&](UniqueFd orders) -> Result<ChildProgram> {
            const pid_t process = fork();
            if (process != 0) return ChildProgram(process);
            std::size_t pages = 0;
            std::ifstream("/proc/self/statm") >> pages;
            const rlimit space{pages * 4096 + remaining, pages * 4096 + remaining};
            setrlimit(RLIMIT_AS, &space);
            run_decoder_helper(std::move(orders), {obey, obey_in_colour, {}});
        };
        BoxOfTests supervisor(limited, limits_of_tests);
        const auto result = supervisor.decode_colour("picture", kMaxPixels, {});
        ASSERT_FALSE(result);
        EXPECT_EQ(result.error().code, ErrorCode::Internal);
        EXPECT_EQ(result.error().message, "cannot start a decoder: Cannot allocate memory");
    }
}

TEST(DecoderSupervisor, DeniesSystemCallsToTheDecoder) {
    const auto supervisor = make_box();
    ASSERT_TRUE(supervisor);
    if (!supervisor->confinement().has(Layer::Calls)) GTEST_SKIP() << "system calls are not filtered here";
    for (const auto* file : {"open", "socket", "fork", "exec", "kill", "write"}) {
        const auto result = supervisor->decode(file, kMaxPixels, {});
        ASSERT_FALSE(result) << file;
        EXPECT_EQ(result.error().message, "refused") << file;
    }
}

TEST(DecoderSupervisor, StopsOnRequest) {
    const auto supervisor = make_box();
    ASSERT_TRUE(supervisor);
    std::stop_source stop;
    const std::jthread asking([&] {
        // One child is decoding when there is another child, which waits for the next order.
        EXPECT_TRUE(wait_for_decoding(helper()));
        stop.request_stop();
    });
    const auto result = supervisor->decode("spin", kMaxPixels, stop.get_token());
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().code, ErrorCode::Stopped);
    EXPECT_EQ(supervisor->decode("picture", kMaxPixels, stop.get_token()).error().code, ErrorCode::Stopped);
    EXPECT_EQ(supervisor->deaths(), 0U);
    EXPECT_TRUE(wait_for_end_of_decoding());
}

TEST(DecoderSupervisor, ServesManyThreads) {
    const auto supervisor = make_box();
    ASSERT_TRUE(supervisor);
    std::vector<std::jthread> threads;
    for (int i = 0; i < 8; ++i) {
        threads.emplace_back([&supervisor, i] {
            for (int round = 0; round < 5; ++round) {
                const bool crashes = (i + round) % 2 == 0;
                EXPECT_EQ(supervisor->decode(crashes ? "crash" : "picture", kMaxPixels, {}).has_value(), !crashes);
            }
        });
    }
    threads.clear();
    EXPECT_EQ(supervisor->deaths(), 20U);
}

TEST(DecoderSupervisor, LeaksNeitherProcessesNorDescriptors) {
    const auto supervisor = make_box();
    ASSERT_TRUE(supervisor);
    ASSERT_TRUE(supervisor->decode("picture", kMaxPixels, {}));
    const auto ours = open_files(getpid());
    const auto theirs = open_files(helper());
    for (int i = 0; i < 20; ++i) {
        for (const auto* file : {"picture", "crash", "abort", "limit"}) {
            static_cast<void>(supervisor->decode(file, kMaxPixels, {}));
        }
    }
    EXPECT_EQ(open_files(getpid()), ours);
    constexpr std::ptrdiff_t kInPassing = 3;  // descriptors for a child that starts or ends
    EXPECT_TRUE(wait_for_end_of_decoding());
    EXPECT_LE(open_files(helper()), theirs + kInPassing);
}

TEST(DecoderSupervisor, ReplacesAKilledHelper) {
    const auto supervisor = make_box();
    ASSERT_TRUE(supervisor);
    for (unsigned round = 1; round <= 3; ++round) {
        kill(helper(), SIGKILL);
        EXPECT_TRUE(wait_for_restart(*supervisor, round));
        const auto result = supervisor->decode("picture", kMaxPixels, {});
        EXPECT_TRUE(result) << result.error().message;
    }
    EXPECT_EQ(supervisor->restarts(), 3U);
    EXPECT_EQ(supervisor->deaths(), 0U);
    EXPECT_EQ(children_of(getpid()).size(), 1U);
}

TEST(DecoderSupervisor, RetriesPicturesAfterTheDeathOfAHelper) {
    const auto supervisor = make_box();
    ASSERT_TRUE(supervisor);
    std::vector<std::jthread> threads;
    std::atomic<bool> done = false;
    for (int i = 0; i < 4; ++i) {
        threads.emplace_back([&] {
            while (!done) {
                const auto result = supervisor->decode("picture", kMaxPixels, {});
                EXPECT_TRUE(result) << result.error().message;
            }
        });
    }
    for (unsigned round = 1; round <= 4; ++round) {
        // Kills the helper and its parent alternately.
        kill(round % 2 == 0 ? helper() : keeper(), SIGKILL);
        EXPECT_TRUE(wait_for_restart(*supervisor, round));
    }
    done = true;
    threads.clear();
    EXPECT_EQ(supervisor->restarts(), 4U);
}

TEST(DecoderSupervisor, ReportsHowAHelperEnded) {
    std::mutex mutex;
    std::string told;
    const auto supervisor = std::make_unique<BoxOfTests>(forking({obey, obey_in_colour, {}}), limits_of_tests,
                                                         [&](const std::string& message) {
                                                             const std::lock_guard lock(mutex);
                                                             told += message;
                                                         });
    kill(helper(), SIGKILL);
    EXPECT_TRUE(wait_for_restart(*supervisor));
    const std::lock_guard lock(mutex);
    EXPECT_EQ(told, "the decoder was killed by signal 9 (Killed), and is started again");
}

/// Counts the processes with the highest oom_score_adj, which the kernel kills first if memory runs out.
std::ptrdiff_t volunteers(const std::vector<pid_t>& processes) {
    return std::ranges::count_if(processes, [](pid_t process) {
        int score = 0;
        return std::ifstream("/proc/" + std::to_string(process) + "/oom_score_adj") >> score && score == 1000;
    });
}

/// Waits for a decoding child other than `previous`, and sends a signal to it.
/// @returns  the child
pid_t end_decoding(pid_t helper, int signal, pid_t previous = 0) {
    pid_t decoding = 0;
    EXPECT_TRUE(test::wait_until("a child that decodes", [&] {
        const auto children = children_of(helper);
        const auto found =
            std::ranges::find_if(children, [&](pid_t child) { return child != previous && volunteers({child}) == 1; });
        if (found != children.end()) decoding = *found;
        return decoding != 0;
    }));
    kill(decoding, signal);
    return decoding;
}

TEST(DecoderSupervisor, RepeatsAKilledDecodingOnce) {
    const auto supervisor = make_box();
    const std::jthread killing(
        [process = helper()] { end_decoding(process, SIGKILL, end_decoding(process, SIGKILL)); });
    const auto result = supervisor->decode("spin", kMaxPixels, {});
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().code, ErrorCode::Unavailable);
    EXPECT_EQ(result.error().message, "the process that decoded the image was killed twice");
    EXPECT_EQ(supervisor->deaths(), 2U);
    EXPECT_TRUE(supervisor->decode("picture", kMaxPixels, {}));
}

TEST(DecoderSupervisor, DoesNotRepeatACrashedDecoding) {
    const auto supervisor = make_box();
    const std::jthread killing([process = helper()] { end_decoding(process, SIGSEGV); });
    expect_unusable(supervisor->decode("spin", kMaxPixels, {}), "spin");
    EXPECT_EQ(supervisor->deaths(), 1U);
}

TEST(DecoderSupervisor, CountsTheProcessorTimeOfDecoders) {
    const auto supervisor = make_box({kLimits.memory, std::chrono::seconds(1)});
    EXPECT_TRUE(supervisor->decode("picture", kMaxPixels, {}));
    const auto little = supervisor->processor_time();
    EXPECT_GT(little.count(), 0);
    EXPECT_FALSE(supervisor->decode("spin", kMaxPixels, {}));
    EXPECT_GE(supervisor->processor_time(), little + std::chrono::milliseconds(300));
}

TEST(DecoderSupervisor, EndsDecodersWithTheirHelper) {
    const auto supervisor = make_box();
    ASSERT_TRUE(supervisor);
    std::stop_source stop;
    const std::jthread asking([&] { static_cast<void>(supervisor->decode("spin", kMaxPixels, stop.get_token())); });
    const pid_t first = helper();
    EXPECT_TRUE(wait_for_decoding(first));
    const auto children = children_of(first);
    kill(first, SIGKILL);
    for (const pid_t child : children) {
        EXPECT_TRUE(test::wait_until("the end of a child", [child] { return !is_running(child); }));
    }
    stop.request_stop();
}

/// Returns a launcher that starts a helper at the first call, and fails at later calls.
SupervisedProgram::Launch forking_once(std::atomic<int>& attempts) {
    return [&attempts, launch = forking({obey, obey_in_colour, {}})](UniqueFd orders) -> Result<ChildProgram> {
        if (attempts++ == 0) return launch(std::move(orders));
        return failure(ErrorCode::Internal, "no such program");
    };
}

TEST(DecoderSupervisor, ReportsThatThereIsNoHelper) {
    std::atomic<int> attempts = 0;
    const auto supervisor = std::make_unique<BoxOfTests>(forking_once(attempts), limits_of_tests);
    EXPECT_TRUE(supervisor->is_ready());
    kill(helper(), SIGKILL);
    EXPECT_TRUE(test::wait_until("three attempts to start a helper", [&] { return attempts >= 3; }));
    EXPECT_FALSE(supervisor->is_ready());
    const auto result = supervisor->decode("picture", kMaxPixels, {});
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().code, ErrorCode::Unavailable);
    std::stop_source stop;
    stop.request_stop();
    EXPECT_EQ(supervisor->decode("picture", kMaxPixels, stop.get_token()).error().code, ErrorCode::Stopped);
    EXPECT_EQ(supervisor->restarts(), 1U);
    EXPECT_TRUE(children_of(getpid()).empty());
}

TEST(DecoderSupervisor, FailsOrdersWithoutAHelper) {
    std::atomic<int> attempts = 0;
    const auto supervisor = DecoderSupervisor::start(forking_once(attempts), ignore).value();
    ASSERT_TRUE(supervisor->wait_until_ready());
    kill(helper(), SIGKILL);
    EXPECT_TRUE(test::wait_until("the end of the helper to be noticed", [&] { return !supervisor->is_ready(); }));
    std::array<int, 2> ends{};
    ASSERT_EQ(socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends.data()), 0);
    const UniqueFd ours(ends[0]);
    Order order;
    order.text.patience_ms = 1;
    order.outcome = UniqueFd(ends[1]);
    EXPECT_FALSE(supervisor->relay(order, {}));
    Outcome told;
    ASSERT_EQ(recv(ours.get(), &told, sizeof(told), MSG_DONTWAIT), static_cast<ssize_t>(sizeof(told)));
    EXPECT_EQ(told.no_helper, 1);
}

TEST(DecoderSupervisor, ReadsShapefiles) {
    BoxOfTests supervisor(forking({obey, obey_in_colour, {}, obey_as_map}), limits_of_tests);
    EXPECT_EQ(supervisor.read_shapefile("map", {"name", 8}).value(), "map name");
    EXPECT_EQ(supervisor.read_shapefile("map", {"", 8}).value(), "map ");
    const auto full = supervisor.read_shapefile("fill", {"", 99});
    EXPECT_EQ(full.error().code, ErrorCode::LimitExceeded);
    EXPECT_EQ(full.error().message, "99");
    EXPECT_EQ(supervisor.read_shapefile("refuse", {"", 99}).error().field, "object");
    EXPECT_EQ(supervisor.read_shapefile("map", {std::string(2000, 'a'), 99}).error().code, ErrorCode::Malformed);
    EXPECT_EQ(supervisor.deaths(), 0U);
    const auto crashed = supervisor.read_shapefile("crash", {"", 99});
    EXPECT_EQ(crashed.error().code, ErrorCode::Unusable);
    EXPECT_EQ(crashed.error().message, "the shapefile could not be decoded: it made the decoder fail");
    EXPECT_EQ(supervisor.deaths(), 1U);
}

constexpr api::SurfaceHeader kMeshes{api::SurfaceFormat::Off, 4, 12, 1, std::uint64_t{64} << 20};

TEST(DecoderSupervisor, TransfersMeshes) {
    BoxOfTests supervisor(forking({obey, obey_in_colour, {}, {}, obey_as_surface}), limits_of_tests);
    const auto plain = supervisor.read_surface("plain", kMeshes);
    ASSERT_TRUE(plain) << plain.error().message;
    EXPECT_EQ(plain->soup.vertices, (std::vector<Point3>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0.5}}));
    EXPECT_EQ(plain->soup.triangles, (std::vector<std::array<std::uint32_t, 3>>{{0, 1, 2}}));
    EXPECT_TRUE(plain->soup.colours.empty());
    EXPECT_TRUE(plain->soup.texture.empty());
    EXPECT_TRUE(plain->warnings.empty());
    const auto coloured = supervisor.read_surface("colours", kMeshes);
    ASSERT_TRUE(coloured) << coloured.error().message;
    EXPECT_EQ(coloured->soup.vertices, plain->soup.vertices);
    EXPECT_EQ(coloured->soup.triangles, plain->soup.triangles);
    EXPECT_EQ(coloured->soup.colours, (std::vector<std::array<float, 3>>{{1, 0, 0}, {0, 1, 0}, {0, 0, 0.5F}}));
    EXPECT_EQ(coloured->soup.texture, (std::vector<std::array<float, 2>>{{0, 0}, {1, 0}, {0, 0.25F}}));
    EXPECT_EQ(coloured->warnings, (std::vector<std::string>{"first", "second"}));
    const auto pictured = supervisor.read_surface("material", kMeshes);
    ASSERT_TRUE(pictured) << pictured.error().message;
    EXPECT_EQ(pictured->soup.materials.at(0).wrap[1], Wrap::Mirror);
    EXPECT_EQ(pictured->soup.material_of, std::vector<std::uint32_t>{0});
    EXPECT_EQ(pictured->soup.texels, (std::vector<std::array<std::uint8_t, 4>>(3, {1, 2, 3, 4})));
    EXPECT_EQ(pictured->picture_error, "broken");
    EXPECT_EQ(supervisor.read_surface("refuse", kMeshes).error().message, "refused");
    EXPECT_EQ(supervisor.deaths(), 0U);
}

TEST(DecoderSupervisor, RejectsInvalidMeshes) {
    BoxOfTests supervisor(forking({obey, obey_in_colour, {}, {}, obey_as_surface}), limits_of_tests);
    std::uint64_t deaths = 0;
    for (const char* file : {"few colours", "few texture", "index", "empty", "many", "material: index",
                             "material: few indices", "material: texels", "material: many texels", "material: height",
                             "material: wrap", "material: factor", "crash", "eat"}) {
        if (!Sandbox::kIsWhole && file == std::string_view("eat")) continue;
        const auto contents = supervisor.read_surface(file, kMeshes);
        ASSERT_FALSE(contents) << file;
        EXPECT_EQ(contents.error().code, ErrorCode::Unusable) << file;
        EXPECT_EQ(contents.error().message, "the mesh could not be decoded: it made the decoder fail") << file;
        EXPECT_EQ(supervisor.deaths(), ++deaths) << file;
    }
    EXPECT_TRUE(supervisor.read_surface("plain", kMeshes));
}

/// Reads a mesh file. Returns the reason if the file is refused; otherwise an empty text.
std::string describe_reading(BoxOfTests& supervisor, std::string_view bytes, std::size_t max_faces) {
    const auto format = api::recognise_surface(bytes);
    if (!format) return "not recognised";
    const auto contents =
        api::read_surface_header(bytes, *format, max_faces, kMaxPixels).and_then([&](const auto& header) {
            return supervisor.read_surface(bytes, header);
        });
    return contents ? contents->picture_error : contents.error().message;
}

TEST(DecoderSupervisor, ReadsMeshesInTheSandbox) {
    BoxOfTests supervisor(
        forking(
            {api::decode_image, api::decode_colour_image, api::warm_up_decoder, {}, api::read_surface_with_pictures}),
        decoder_limits);
    const std::string stl = binary_stl(std::vector<float>(9 * 100'000, 0.5F));
    const std::string files[] = {stl,
                                 "OFF 3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
                                 "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
                                 glb(square_gltf(), square_buffer()),
                                 textured_glb(bytes_at(std::filesystem::path(CCDT_API_TEST_DATA) / "grey.jpg")),
                                 "mtllib /etc/passwd\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3 4\n"};
    for (const std::string& file : files)
        EXPECT_EQ(describe_reading(supervisor, file, 100'000), "") << file.substr(0, 20);
    EXPECT_EQ(supervisor.deaths(), 0U);
}

/// Returns the paths of the mesh files of a folder.
std::vector<std::filesystem::path> mesh_files(const std::filesystem::path& folder) {
    constexpr auto kSuffixes = std::to_array<std::string_view>({".stl", ".obj", ".ply", ".off", ".gltf", ".glb"});
    std::vector<std::filesystem::path> files;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
        std::string suffix = entry.path().extension();
        std::ranges::transform(suffix, suffix.begin(), [](unsigned char c) { return std::tolower(c); });
        if (entry.is_regular_file() && std::ranges::find(kSuffixes, suffix) != kSuffixes.end())
            files.push_back(entry.path());
    }
    return files;
}

TEST(DecoderSupervisor, ReadsOrRefusesTheModelsOfAssimp) {
    const std::filesystem::path folder = "/usr/share/assimp/models";
    if (!std::filesystem::exists(folder)) GTEST_SKIP() << "the package assimp-testmodels is not installed";
    BoxOfTests supervisor(
        forking(
            {api::decode_image, api::decode_colour_image, api::warm_up_decoder, {}, api::read_surface_with_pictures}),
        decoder_limits);
    // Reasons for which files of the package may be refused.
    constexpr auto kReasons = std::to_array<std::string_view>(
        {"not recognised", "its data is in another file", "only version 2 is supported", "only glTF 2 is supported",
         "it has no triangles", "is incomplete, because the file ends", "do not follow the keyword",
         "it ends before face", "refers to no vertex", "is not finite", "is not a number", "a list of invalid size",
         "TEXCOORD_", "is in another file", "not valid JSON"});
    std::size_t read = 0;
    for (const auto& path : mesh_files(folder)) {
        const std::string reason = describe_reading(supervisor, bytes_at(path), 1'000'000);
        read += reason.empty() ? 1 : 0;
        EXPECT_TRUE(reason.empty() ||
                    std::ranges::any_of(
                        kReasons, [&](std::string_view known) { return reason.find(known) != std::string::npos; }))
            << path << ": " << reason;
    }
    EXPECT_GE(read, 35U);
    EXPECT_EQ(supervisor.deaths(), 0U);
}

/// Returns a client whose orders are accepted and never executed.
/// @param kept   receives the sockets of the orders
/// @param begun  whether a child reports that it has begun
DecoderClient client_without_replies(std::vector<UniqueFd>& kept, bool begun) {
    return DecoderClient(
        [&kept, begun](const Order& order, const std::stop_token&) {
            kept.emplace_back(dup(order.outcome.get()));
            const Outcome report{.begun = 1};
            if (begun) send(kept.back().get(), &report, sizeof(report), MSG_NOSIGNAL);
            return true;
        },
        [](std::string_view, std::size_t) {
            return DecoderLimits{kLimits.memory, std::chrono::seconds(0)};
        },
        {.for_child = std::chrono::milliseconds(20)});
}

TEST(DecoderClient, DoesNotBlameAPictureForAMachineThatIsTooBusy) {
    for (const bool begun : {false, true}) {
        std::vector<UniqueFd> kept;
        auto client = client_without_replies(kept, begun);
        const auto result = client.decode("picture", kMaxPixels, {});
        ASSERT_FALSE(result);
        EXPECT_EQ(result.error().code, ErrorCode::Unavailable);
        EXPECT_EQ(result.error().message, "the server was too busy to decode the image");
        EXPECT_EQ(client.deaths(), 0U);
        EXPECT_EQ(kept.size(), 1U);
    }
}

TEST(DecoderClient, WaitsLongerForAChildThanForAHelper) {
    const auto supervisor = make_box();
    ASSERT_TRUE(supervisor);
    std::jthread busy;
    DecoderClient client(
        [&](const Order& order, const std::stop_token&) {
            Order kept{order.text, UniqueFd(dup(order.file.get())), UniqueFd(dup(order.reply.get())),
                       UniqueFd(dup(order.outcome.get()))};
            busy = std::jthread([&supervisor, kept = std::move(kept)] {
                std::this_thread::sleep_for(std::chrono::milliseconds(100));
                supervisor->relay(kept, {});
            });
            return true;
        },
        limits_of_tests, {.for_helper = std::chrono::milliseconds(20)});
    EXPECT_TRUE(client.decode("picture", kMaxPixels, {}));
}

TEST(DecoderClient, WaitsForAHelperOnlyOnce) {
    std::vector<std::int64_t> patience;
    DecoderClient client(
        [&](const Order& order, const std::stop_token&) {
            patience.push_back(order.text.patience_ms);
            const Outcome none{.no_helper = 1};
            if (patience.size() == 2) send(order.outcome.get(), &none, sizeof(none), MSG_NOSIGNAL);
            return true;  // the first order is lost, as if its helper had ended
        },
        limits_of_tests);
    const auto result = client.decode("picture", kMaxPixels, {});
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().code, ErrorCode::Unavailable);
    ASSERT_EQ(patience.size(), 2U) << "the order must not be repeated after there was no helper in time";
    EXPECT_EQ(patience.front(), 5000);
    EXPECT_LE(patience.back(), patience.front());
}

TEST(DecoderSupervisor, ReportsWhyItDoesNotStart) {
    const auto ends_at_once = [](UniqueFd) -> Result<ChildProgram> {
        const pid_t process = fork();
        if (process == 0) _exit(3);
        return ChildProgram(process);
    };
    const auto supervisor = DecoderSupervisor::start(ends_at_once, ignore);
    ASSERT_TRUE(supervisor);
    const auto ready = (*supervisor)->wait_until_ready();
    ASSERT_FALSE(ready);
    EXPECT_EQ(ready.error().message, "cannot start the decoder: it exited with 3");
    EXPECT_FALSE((*supervisor)->is_ready());
    EXPECT_EQ((*supervisor)->restarts(), 0U);
    EXPECT_TRUE(children_of(getpid()).empty());
}

TEST(DecoderSupervisor, RestartsAHelperThatIsKilledWhileItStarts) {
    std::atomic<int> starts = 0;
    const auto killed_at_first = [&, launch =
                                         forking({obey, obey_in_colour, {}})](UniqueFd orders) -> Result<ChildProgram> {
        if (++starts > 2) return launch(std::move(orders));
        const pid_t process = fork();
        if (process == 0) std::raise(SIGKILL);
        return ChildProgram(process);
    };
    BoxOfTests supervisor(killed_at_first, limits_of_tests);
    EXPECT_TRUE(supervisor.decode("picture", kMaxPixels, {}));
    EXPECT_EQ(starts, 3);
    EXPECT_EQ(supervisor.restarts(), 2U);
}

TEST(DecoderSupervisor, QueuesOrdersUntilItIsReady) {
    std::array<int, 2> ends{};
    ASSERT_EQ(pipe2(ends.data(), O_CLOEXEC), 0);
    const UniqueFd waits(ends[0]);
    UniqueFd lets_go(ends[1]);
    const auto start_late = [&](UniqueFd orders) -> Result<ChildProgram> {
        const pid_t process = fork();
        if (process == 0) {
            lets_go.reset();
            char none = 0;
            static_cast<void>(!read(waits.get(), &none, 1));
            run_decoder_helper(std::move(orders), {obey, obey_in_colour, [] {}});
        }
        return ChildProgram(process);
    };
    const auto supervisor = DecoderSupervisor::start(start_late, ignore).value();
    EXPECT_TRUE(supervisor->is_ready());
    DecoderClient client(
        [&](const Order& order, const std::stop_token& stop) { return supervisor->relay(order, stop); },
        limits_of_tests);
    auto picture = std::async(std::launch::async, [&] { return client.decode("picture", kMaxPixels, {}); });
    EXPECT_EQ(picture.wait_for(std::chrono::seconds(0)), std::future_status::timeout);
    lets_go.reset();
    ASSERT_TRUE(test::wait_for("a picture", picture));
    EXPECT_TRUE(picture.get());
    EXPECT_TRUE(supervisor->wait_until_ready());
    EXPECT_EQ(supervisor->restarts(), 0U);
}

TEST(DecoderSupervisor, KillsItsProcessesOnDestruction) {
    auto supervisor = make_box();
    ASSERT_TRUE(supervisor);
    const pid_t gone[] = {keeper(), helper()};
    supervisor.reset();
    for (const pid_t process : gone) EXPECT_FALSE(is_running(process));
    EXPECT_TRUE(children_of(getpid()).empty());
}

TEST(DecoderSupervisor, IgnoresSignalsToItsGroup) {
    const auto supervisor = make_box();
    ASSERT_TRUE(supervisor);
    for (const int number : {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGUSR1, SIGUSR2, SIGALRM}) {
        kill(keeper(), number);
        kill(helper(), number);
    }
    EXPECT_TRUE(supervisor->decode("picture", kMaxPixels, {}));
    EXPECT_EQ(supervisor->restarts(), 0U);
}

TEST(DecoderSupervisor, MakesTheDecoderTheFirstVictimOfTheOomKiller) {
    const auto supervisor = make_box();
    ASSERT_TRUE(supervisor);
    const pid_t process = helper();
    ASSERT_EQ(volunteers({keeper(), process}), 0);
    std::stop_source stop;
    const std::jthread asking([&] { static_cast<void>(supervisor->decode("spin", kMaxPixels, stop.get_token())); });
    EXPECT_TRUE(wait_for_decoding(process));
    EXPECT_TRUE(test::wait_until("the decoder to raise its oom_score_adj",
                                 [&] { return volunteers(children_of(process)) > 0; }));
    EXPECT_EQ(volunteers(children_of(process)), 1) << "the waiting child must not be one of them";
    EXPECT_EQ(volunteers({keeper(), process}), 0);
    stop.request_stop();
}

TEST(DecoderSupervisor, IsConfinedAsReported) {
    const auto supervisor = make_box();
    ASSERT_TRUE(supervisor);
    const Confinement& confinement = supervisor->confinement();
    const pid_t process = helper();
    // Checks the helper, the child that decodes and the child that waits.
    std::stop_source stop;
    const std::jthread asking([&] { static_cast<void>(supervisor->decode("spin", kMaxPixels, stop.get_token())); });
    EXPECT_TRUE(wait_for_decoding(process));
    auto decoding = children_of(process);
    decoding.push_back(process);
    const std::string user = std::to_string(confinement.user);
    for (const pid_t one : decoding) {
        EXPECT_TRUE(status_of(one, "Uid").starts_with(user + "\t" + user + "\t" + user));
        EXPECT_EQ(status_of(one, "NoNewPrivs"), "1");
        if (confinement.has(Layer::User)) {
            EXPECT_NE(user, "0");
        }
        if (confinement.has(Layer::Capabilities)) {
            for (const char* set : {"CapInh", "CapPrm", "CapEff", "CapAmb"})
                EXPECT_EQ(status_of(one, set), "0000000000000000") << set;
        }
        const bool was_root = getuid() == 0 && user != "0";
        if (was_root) {
            EXPECT_EQ(status_of(one, "Groups").find_first_not_of(' '), std::string::npos);
        }
        if (namespace_of(one, "net").empty()) continue;
        const std::pair<Layer, const char*> namespaces[] = {{Layer::Network, "net"},
                                                            {Layer::Mounts, "mnt"},
                                                            {Layer::Processes, "pid"},
                                                            {Layer::Ipc, "ipc"},
                                                            {Layer::HostName, "uts"}};
        for (const auto& [layer, kind] : namespaces)
            EXPECT_EQ(namespace_of(one, kind) != namespace_of(getpid(), kind), confinement.has(layer)) << kind;
        EXPECT_EQ(std::filesystem::is_empty("/proc/" + std::to_string(one) + "/root"), confinement.has(Layer::Root));
    }
    stop.request_stop();
}

}  // namespace
}  // namespace ccdt::server
