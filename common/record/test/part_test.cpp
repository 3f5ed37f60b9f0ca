#include "common/record/part.hpp"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>
#include <iterator>
#include <string>

#include "common/test/temporary_directory.hpp"

namespace roadbalance {
namespace {

namespace fs = std::filesystem;

class PartTest : public testing::Test {
 protected:
  static void write(const fs::path& file, const std::string& text) { std::ofstream(file) << text; }
  static std::string text_of(const fs::path& file) {
    std::ifstream stream(file);
    return std::string(std::istreambuf_iterator<char>(stream), {});
  }
  /// Why it is not made; "" if it is.
  std::string refusal(const fs::path& path, Part::Kind kind) {
    try {
      const Part part(path, kind);
    } catch (const std::exception& error) {
      return error.what();
    }
    return "";
  }
  /// A process that writes half of it, and is killed.
  void leave_half(const fs::path& path, Part::Kind kind) {
    const pid_t child = fork();
    if (child == 0) {
      const Part part(path, kind);
      write(kind == Part::Kind::kFile ? part.part() : part.part() / "inside", "half");
      kill(getpid(), SIGKILL);
    }
    int status = 0;
    waitpid(child, &status, 0);
    ASSERT_TRUE(WIFSIGNALED(status));
  }

  const test::TemporaryDirectory directory_;
  const fs::path folder_ = directory_.path();
};

TEST_F(PartTest, AppearsWithAllItHoldsOrNotAtAll) {
  for (const bool keep : {false, true}) {
    Part file(folder_ / "file", Part::Kind::kFile), folder(folder_ / "folder", Part::Kind::kFolder);
    write(file.part(), "all");
    write(folder.part() / "inside", "all");
    EXPECT_FALSE(fs::exists(folder_ / "file") || fs::exists(folder_ / "folder"));
    if (!keep) continue;
    file.keep();
    folder.keep();
  }
  EXPECT_EQ(text_of(folder_ / "file"), "all");
  EXPECT_EQ(text_of(folder_ / "folder" / "inside"), "all");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), {}), 2);
}

TEST_F(PartTest, WhatAKilledOneLeftGivesWay) {
  for (const auto kind : {Part::Kind::kFile, Part::Kind::kFolder}) {
    const fs::path path = folder_ / (kind == Part::Kind::kFile ? "file" : "folder");
    leave_half(path, kind);
    EXPECT_TRUE(fs::exists(path.string() + ".part"));
    EXPECT_FALSE(fs::exists(path));
    Part part(path, kind);
    if (kind == Part::Kind::kFile) {
      EXPECT_FALSE(fs::exists(part.part()));
      write(part.part(), "whole");
    } else {
      EXPECT_TRUE(fs::is_empty(part.part()));
    }
    part.keep();
    EXPECT_TRUE(fs::exists(path));
    EXPECT_FALSE(fs::exists(path.string() + ".part"));
  }
}

TEST_F(PartTest, RefusesWhatSomebodyElseIsMaking) {
  const Part first(folder_ / "drive", Part::Kind::kFolder);
  EXPECT_NE(refusal(folder_ / "drive", Part::Kind::kFolder).find("drive.part: is being made"),
            std::string::npos);
  EXPECT_NE(refusal(folder_ / "drive", Part::Kind::kFile).find("drive.part: is being made"),
            std::string::npos);
  EXPECT_TRUE(fs::exists(first.part())) << "it goes on as before";
}

TEST_F(PartTest, TouchesNothingOfOthers) {
  write(folder_ / "download.part", "somebody's");
  fs::create_directory(folder_ / "copy.part");
  write(folder_ / "copy.part" / "seg-000001.lcm", "half a transfer");
  EXPECT_NE(refusal(folder_ / "download", Part::Kind::kFile).find("download.part"), std::string::npos);
  EXPECT_NE(refusal(folder_ / "copy", Part::Kind::kFolder).find("holds seg-000001.lcm"), std::string::npos);
  EXPECT_EQ(text_of(folder_ / "download.part"), "somebody's");
  EXPECT_EQ(text_of(folder_ / "copy.part" / "seg-000001.lcm"), "half a transfer");
}

TEST_F(PartTest, ARecordingHasANameThatOtherSystemsTake) {
  fs::create_directory(folder_ / "drive");
  for (const char* name : {"con", "x.",
                           "a\x1b"
                           "b",
                           "a\u202Eb", "Drive"}) {
    EXPECT_NE(refusal(folder_ / name, Part::Kind::kFolder).find("choose another name"), std::string::npos)
        << name;
    EXPECT_FALSE(fs::exists(folder_ / name) || fs::exists((folder_ / name).string() + ".part")) << name;
  }
  EXPECT_EQ(refusal(folder_ / "drive", Part::Kind::kFolder), "") << "empty so far";
  EXPECT_EQ(refusal(folder_ / "Drive", Part::Kind::kFile), "") << "a file is not a recording";
}

TEST_F(PartTest, MakesNoFolderAboveItself) {
  EXPECT_NE(refusal(folder_ / "none" / "drive", Part::Kind::kFolder).find("none: no such folder"),
            std::string::npos);
  write(folder_ / "file", "");
  EXPECT_NE(refusal(folder_ / "file" / "drive", Part::Kind::kFile).find("file: is no folder"),
            std::string::npos);
  EXPECT_FALSE(fs::exists(folder_ / "none"));
}

TEST_F(PartTest, LiesInNoSource) {
  fs::create_directories(folder_ / "drive" / "sub");
  fs::create_directory_symlink(folder_ / "drive", folder_ / "link");
  EXPECT_THROW(expect_beside({folder_ / "drive"}, folder_ / "drive" / "sub" / "part"), std::runtime_error);
  EXPECT_THROW(expect_beside({folder_ / "drive"}, folder_ / "link" / "part"), std::runtime_error);
  EXPECT_THROW(expect_beside({folder_ / "drive"}, folder_ / "drive"), std::runtime_error);
  EXPECT_NO_THROW(expect_beside({folder_ / "drive"}, folder_ / "drive-2"));
}

}  // namespace
}  // namespace roadbalance
