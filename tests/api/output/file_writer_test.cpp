// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/output/file_writer.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <thread>

#include <fcntl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

namespace ccdt::api {
namespace {

namespace fs = std::filesystem;

class FileWriterTest : public testing::Test {
protected:
    FileWriterTest() : folder_(fs::path(testing::TempDir()) / "files-XXXXXX") {
        std::string name = folder_.string();
        EXPECT_NE(mkdtemp(name.data()), nullptr);
        folder_ = name;
    }
    ~FileWriterTest() override { fs::remove_all(folder_); }

    std::string path(const std::string& name) const { return folder_ / name; }

    /// Creates a link to a descriptor of this process, like /dev/stdout.
    std::string link_to(int descriptor) const {
        fs::create_symlink("/proc/self/fd/" + std::to_string(descriptor), path("link"));
        return path("link");
    }

    void put(const std::string& name, const std::string& text) const { std::ofstream(path(name)) << text; }

    std::string text_of(const std::string& name) const {
        std::ifstream file(path(name));
        return {std::istreambuf_iterator<char>(file), {}};
    }

    std::ptrdiff_t count() const { return std::distance(fs::directory_iterator(folder_), fs::directory_iterator()); }

    fs::path folder_;
};

std::string written_to(int pipe) {
    std::array<char, 64> text{};
    return {text.data(), static_cast<std::size_t>(std::max<ssize_t>(read(pipe, text.data(), text.size()), 0))};
}

TEST_F(FileWriterTest, ReplacesARegularFileAndKeepsItsModeAndLinks) {
    put("a", "before, and longer");
    fs::permissions(path("a"), fs::perms(0640));
    fs::create_symlink("a", path("b"));
    fs::create_directory(path("folder"));
    fs::create_symlink("../b", path("folder/c"));
    EXPECT_FALSE(write_file(path("folder/c"), "after"));
    EXPECT_EQ(text_of("a"), "after");
    EXPECT_EQ(fs::status(path("a")).permissions(), fs::perms(0640));
    EXPECT_TRUE(fs::is_symlink(path("b")) && fs::is_symlink(path("folder/c")));
    EXPECT_EQ(count(), 3);
}

TEST_F(FileWriterTest, CreatesTheTargetOfADanglingLink) {
    fs::create_symlink("a", path("b"));
    EXPECT_FALSE(write_file(path("b"), "text"));
    EXPECT_TRUE(fs::is_symlink(path("b")));
    EXPECT_EQ(text_of("a"), "text");
    fs::create_symlink("missing/a", path("c"));
    EXPECT_EQ(write_file(path("c"), "text"), std::errc::no_such_file_or_directory);
    EXPECT_TRUE(fs::is_symlink(path("c")));
    EXPECT_EQ(count(), 3);
}

TEST_F(FileWriterTest, LeavesTheOldFileUntilTheNewOneIsComplete) {
    put("a", "before");
    {
        FileWriter file(find_output(path("a")));
        EXPECT_FALSE(file.open());
        EXPECT_FALSE(file.write("after"));
        EXPECT_TRUE(fs::exists(file.temporary()));
        EXPECT_EQ(text_of("a"), "before");
    }
    EXPECT_EQ(text_of("a"), "before");
    EXPECT_EQ(count(), 1);
}

TEST_F(FileWriterTest, WritesToAPipeBehindALink) {
    std::array<int, 2> ends{};
    ASSERT_EQ(pipe(ends.data()), 0);
    const std::string link = link_to(ends[1]);
    EXPECT_FALSE(write_file(link, "text"));
    EXPECT_EQ(written_to(ends[0]), "text");
    EXPECT_TRUE(fs::is_symlink(link));
    EXPECT_EQ(count(), 1);
    close(ends[0]);
    close(ends[1]);
}

TEST_F(FileWriterTest, WritesToASocketBehindALink) {
    std::array<int, 2> ends{};
    ASSERT_EQ(socketpair(AF_UNIX, SOCK_STREAM, 0, ends.data()), 0);
    EXPECT_FALSE(write_file(link_to(ends[1]), "text"));
    EXPECT_EQ(written_to(ends[0]), "text");
    close(ends[0]);
    close(ends[1]);
}

TEST_F(FileWriterTest, ContinuesARedirectedFileAtItsOffset) {
    for (const bool is_deleted : {false, true}) {
        const int file = open(path("log").c_str(), O_RDWR | O_CREAT | O_TRUNC, 0644);
        ASSERT_EQ(write(file, "1 ", 2), 2);
        if (is_deleted) unlink(path("log").c_str());
        EXPECT_FALSE(write_file(link_to(file), "2 "));
        ASSERT_EQ(write(file, "3", 1), 1);
        std::array<char, 5> text{};
        EXPECT_EQ(pread(file, text.data(), text.size(), 0), 5);
        EXPECT_EQ(std::string(text.data(), 5), "1 2 3");
        EXPECT_EQ(count(), is_deleted ? 1 : 2);
        close(file);
        unlink(path("link").c_str());
    }
}

TEST_F(FileWriterTest, RejectsClosedAndReadOnlyDescriptors) {
    put("a", "text");
    const int file = open(path("a").c_str(), O_RDONLY);
    const std::string link = link_to(file);
    std::string where;
    EXPECT_EQ(check_output(find_output(link), where), std::errc::bad_file_descriptor);
    EXPECT_EQ(write_file(link, "other"), std::errc::bad_file_descriptor);
    EXPECT_EQ(text_of("a"), "text");
    close(file);
    EXPECT_EQ(check_output(find_output(link), where), std::errc::no_such_file_or_directory);
    EXPECT_EQ(write_file(link, "other"), std::errc::no_such_file_or_directory);
    EXPECT_TRUE(fs::is_symlink(link));
    EXPECT_EQ(count(), 2);
}

TEST_F(FileWriterTest, WritesToNamedPipesOnceTheyHaveAReader) {
    ASSERT_EQ(mkfifo(path("pipe").c_str(), 0600), 0);
    fs::create_symlink("pipe", path("link"));
    std::string text;
    {
        const std::jthread reader([&] { text = text_of("pipe"); });
        EXPECT_FALSE(write_file(path("link"), "text"));
    }
    EXPECT_EQ(text, "text");
    EXPECT_TRUE(fs::is_fifo(path("pipe")));
    EXPECT_EQ(count(), 2);
}

TEST_F(FileWriterTest, WaitsForAPipeThatDoesNotBlock) {
    std::array<int, 2> ends{};
    ASSERT_EQ(pipe2(ends.data(), O_NONBLOCK), 0);
    const std::string bytes(1 << 20, 'x');
    std::size_t received = 0;
    {
        const std::jthread reader([&] {
            std::array<char, 4096> piece{};
            fcntl(ends[0], F_SETFL, 0);
            while (received < bytes.size())
                received += static_cast<std::size_t>(std::max<ssize_t>(read(ends[0], piece.data(), piece.size()), 0));
        });
        EXPECT_FALSE(write_file(link_to(ends[1]), bytes));
    }
    EXPECT_EQ(received, bytes.size());
    close(ends[0]);
    close(ends[1]);
}

TEST_F(FileWriterTest, ReplacesNeitherFoldersNorSockets) {
    fs::create_directory(path("folder"));
    put("a", "text");
    const int listener = socket(AF_UNIX, SOCK_STREAM, 0);
    sockaddr_un address{AF_UNIX, {}};
    ASSERT_LT(path("socket").copy(address.sun_path, sizeof(address.sun_path) - 1), sizeof(address.sun_path) - 1);
    ASSERT_EQ(bind(listener, reinterpret_cast<const sockaddr*>(&address), sizeof(address)), 0);
    fs::create_symlink("loop", path("loop"));
    for (const auto& [name, error] : {std::pair("folder", std::errc::is_a_directory),
                                      {"folder/", std::errc::is_a_directory},
                                      {"folder/..", std::errc::is_a_directory},
                                      {"socket", std::errc::no_such_device_or_address},
                                      {"loop", std::errc::too_many_symbolic_link_levels},
                                      {"a/", std::errc::not_a_directory},
                                      {"a/b", std::errc::not_a_directory},
                                      {"missing/", std::errc::no_such_file_or_directory},
                                      {"missing/a", std::errc::no_such_file_or_directory}}) {
        std::string where;
        EXPECT_EQ(check_output(find_output(path(name)), where), error) << name;
        EXPECT_EQ(write_file(path(name), "other"), error) << name;
    }
    EXPECT_EQ(write_file("", "other"), std::errc::no_such_file_or_directory);
    EXPECT_EQ(write_file(path(std::string("b\0c", 3)), "other"), std::errc::invalid_argument);
    close(listener);
    EXPECT_TRUE(fs::is_socket(path("socket")) && fs::is_symlink(path("loop")));
    EXPECT_EQ(text_of("a"), "text");
    EXPECT_EQ(count(), 4);
}

TEST_F(FileWriterTest, AcceptsNamesOfTheMaximumLength) {
    const std::string name(NAME_MAX, 'a');
    EXPECT_FALSE(write_file(path(name), "text"));
    EXPECT_EQ(text_of(name), "text");
    EXPECT_EQ(write_file(path(name + 'a'), "text"), std::errc::filename_too_long);
    EXPECT_EQ(count(), 1);
}

}  // namespace
}  // namespace ccdt::api
