// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/files/file_folder.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <sys/un.h>
#include <unistd.h>

namespace ccdt::server {
namespace {

TEST(FileName, IsASingleVisiblePathComponent) {
    for (const char* name : {"cat.jpg", "a", "cat", "cat..jpg", "~", "a b.png", "\xc3\xa4.png", "\xff", "a\\b",
                             "%2e%2e%2f", "-rf", "*", "con"})
        EXPECT_TRUE(is_file_name(name)) << name;
    EXPECT_TRUE(is_file_name(std::string(255, 'x')));
    for (const char* name :
         {"", ".", "..", ".hidden", "...", "../cat.jpg", "a/b", "/etc/passwd", "a/", "a\nb", "a\x7f"})
        EXPECT_FALSE(is_file_name(name)) << name;
    EXPECT_FALSE(is_file_name(std::string(256, 'x')));
    EXPECT_FALSE(is_file_name(std::string_view("cat.jpg\0", 8)));
    EXPECT_FALSE(is_file_name(std::string_view("\0", 1)));
}

/// A folder of files, and a file outside it.
class FileFolderTest : public testing::Test {
protected:
    FileFolderTest() {
        std::filesystem::create_directories(path_);
        write(root_ / "outside", "secret");
        write(path_ / "cat", "meow");
    }
    ~FileFolderTest() override { std::filesystem::remove_all(root_); }

    static void write(const std::filesystem::path& file, const std::string& text) { std::ofstream(file) << text; }

    HttpResult<std::string> read(std::string_view name, std::size_t largest = 100) const {
        return folder_.open(name, largest).and_then([](OpenFile file) { return file.read(); });
    }

    int status(std::string_view name, std::size_t largest = 100) const {
        const auto text = read(name, largest);
        return text ? 200 : text.error().status;
    }

    /// Whether the answer is the same as for an unknown name.
    bool is_unknown(std::string_view name) const {
        const auto text = read(name), unknown = read("unknown");
        return !text && text.error().status == 404 && text.error().error.message == unknown.error().error.message;
    }

