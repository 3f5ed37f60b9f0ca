#include "common/process/child.hpp"

#include <fcntl.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <fstream>
#include <ios>
#include <sstream>
#include <system_error>
#include <thread>
#include <utility>

namespace roadbalance {
namespace {

constexpr int kCannotExecute = 127;

/// In the child after fork: only what is safe there, then the program.
[[noreturn]] void become(const char* program, char* const* arguments, const char* output_file,
                         const char* log_file, pid_t parent, int signal_to_orphan) {
  prctl(PR_SET_PDEATHSIG, signal_to_orphan);
  if (getppid() != parent) _exit(kCannotExecute);  // it ended before the line above
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);  // StopOnSignal had blocked some
  setpgid(0, 0);  // Ctrl-C in the terminal is for the parent, which ends its children in order
  const int input = open("/dev/null", O_RDONLY);
  const int output = open(output_file, O_WRONLY | O_CREAT | O_TRUNC, 0644);
  const int log = open(log_file, O_WRONLY | O_CREAT | O_TRUNC, 0644);
  if (input < 0 || output < 0 || log < 0 || dup2(input, 0) < 0 || dup2(output, 1) < 0 || dup2(log, 2) < 0)
    _exit(kCannotExecute);
  execv(program, arguments);
  _exit(kCannotExecute);
}

constexpr std::streamoff kLastWords = 65'536;  // bytes

/// From the end if `from` is below 0.
std::string read(const std::filesystem::path& path, std::streamoff from, std::size_t most) {
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  const std::streamoff size = file.tellg();
  if (size <= 0) return {};
  const std::streamoff begin = from < 0 ? std::max<std::streamoff>(0, size + from) : std::min(from, size);
  std::string text(std::min(most, static_cast<std::size_t>(size - begin)), '\0');
  file.seekg(begin);
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(file.gcount()));
  return text;
}

}  // namespace

Child::Child(const std::filesystem::path& program, const std::vector<std::string>& arguments,
             std::filesystem::path log, Orphan orphan)
    : name_(program.filename().string()), log_(std::move(log)) {
  if (access(program.c_str(), X_OK) != 0)
    throw std::system_error(errno, std::generic_category(), "start " + program.string());
  std::vector<std::string> words{program.string()};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> pointers;
  for (auto& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  const std::string output = output_file().string();
  const pid_t parent = getpid();
  pid_ = fork();
  if (pid_ < 0) throw std::system_error(errno, std::generic_category(), "fork for " + program.string());
  if (pid_ == 0)
    become(program.c_str(), pointers.data(), output.c_str(), log_.c_str(), parent,
           orphan == Orphan::kIsEnded ? SIGKILL : SIGTERM);
}

Child::Child(Child&& other) noexcept
    : name_(std::move(other.name_)),
      log_(std::move(other.log_)),
      pid_(std::exchange(other.pid_, -1)),
      code_(other.code_),
      signal_(other.signal_) {}

Child::~Child() {
  if (pid_ < 0) return;
  stop();
  for (int i = 0; i < 200 && !ended(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  if (ended()) return;
  kill(pid_, SIGKILL);
  waitpid(pid_, nullptr, 0);
}

std::optional<int> Child::ended() {
  if (code_) return code_;
  int status = 0;
  if (waitpid(pid_, &status, WNOHANG) != pid_) return std::nullopt;
  if (WIFSIGNALED(status)) signal_ = WTERMSIG(status);
  code_ = signal_ != 0 ? 128 + signal_ : WEXITSTATUS(status);
  return code_;
}

void Child::stop() {
  if (ended()) return;
  kill(pid_, SIGTERM);
  kill(pid_, SIGCONT);
}

void Child::end() {
  if (!ended()) kill(pid_, SIGKILL);
}

void Child::hold(bool is_held) {
  if (!ended()) kill(pid_, is_held ? SIGSTOP : SIGCONT);
}

std::optional<std::int64_t> Child::bytes_read() const {
  std::ifstream counters("/proc/" + std::to_string(pid_) + "/io");  // proc(5): "rchar: 123"
  std::string name;
  std::int64_t bytes = 0;
  if (!(counters >> name >> bytes) || name != "rchar:") return std::nullopt;
  return bytes;
}

std::filesystem::path Child::output_file() const {
  return std::filesystem::path(log_).replace_extension(".out");
}

std::string Child::output(std::size_t most) const {
  return read(output_file(), 0, most);
}

std::string Child::log(std::size_t most) const {
  return read(log_, 0, most);
}

std::string Child::last_words() const {
  std::istringstream lines(read(log_, -kLastWords, kLastWords));
  std::string line;
  std::string last = "it said nothing";
  while (std::getline(lines, line))
    if (!line.empty()) last = line;
  return last;
}

std::string Child::how_it_ended() const {
  if (signal_ != 0) return "was ended by signal " + std::to_string(signal_);
  return "ended with code " + std::to_string(code_.value_or(0)) + ": " + last_words();
}

std::filesystem::path sibling_program(const std::string& name) {
  return std::filesystem::read_symlink("/proc/self/exe").parent_path() / name;
}

}  // namespace roadbalance
