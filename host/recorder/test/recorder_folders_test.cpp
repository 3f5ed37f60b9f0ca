#include <gtest/gtest.h>

#include <filesystem>
#include <stdexcept>
#include <string>

#include "common/test/bus_url.hpp"
#include "common/test/temporary_directory.hpp"
#include "host/recorder/recorder.hpp"

namespace roadbalance {
namespace {

namespace fs = std::filesystem;

// With the folder there or not, and whatever it is called by.
TEST(RecorderFoldersTest, OneFolderIsNotAlsoItsOwnFallback) {
  const test::TemporaryDirectory work;
  const fs::path folder = work.path() / "drive";
  for (const bool is_there : {false, true}) {
    if (is_there) {
      fs::create_directory(folder);
      fs::create_directory_symlink(folder, work.path() / "link");
    }
    for (const fs::path& name : {folder, folder / "", work.path() / "x" / ".." / "drive",
                                 is_there ? work.path() / "link" : folder}) {
      RecorderOptions options;
      options.url = test::bus_url();
      options.folder = folder;
      options.fallback = name;
      try {
        run_recorder({}, options);
        FAIL() << name << " is " << folder;
      } catch (const std::invalid_argument& error) {
        EXPECT_NE(std::string(error.what()).find(name.string()), std::string::npos) << error.what();
      }
    }
  }
}

// As one on a disk that fails: it is its fallback's turn.
TEST(RecorderFoldersTest, AFirstFolderWhoseNameLeadsNowhereIsNoMistake) {
  const test::TemporaryDirectory work;
  RecorderOptions options;
  options.folder = work.path() / "drive";
  fs::create_symlink(options.folder, options.folder);
  options.fallback = work.path() / "other";
  EXPECT_NO_THROW(refuse_mistakes(options));
}

}  // namespace
}  // namespace roadbalance