    const std::filesystem::path root_ = testing::TempDir() + "ccdt_files_" + std::to_string(::getpid());
    const std::filesystem::path path_ = root_ / "folder";
    const FileFolder folder_{path_, "document"};
};

TEST_F(FileFolderTest, ReadsFilesByName) {
    EXPECT_EQ(read("cat").value_or(""), "meow");
    write(path_ / "\xc3\xa4 b%2f", "other");
    EXPECT_EQ(read("\xc3\xa4 b%2f").value_or(""), "other");
    write(path_ / "empty", "");
    EXPECT_EQ(read("empty").value_or("?"), "");
    EXPECT_TRUE(is_unknown("CAT"));
}

TEST_F(FileFolderTest, ReadsFilesInSubfolders) {
    std::filesystem::create_directories(path_ / "sub" / "deep");
    write(path_ / "sub" / "cat", "purr");
    write(path_ / "sub" / "deep" / "cat", "hiss");
    EXPECT_EQ(read("sub/cat").value_or(""), "purr");
    EXPECT_EQ(read("sub/deep/cat").value_or(""), "hiss");
    EXPECT_TRUE(is_unknown("deep/cat"));
    EXPECT_TRUE(is_unknown("cat/cat"));
}

TEST_F(FileFolderTest, NamesTheKindOfFileInMessages) {
    EXPECT_EQ(read("unknown").error().error.message, "there is no document of this name");
    EXPECT_TRUE(read("cat", 3).error().error.message.starts_with("the document is larger than "));
}

TEST_F(FileFolderTest, ReadsNothingOutsideTheFolder) {
    std::filesystem::create_directory(path_ / "sub");
    std::filesystem::create_directory(path_ / ".git");
    write(path_ / ".git" / "cat", "meow");
    write(path_ / ".hidden", "meow");
    std::filesystem::create_symlink(root_ / "outside", path_ / "link-out");
    std::filesystem::create_symlink("cat", path_ / "link-in");
    std::filesystem::create_directory_symlink(root_, path_ / "link-to-folder");
    std::filesystem::create_directory_symlink("..", path_ / "sub" / "link-to-parent");
    std::filesystem::create_symlink("loop", path_ / "loop");
    std::filesystem::create_symlink("/proc/self/environ", path_ / "environ");
    for (const char* name : {"..",         "../outside", "../folder/cat",  "sub",
                             "sub/",       "sub/..",     "sub/../cat",     "sub/link-to-parent/cat",
                             "sub//cat",   "./cat",      ".git/cat",       ".hidden",
                             "link-out",   "link-in",    "link-to-folder", "link-to-folder/outside",
                             "loop",       "environ",    "cat/",           ".",
                             "/etc/passwd"})
        EXPECT_TRUE(is_unknown(name)) << name;
    std::string absolute = root_ / "outside";
    EXPECT_TRUE(is_unknown(absolute));
}

TEST_F(FileFolderTest, OpensOnlyRegularFiles) {
    ASSERT_EQ(mkfifo((path_ / "fifo").c_str(), 0600), 0);
    EXPECT_TRUE(is_unknown("fifo")) << "opening a FIFO must not wait for a writer";
    const int socket = ::socket(AF_UNIX, SOCK_STREAM, 0);
    sockaddr_un address{.sun_family = AF_UNIX, .sun_path = {}};
    const std::string position = path_ / "socket";
    ASSERT_LT(position.size(), sizeof(address.sun_path));
    position.copy(address.sun_path, position.size());
    ASSERT_EQ(bind(socket, reinterpret_cast<const sockaddr*>(&address), sizeof(address)), 0);
    EXPECT_TRUE(is_unknown("socket"));
    ::close(socket);
    if (mknod((path_ / "device").c_str(), S_IFCHR | 0666, makedev(1, 5)) == 0) {  // succeeds for root only
        EXPECT_TRUE(is_unknown("device"));
    }
}

TEST_F(FileFolderTest, ReportsUnreadableFilesOnlyToTheLog) {
    std::filesystem::permissions(path_ / "cat", std::filesystem::perms::none);
    const bool is_root = geteuid() == 0;
    ASSERT_TRUE(!is_root || seteuid(65534) == 0) << "permissions do not apply to root";
    const auto text = read("cat");
    EXPECT_TRUE(is_unknown("cat"));
    ASSERT_TRUE(!is_root || seteuid(0) == 0);
    ASSERT_FALSE(text);
    EXPECT_NE(text.error().cause.find("Permission denied"), std::string::npos) << text.error().cause;
    EXPECT_EQ(read("unknown").error().cause, "");
}

TEST_F(FileFolderTest, LimitsTheSize) {
    EXPECT_EQ(status("cat", 4), 200);
    const auto text = read("cat", 3);
    ASSERT_FALSE(text);
    EXPECT_EQ(text.error().status, 413);
    EXPECT_NE(text.error().error.message.find("3 bytes (max-body)"), std::string::npos) << text.error().error.message;
}

TEST_F(FileFolderTest, RefusesFilesThatChangeTheirSize) {
    for (const char* change : {"", "me", "meow!", "a much longer text than it was"}) {
        write(path_ / "cat", "meow");
        auto file = folder_.open("cat", 100);
        ASSERT_TRUE(file);
        write(path_ / "cat", change);
        const auto text = file->read();
        ASSERT_FALSE(text) << change;
        EXPECT_EQ(text.error().status, 503);
        EXPECT_EQ(text.error().headers.front().name, "Retry-After");
    }
}

TEST_F(FileFolderTest, ReadsTheOldContentOfReplacedOrRemovedFiles) {
    auto file = folder_.open("cat", 100);
    write(path_ / "new", "woof");
    std::filesystem::rename(path_ / "new", path_ / "cat");
    EXPECT_EQ(file->read().value_or(""), "meow");
    EXPECT_EQ(read("cat").value_or(""), "woof");
    file = folder_.open("cat", 100);
    std::filesystem::remove(path_ / "cat");
    EXPECT_EQ(file->read().value_or(""), "woof");
    EXPECT_TRUE(is_unknown("cat"));
}

TEST_F(FileFolderTest, FollowsALinkToTheFolder) {
    std::filesystem::create_directory_symlink(path_, root_ / "current");
    const FileFolder current(root_ / "current", "document");
    EXPECT_TRUE(current.check());
    EXPECT_TRUE(current.open("cat", 100));
    std::filesystem::create_directory(root_ / "second");
    std::filesystem::create_directory_symlink(root_ / "second", root_ / "next");
    std::filesystem::rename(root_ / "next", root_ / "current");
    EXPECT_EQ(current.open("cat", 100).error().status, 404);
}

TEST_F(FileFolderTest, RequiresTheFolderToExist) {
    EXPECT_TRUE(folder_.check());
    for (const auto& position : {root_ / "nowhere", path_ / "cat"}) {
        const auto checked = FileFolder(position, "document").check();
        ASSERT_FALSE(checked);
        EXPECT_NE(checked.error().message.find(position.string()), std::string::npos)
            << "the operator must see the path";
        const auto opened = FileFolder(position, "document").open("cat", 100);
        ASSERT_FALSE(opened);
        EXPECT_EQ(opened.error().status, 500);
        EXPECT_EQ(opened.error().error.message.find(position.string()), std::string::npos)
            << "clients must not see the path";
    }
}

}  // namespace
}  // namespace ccdt::server
