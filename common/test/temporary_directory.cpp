#include "common/test/temporary_directory.hpp"

#include <cerrno>
#include <cstdlib>
#include <system_error>

namespace roadbalance::test {

TemporaryDirectory::TemporaryDirectory() {
  std::string name = (std::filesystem::temp_directory_path() / "roadbalance-test-XXXXXX").string();
  if (mkdtemp(name.data()) == nullptr)
    throw std::system_error(errno, std::generic_category(), "mkdtemp " + name);
  path_ = name;
}

TemporaryDirectory::~TemporaryDirectory() {
  std::error_code ignored;  // a directory that stays behind is no failure of the test
  std::filesystem::remove_all(path_, ignored);
}

}  // namespace roadbalance::test
