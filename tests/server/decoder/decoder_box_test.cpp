#include "server/decoder/decoder_box.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <initializer_list>
#include <iterator>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include <fcntl.h>
#include <sys/socket.h>
#include <unistd.h>

#include "api/image/decoder_warm_up.h"

namespace ccdt::server {
namespace {

constexpr std::size_t kMaxPixels = 1'000'000;
constexpr DecoderLimits kLimits{std::size_t{64} << 20, std::chrono::seconds(60)};

/// The outcome of a system call, as an error for a picture cannot hold it.
Result<Picture> outcome(long returned) {
    return failure(ErrorCode::Unsupported, returned < 0 ? "refused" : "done");
}

[[noreturn]] void spin() {
    for (volatile unsigned turns = 0;;) turns = turns + 1;
}

/// Vectors of a page each, so that nothing is left when it ends.
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

/// A decoder that does what the file says.
Result<Picture> obey(std::string_view file, std::size_t max_pixels, const api::NewPlane& make_plane) {
    if (file == "picture") {
        Picture picture = picture_of(3, {0, 0.5F, 1}, make_plane);
        picture.alpha = plane_of({1, 0.25F, 0}, make_plane);
        return picture;
    }
    if (file == "opaque") return picture_of(2, {0.125F, 1}, make_plane);
    if (file == "limit") return failure(ErrorCode::LimitExceeded, std::to_string(max_pixels));
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
    if (file == "greedy") make_plane(2 * max_pixels + 1);
    return failure(ErrorCode::Internal, "no such order");
}

/// The same; what makes no picture does so in colour as in grey.
Result<ColourPicture> obey_in_colour(std::string_view file, std::size_t max_pixels, const api::NewPlane& make_plane) {
    ColourPicture picture;
    picture.width = 2;
    picture.height = 1;
    if (file == "too large" || file == "no size") picture.width = file == "no size" ? -1 : 2'000'000;
    if (file == "greedy") make_plane(4 * max_pixels + 1);
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
    return tl::unexpected(obey(file, max_pixels, make_plane).error());
}

std::unique_ptr<DecoderBox> make_box(const DecoderLimits& limits = kLimits) {
    auto box = DecoderBox::start({obey, obey_in_colour, {}}, [limits](std::string_view) { return limits; });
    return box ? *std::move(box) : nullptr;
}

template <class AnyPicture>
void expect_unusable(const Result<AnyPicture>& result, const std::string& file) {
    ASSERT_FALSE(result) << file;
    EXPECT_EQ(result.error().code, ErrorCode::Unusable) << file;
    EXPECT_NE(result.error().message.find("could not be decoded"), std::string::npos) << result.error().message;
}

void expect_death_in_colour(DecoderBox& box, const std::string& file) {
    const auto deaths = box.deaths();
    expect_unusable(box.decode_colour(file, kMaxPixels, {}), file);
    EXPECT_EQ(box.deaths(), deaths + 1) << file;
    EXPECT_TRUE(box.decode_colour("picture", kMaxPixels, {})) << "after " << file;
}

void expect_death(DecoderBox& box, const std::string& file) {
    const auto deaths = box.deaths();
    expect_unusable(box.decode(file, kMaxPixels, {}), file);
    EXPECT_EQ(box.deaths(), deaths + 1) << file;
    EXPECT_TRUE(box.decode("picture", kMaxPixels, {})) << "after " << file;
    expect_death_in_colour(box, file);
}

struct Process {
    pid_t id = 0;
    pid_t parent = 0;
    char state = 0;
};

/// All processes, zombies included.
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

/// Waits for one: after a death it takes its keeper a moment.
pid_t helper() {
    auto found = children_of(keeper());
    while (found.empty()) found = children_of(keeper());
    return found[0];
}

std::ptrdiff_t open_files(pid_t process) {
    const std::filesystem::directory_iterator files("/proc/" + std::to_string(process) + "/fd");
    return std::distance(begin(files), end(files));
}

std::string bytes_of(const std::string& name) {
    std::ifstream file(std::string(CCDT_TEST_DATA) + "/images/" + name, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

TEST(DecoderBox, HandsOverWhatTheDecoderMakes) {
    const auto box = make_box();
    ASSERT_TRUE(box);
    const auto picture = box->decode("picture", kMaxPixels, {});
    ASSERT_TRUE(picture) << picture.error().message;
    EXPECT_EQ(picture->width, 3);
    EXPECT_EQ(picture->height, 1);
    EXPECT_EQ(picture->luminance, (Plane{0, 0.5F, 1}));
    EXPECT_EQ(picture->alpha, (Plane{1, 0.25F, 0}));
    EXPECT_TRUE(box->decode("opaque", kMaxPixels, {})->alpha.empty());

    const auto refused = box->decode("limit", 1234, {});
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, ErrorCode::LimitExceeded);
    EXPECT_EQ(refused.error().message, "1234");
    EXPECT_EQ(box->deaths(), 0U);
}

TEST(DecoderBox, HandsOverColours) {
    const auto box = make_box();
    ASSERT_TRUE(box);
    const auto picture = box->decode_colour("picture", kMaxPixels, {});
    ASSERT_TRUE(picture) << picture.error().message;
    EXPECT_EQ(picture->width, 2);
    EXPECT_EQ(picture->height, 1);
    EXPECT_EQ(picture->red, (Plane{0, 0.5F}));
    EXPECT_EQ(picture->green, (Plane{0.25F, 1}));
    EXPECT_EQ(picture->blue, (Plane{0.125F, 0}));
    EXPECT_EQ(picture->alpha, (Plane{1, 0.75F}));
    EXPECT_TRUE(box->decode_colour("opaque", kMaxPixels, {})->alpha.empty());
    EXPECT_EQ(box->decode_colour("limit", 1234, {}).error().message, "1234");
    EXPECT_EQ(box->deaths(), 0U);
}

TEST(DecoderBox, DecodesPhotographsToTheSameBits) {
    const auto box = DecoderBox::start({api::decode_image, api::decode_colour_image, api::warm_up_decoder},
                                       [](std::string_view file) { return decoder_limits(file, kMaxPixels); })
                         .value();
    for (const auto* name : {"camera.png", "chelsea.png", "astronaut.png"}) {
        const std::string file = bytes_of(name);
        const auto expected = api::decode_image(file, kMaxPixels);
        const auto picture = box->decode(file, kMaxPixels, {});
        ASSERT_TRUE(picture && expected) << name;
        EXPECT_EQ(picture->width, expected->width);
        EXPECT_TRUE(picture->luminance == expected->luminance) << name;
        EXPECT_TRUE(picture->alpha == expected->alpha) << name;

        const auto colours = api::decode_colour_image(file, kMaxPixels);
        const auto decoded = box->decode_colour(file, kMaxPixels, {});
        ASSERT_TRUE(decoded && colours) << name;
        EXPECT_EQ(decoded->height, colours->height);
        EXPECT_TRUE(decoded->red == colours->red && decoded->green == colours->green) << name;
        EXPECT_TRUE(decoded->blue == colours->blue && decoded->alpha == colours->alpha) << name;
    }
    EXPECT_EQ(box->decode("no image", kMaxPixels, {}).error().code, ErrorCode::Unsupported);
    EXPECT_EQ(box->decode("", kMaxPixels, {}).error().code, ErrorCode::Malformed);
}

TEST(DecoderBox, OutlivesADecoderThatFails) {
    const auto box = make_box();
    ASSERT_TRUE(box);
    for (const auto* file : {"crash", "abort", "throw", "exit"}) expect_death(*box, file);
}

TEST(DecoderBox, TakesNoNonsense) {
    const auto box = make_box();
    ASSERT_TRUE(box);
    for (const auto* file : {"elsewhere", "too large", "no size", "greedy"}) {
        expect_death(*box, file);
    }
    expect_death_in_colour(*box, "disorder");
}

TEST(DecoderBox, EndsADecoderThatHangs) {
    const auto box = make_box({kLimits.memory, std::chrono::milliseconds(50)});
    ASSERT_TRUE(box);
    const auto result = box->decode("spin", kMaxPixels, {});
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().code, ErrorCode::Unusable);
    EXPECT_NE(result.error().message.find("too long"), std::string::npos);
    EXPECT_EQ(box->deaths(), 1U);
    while (children_of(helper()).size() != 1) std::this_thread::yield();
}

TEST(DecoderBox, EndsADecoderThatEatsMemory) {
    if (!Sandbox::kIsWhole) GTEST_SKIP() << "sanitizers take all address space";
    const auto box = make_box();
    ASSERT_TRUE(box);
    expect_death(*box, "eat");
}

TEST(DecoderBox, KeepsADecoderFromTheMachine) {
    const auto box = make_box();
    ASSERT_TRUE(box);
    if (box->filter_error() != 0) GTEST_SKIP() << "system calls are not filtered here";
    for (const auto* file : {"open", "socket", "fork", "exec", "kill", "write"}) {
        const auto result = box->decode(file, kMaxPixels, {});
        ASSERT_FALSE(result) << file;
        EXPECT_EQ(result.error().message, "refused") << file;
    }
}

TEST(DecoderBox, StopsWhenAsked) {
    const auto box = make_box();
    ASSERT_TRUE(box);
    std::stop_source stop;
    const std::jthread asking([&] {
        // The decoder and the next one: it is at work.
        while (children_of(helper()).size() < 2) std::this_thread::yield();
        stop.request_stop();
    });
    const auto result = box->decode("spin", kMaxPixels, stop.get_token());
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().code, ErrorCode::Stopped);
    EXPECT_EQ(box->decode("picture", kMaxPixels, stop.get_token()).error().code, ErrorCode::Stopped);
    EXPECT_EQ(box->deaths(), 0U);
    while (children_of(helper()).size() != 1) std::this_thread::yield();
}

TEST(DecoderBox, ServesManyThreads) {
    const auto box = make_box();
    ASSERT_TRUE(box);
    std::vector<std::jthread> threads;
    for (int i = 0; i < 8; ++i) {
        threads.emplace_back([&box, i] {
            for (int round = 0; round < 5; ++round) {
                const bool crashes = (i + round) % 2 == 0;
                EXPECT_EQ(box->decode(crashes ? "crash" : "picture", kMaxPixels, {}).has_value(), !crashes);
            }
        });
    }
    threads.clear();
    EXPECT_EQ(box->deaths(), 20U);
}

TEST(DecoderBox, LeavesNeitherProcessesNorDescriptors) {
    const auto box = make_box();
    ASSERT_TRUE(box);
    ASSERT_TRUE(box->decode("picture", kMaxPixels, {}));
    const auto ours = open_files(getpid());
    const auto theirs = open_files(helper());
    for (int i = 0; i < 20; ++i) {
        for (const auto* file : {"picture", "crash", "abort", "limit"}) {
            static_cast<void>(box->decode(file, kMaxPixels, {}));
        }
    }
    EXPECT_EQ(open_files(getpid()), ours);
    constexpr std::ptrdiff_t kInPassing = 3;  // those of a child that comes or goes
    while (children_of(helper()).size() != 1) std::this_thread::yield();
    EXPECT_LE(open_files(helper()), theirs + kInPassing);
}

TEST(DecoderBox, ReplacesAHelperThatWasKilled) {
    const auto box = make_box();
    ASSERT_TRUE(box);
    for (int round = 0; round < 3; ++round) {
        kill(helper(), SIGKILL);
        const auto result = box->decode("picture", kMaxPixels, {});
        EXPECT_TRUE(result) << result.error().message;
    }
    EXPECT_EQ(box->deaths(), 0U);
}

TEST(DecoderBox, SaysWhenAllHelpIsGone) {
    const auto box = make_box();
    ASSERT_TRUE(box);
    const pid_t last = helper();
    kill(keeper(), SIGKILL);
    while (is_running(last)) std::this_thread::yield();
    const auto result = box->decode("picture", kMaxPixels, {});
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().code, ErrorCode::Internal);
}

TEST(DecoderBox, TakesItsProcessesWithIt) {
    auto box = make_box();
    ASSERT_TRUE(box);
    const pid_t gone[] = {keeper(), helper()};
    box.reset();
    for (const pid_t process : gone) EXPECT_FALSE(is_running(process));
    EXPECT_TRUE(children_of(getpid()).empty());
}

TEST(DecoderBox, IgnoresSignalsToItsGroup) {
    const auto box = make_box();
    ASSERT_TRUE(box);
    for (const int number : {SIGINT, SIGTERM, SIGHUP}) {
        kill(keeper(), number);
        kill(helper(), number);
    }
    EXPECT_TRUE(box->decode("picture", kMaxPixels, {}));
}

}  // namespace
}  // namespace ccdt::server
