#include "common/record/failure_words.hpp"

#include <gtest/gtest.h>

#include <cerrno>
#include <filesystem>
#include <new>
#include <stdexcept>
#include <system_error>

namespace roadbalance {
namespace {

std::error_code code(int number) {
  return {number, std::generic_category()};
}

TEST(FailureWords, OfFilesNameThemTheCauseAndTheRemedyAndNothingOfCxx) {
  EXPECT_EQ(
      failure_words(std::filesystem::filesystem_error("cannot create directories", "/media/a", code(ENOSPC))),
      "/media/a: No space left on device: make room on its disk, and begin again");
  EXPECT_EQ(
      failure_words(std::filesystem::filesystem_error("cannot rename", "/a", "/b", code(EROFS))),
      "/a to /b: Read-only file system: its disk is mounted to be read only: mount it to be written, or take "
      "another folder");
  EXPECT_EQ(failure_words(std::filesystem::filesystem_error("status", "/a", code(ELOOP))),
            "/a: Too many levels of symbolic links");
}

TEST(FailureWords, OfSystemCallsKeepWhatWasSaid) {
  EXPECT_EQ(failure_words(std::system_error(code(EIO), "write /a")),
            "write /a: Input/output error: its disk fails: take another, and save what is on this one");
  EXPECT_EQ(failure_words(std::system_error(code(ENOENT), "open /a")), "open /a: No such file or directory");
}

TEST(FailureWords, OfMemoryAndOfOurOwn) {
  EXPECT_EQ(failure_words(std::bad_alloc()),
            "there is not enough memory for it: end other programs, or take a part of it");
  EXPECT_EQ(failure_words(std::runtime_error("drive: no recording")), "drive: no recording");
}

}  // namespace
}  // namespace roadbalance
