#include "hil_tests/program.hpp"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <stdexcept>
#include <string_view>
#include <system_error>
#include <thread>
#include <utility>

#include "common/types/clocks.hpp"

extern char** environ;

namespace roadbalance::test {
namespace {

int decode_status(int status) {
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

}  // namespace

Program::Program(const std::string& name, const std::vector<std::string>& arguments,
                 const std::filesystem::path& said) {
  const auto ours = binaries() / name;
  std::vector<std::string> words{std::filesystem::exists(ours) ? ours.string() : name};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (auto& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  posix_spawn_file_actions_t files;
  ::posix_spawn_file_actions_init(&files);
  if (!said.empty())
    ::posix_spawn_file_actions_addopen(&files, STDERR_FILENO, said.c_str(), O_WRONLY | O_CREAT | O_APPEND,
                                       0644);
  const int error = ::posix_spawnp(&pid_, argv[0], &files, nullptr, argv.data(), environ);
  ::posix_spawn_file_actions_destroy(&files);
  if (error != 0) throw std::system_error(error, std::generic_category(), "start " + words[0]);
}

Program::~Program() {
  kill();
}

Program::Program(Program&& other) noexcept : pid_(std::exchange(other.pid_, -1)) {}

Program& Program::operator=(Program&& other) noexcept {
  std::swap(pid_, other.pid_);
  return *this;
}

void Program::signal(int number) const {
  if (pid_ > 0) ::kill(pid_, number);
}

void Program::kill() {
  if (pid_ < 0) return;
  ::kill(pid_, SIGKILL);
  ::waitpid(pid_, nullptr, 0);
  pid_ = -1;
}

std::optional<int> Program::exit_code(double seconds) {
  int status = 0;
  if (pid_ < 0 || !wait_until([&] { return ::waitpid(pid_, &status, WNOHANG) == pid_; }, seconds))
    return std::nullopt;
  pid_ = -1;
  return decode_status(status);
}

int run(const std::string& name, const std::vector<std::string>& arguments, double seconds) {
  return Program(name, arguments).exit_code(seconds).value_or(-1);
}

bool full_run() {
  const char* full = std::getenv("RB_FULL");
  return full && std::string_view(full) == "1";
}

bool wait_until(const std::function<bool()>& condition, double seconds) {
  const auto deadline = WallClock::now() + std::chrono::duration<double>(seconds);
  while (!condition()) {
    if (WallClock::now() > deadline) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return true;
}

std::filesystem::path binaries() {
  const char* folder = std::getenv("RB_BIN");
  if (!folder) throw std::runtime_error("RB_BIN is not set: run this test with ctest");
  return folder;
}

}  // namespace roadbalance::test
