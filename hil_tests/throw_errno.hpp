#pragma once

#include <cerrno>
#include <string>
#include <system_error>

namespace roadbalance::test {

/// Throws for a failed system call, naming the call and its object.
[[noreturn]] inline void throw_errno(const std::string& what) {
  throw std::system_error(errno, std::generic_category(), what);
}

}  // namespace roadbalance::test
