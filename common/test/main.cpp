#include <gtest/gtest.h>

#include <cstdio>
#include <string>
#include <string_view>

namespace {

/// "a_test.cpp" of "/somewhere/a_test.cpp".
std::string_view name_of(std::string_view path) {
  return path.substr(path.rfind('/') + 1);
}

/// A filter for the tests that stand in `file`; empty: none does.
std::string tests_in(std::string_view file) {
  std::string filter;
  const auto& all = *testing::UnitTest::GetInstance();
  for (int i = 0; i < all.total_test_suite_count(); ++i) {
    const auto& suite = *all.GetTestSuite(i);
    for (int k = 0; k < suite.total_test_count(); ++k)
      if (const auto& test = *suite.GetTestInfo(k); name_of(test.file()) == file)
        filter += std::string(suite.name()) + "." + test.name() + ":";
  }
  return filter;
}

}  // namespace

/// Runs the tests that stand in the sources named, without one all.
int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  std::string filter;
  for (int i = 1; i < argc; ++i) {
    const std::string tests = tests_in(argv[i]);
    if (tests.empty()) {
      std::fprintf(stderr, "%s: no test in %s\n", argv[0], argv[i]);
      return 2;
    }
    filter += tests;
  }
  // A filter on the command line is narrower: a test that dies is run again by its own name.
  if (!filter.empty() && testing::GTEST_FLAG(filter) == "*") testing::GTEST_FLAG(filter) = filter;
  return RUN_ALL_TESTS();
}
