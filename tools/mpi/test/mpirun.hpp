#pragma once

#include <unistd.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace roadbalance::test {

struct Output {
  std::string text, errors;
  int status;
};

inline Output output_of(const std::string& command) {
  Output output;
  const std::filesystem::path errors =
      std::filesystem::temp_directory_path() / ("cluster-test-" + std::to_string(getpid()));
  std::FILE* pipe = popen((command + " 2>" + errors.string()).c_str(), "r");
  std::array<char, 4096> part{};
  while (const std::size_t n = std::fread(part.data(), 1, part.size(), pipe))
    output.text.append(part.data(), n);
  output.status = WEXITSTATUS(pclose(pipe));
  std::ifstream file(errors);
  output.errors.assign(std::istreambuf_iterator<char>(file), {});
  std::filesystem::remove(errors);
  return output;
}

/// As root and on a machine of one core, too, with Open MPI 4 and 5; others do not know the variables.
inline std::string mpirun(int processes) {
  return "OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMPI_MCA_rmaps_base_oversubscribe=1 "
         "PRTE_MCA_rmaps_default_mapping_policy=:oversubscribe mpirun -n " +
         std::to_string(processes) + " ";
}

inline std::string program(const char* name) {
  return std::string(std::getenv("RB_BIN")) + "/" + name;
}

}  // namespace roadbalance::test
