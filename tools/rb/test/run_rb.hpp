#pragma once

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include "common/process/child.hpp"

namespace roadbalance::test {

struct Outcome {
  int code;  ///< exit code
  std::string output, log;
};

/// Runs the rb that CTest names, to its end.
/// @param log  file for its messages; its output goes beside it
inline Outcome run_rb(const std::vector<std::string>& arguments, const std::filesystem::path& log) {
  Child rb(std::filesystem::path(std::getenv("RB_BIN")) / "rb", arguments, log);
  while (!rb.ended()) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  return {*rb.ended(), rb.output(), rb.log()};
}

}  // namespace roadbalance::test
