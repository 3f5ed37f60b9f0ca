#include "common/record/file.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <system_error>

#include "common/record/folder.hpp"
#include "common/record/segment_index.hpp"
#include "common/test/temporary_directory.hpp"

namespace roadbalance {
namespace {

// As a damaged length of a file makes it: 4 TB without a block on the disk.
void write_sparse(const std::filesystem::path& path) {
  std::ofstream(path).close();
  std::filesystem::resize_file(path, std::uint64_t{4} << 40);
}

TEST(ReadText, ATextOfTheGreatestLengthIsReadWhole) {
  const test::TemporaryDirectory folder;
  const std::string text(kMostTextBytes, 'x');
  write_atomically(folder / "text", text);
  EXPECT_EQ(read_text(folder / "text"), text);
  EXPECT_EQ(read_whole_text(folder / "text"), text);
  EXPECT_EQ(read_whole_text(folder / "none"), std::nullopt);
}

TEST(ReadText, OneThatIsLongerIsRefusedByItsNameWhereItIsNeeded) {
  const test::TemporaryDirectory folder;
  write_sparse(folder / "recorder.json");
  try {
    read_whole_text(folder / "recorder.json");
    FAIL() << "4 TB of memory";
  } catch (const std::system_error& error) {
    EXPECT_EQ(error.code(), std::errc::file_too_large);
    EXPECT_NE(std::string(error.what()).find(folder / "recorder.json"), std::string::npos) << error.what();
  }
}

std::string refusal_of(const std::filesystem::path& path) {
  try {
    (void)File::open_segment(path);
  } catch (const std::system_error& error) {
    return error.what();
  }
  return "";
}

// A pipe would wait for ever, and a link leads anywhere.
TEST(OpenSegment, WhatIsNoRegularFileIsNamedAndNotRead) {
  const test::TemporaryDirectory folder;
  ASSERT_EQ(mkfifo((folder / "seg-000001.lcm").c_str(), 0600), 0);
  write_atomically(folder / "other", "text");
  std::filesystem::create_symlink(folder / "other", folder / "seg-000002.lcm");
  std::filesystem::create_symlink("/dev/zero", folder / "zero");
  EXPECT_NE(refusal_of(folder / "seg-000001.lcm").find("seg-000001.lcm: no regular file"), std::string::npos);
  EXPECT_NE(refusal_of(folder / "seg-000002.lcm").find("seg-000002.lcm: a link"), std::string::npos);
  EXPECT_THROW((void)read_text(folder / "zero"), std::system_error);
  EXPECT_EQ(refusal_of(folder / "other"), "");
}

TEST(ReadText, BesideARecordNoLinkIsFollowed) {
  const test::TemporaryDirectory folder;
  write_atomically(folder / "other", "text");
  std::filesystem::create_symlink(folder / "other", folder / "manifest.json");
  EXPECT_THROW((void)read_text(folder / "manifest.json"), std::system_error);
  EXPECT_EQ(read_text(folder / "manifest.json", kernel_disk(), Links::kFollowed), "text");
  EXPECT_EQ(read_whole_text(folder / "manifest.json"), "text") << "a vehicle file may be a link";
}

TEST(Folder, SaysWhatANameIsThatIsNoRegularFile) {
  const test::TemporaryDirectory folder;
  write_atomically(folder / "file", "text");
  ASSERT_EQ(mkfifo((folder / "pipe").c_str(), 0600), 0);
  std::filesystem::create_symlink(folder / "file", folder / "link");
  std::filesystem::create_directory(folder / "sub");
  EXPECT_EQ(irregular_kind(folder / "pipe"), "a pipe");
  EXPECT_EQ(irregular_kind(folder / "link"), "a link");
  EXPECT_EQ(irregular_kind(folder / "sub"), "a folder");
  EXPECT_EQ(irregular_kind("/dev/null"), "a device");
  EXPECT_EQ(irregular_kind(folder / "file"), "");
  EXPECT_EQ(irregular_kind(folder / "none"), "");
  try {
    (void)path_exists(folder / "pipe");
    ADD_FAILURE() << "opened a pipe";
  } catch (const std::system_error& error) {
    EXPECT_NE(std::string(error.what()).find("pipe: no regular file, which is not read"), std::string::npos);
  }
}

TEST(ReadText, AnIndexThatIsLongerIsNone) {
  const test::TemporaryDirectory folder;
  write_sparse(folder / "seg-000001.idx");
  EXPECT_EQ(read_index_alone(folder / ".", 1), std::nullopt);
}

}  // namespace
}  // namespace roadbalance
