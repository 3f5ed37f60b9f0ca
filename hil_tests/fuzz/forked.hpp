#pragma once

#include <dlfcn.h>
#include <sanitizer/asan_interface.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <span>
#include <string>
#include <string_view>

#include "hil_tests/fuzz/edge_counters.hpp"
#include "hil_tests/fuzz/property.hpp"

namespace roadbalance::fuzz {

/// Runs a check in a process of its own, for a library that damage can end, and which is not ours to mend.
/// Edges that our code passed count here; a fault of ours ends this process.
///
/// A program with it shall have symbolize=0 among its default options: the address of a frame shows its
/// owner, and a symbolizer for each fault of the library takes many times as long as the check.
class Forked {
 public:
  /// @param library  whose faults are forgiven, as a stack names it: "libhdf5"
  explicit Forked(std::string_view library) : library_(library) {
    const std::size_t size = sizeof(Shared) + edge_counters().size();
    void* const memory = mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    require(memory != MAP_FAILED, "there is memory");
    shared_ = static_cast<Shared*>(memory);
  }

  /// @param check  whether the input was taken
  template <typename Check>
  void run(Check check) {
    *shared_ = {};
    std::ranges::fill(counted(), 0);
    const pid_t process = fork();
    require(process >= 0, "there can be a process");
    if (process == 0) {
      begin();
      shared_->outcome = check() ? Outcome::kTaken : Outcome::kRefused;
      finish();
    }
    int status = 0;
    while (waitpid(process, &status, 0) < 0 && errno == EINTR) {  // by the fuzzer's own timer
    }
    for (std::size_t k = 0; k < edge_counters().size(); ++k)
      edge_counters()[k] = static_cast<std::uint8_t>(std::min(255, edge_counters()[k] + counted()[k]));
    if (shared_->outcome == Outcome::kTaken) taken_.count();
    const bool is_held = WIFSIGNALED(status) && WTERMSIG(status) == SIGXCPU;
    require(is_held || shared_->outcome != Outcome::kNone, "whatever ends it is the library's");
  }

 private:
  enum class Outcome : std::uint8_t { kNone, kRefused, kTaken, kLibraryFailed };
  struct Shared {
    Outcome outcome = Outcome::kNone;
    // The edge counters are behind it.
  };

  /// The process's edge counters, brought here.
  std::span<std::uint8_t> counted() const {
    return {reinterpret_cast<std::uint8_t*>(shared_ + 1), edge_counters().size()};
  }

  void begin() {
    constexpr rlim_t kMost_s = 1;
    const rlimit limit{kMost_s, kMost_s + 1};
    setrlimit(RLIMIT_CPU, &limit);
    std::signal(SIGABRT, SIG_DFL);
    current_ = this;
    __asan_set_error_report_callback([](const char* report) { current_->judge(report); });
    std::ranges::fill(edge_counters(), 0);
  }
  /// The library's fault if it was at work, on memory that is its own: our stack, and what we allocated, is
  /// ours.
  void judge(std::string_view report) {
    const auto allocated = report.find("allocated by");
    const bool is_our_memory = report.find("located in stack of") != std::string_view::npos ||
                               report.find("global variable") != std::string_view::npos ||
                               (allocated != std::string_view::npos && !is_library(report.substr(allocated)));
    if (!is_library(report) || is_our_memory) {
      std::fputs("broken: our code ends it; with ASAN_OPTIONS=symbolize=1 its frames have names\n", stderr);
      return;
    }
    shared_->outcome = Outcome::kLibraryFailed;
    finish();
  }
  /// Whether it stands further in than any code of ours; between them may be the sanitizer's and libc's.
  bool is_library(std::string_view stack) const {
    Dl_info here{};
    dladdr(&current_, &here);
    for (auto at = stack.find("    #0 "); at < stack.size(); at = stack.find("\n    #", at + 1)) {
      const std::string line(stack.substr(at, stack.find('\n', at + 1) - at));
      const auto address = std::min(line.find("0x"), line.size());
      Dl_info frame{};
      if (dladdr(reinterpret_cast<void*>(std::strtoull(&line[address], nullptr, 16)), &frame) == 0) continue;
      if (std::string_view(frame.dli_fname).find(library_) != std::string_view::npos) return true;
      // Only the exported functions of the program itself are not ours: the sanitizer's stand-ins for libc's
      // functions.
      if (frame.dli_fbase == here.dli_fbase && frame.dli_sname == nullptr) return false;
    }
    return false;
  }
  [[noreturn]] void finish() {
    std::ranges::copy(edge_counters(), counted().begin());
    _exit(0);
  }

  static inline Forked* current_ = nullptr;
  const std::string_view library_;
  Reached taken_{"the end of a check in its own process"};
  Shared* shared_ = nullptr;
};

}  // namespace roadbalance::fuzz
