#include "common/process/temporary_folder.hpp"

#include <cerrno>
#include <cstdlib>
#include <system_error>

namespace roadbalance {

TemporaryFolder::TemporaryFolder(const std::string& name) {
  std::string path = (std::filesystem::temp_directory_path() / (name + "-XXXXXX")).string();
  if (mkdtemp(path.data()) == nullptr)
    throw std::system_error(errno, std::generic_category(), "create " + path);
  path_ = path;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;  // a temporary folder that stays does no harm
  std::filesystem::remove_all(path_, ignored);
}

}  // namespace roadbalance
