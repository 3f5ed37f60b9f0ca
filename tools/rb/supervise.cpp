#include <poll.h>
#include <signal.h>
#include <sys/signalfd.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>
#include <CLI/CLI.hpp>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <string>
#include <system_error>
#include <vector>

#include "common/config/validators.hpp"
#include "common/process/temporary_folder.hpp"
#include "tools/rb/command.hpp"
#include "tools/rb/supervisor.hpp"

namespace roadbalance {
namespace {

constexpr std::array kPassedOn{SIGTERM, SIGINT, SIGHUP, SIGQUIT, SIGUSR1, SIGUSR2};

[[noreturn]] void throw_errno(const std::string& what) {
  throw std::system_error(errno, std::generic_category(), what);
}

constexpr int kUnknownCode = 1;

struct End {
  int code;
  std::string words;
};

End end_of(int status) {
  if (WIFSIGNALED(status))
    return {128 + WTERMSIG(status), "ended by signal " + std::to_string(WTERMSIG(status))};
  return {WEXITSTATUS(status), "ended with code " + std::to_string(WEXITSTATUS(status))};
}

/// Where the program's sd_notify(3) datagrams come.
class NotifySocket {
 public:
  explicit NotifySocket(const std::filesystem::path& path) : path_(path) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    if (path_.size() >= sizeof address.sun_path) throw std::runtime_error("too long for a socket: " + path_);
    std::memcpy(address.sun_path, path_.data(), path_.size());
    if (socket_ < 0 || ::bind(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
      throw_errno("socket " + path_);
  }
  NotifySocket(const NotifySocket&) = delete;
  NotifySocket& operator=(const NotifySocket&) = delete;
  ~NotifySocket() {
    if (socket_ >= 0) ::close(socket_);
  }

  int descriptor() const { return socket_; }
  const std::string& path() const { return path_; }
  bool receive(std::string& message) const {
    std::array<char, 2048> buffer;
    const ssize_t size = ::recv(socket_, buffer.data(), buffer.size(), MSG_DONTWAIT);
    if (size < 0) return false;
    message.assign(buffer.data(), static_cast<std::size_t>(size));
    return true;
  }

 private:
  const std::string path_;
  const int socket_ = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
};

/// Signals as a file to wait at; they are blocked for this program from here on.
class Signals {
 public:
  Signals() {
    sigemptyset(&set_);
    sigaddset(&set_, SIGCHLD);
    for (const int signal : kPassedOn) sigaddset(&set_, signal);
    ::sigprocmask(SIG_BLOCK, &set_, &before_);
    // An ignored SIGCHLD is inherited: the end of a child would not be reported, here and in the program.
    ::signal(SIGCHLD, SIG_DFL);
    file_ = ::signalfd(-1, &set_, SFD_CLOEXEC | SFD_NONBLOCK);
    if (file_ < 0) throw_errno("signalfd");
  }
  Signals(const Signals&) = delete;
  Signals& operator=(const Signals&) = delete;
  ~Signals() { ::close(file_); }

  int descriptor() const { return file_; }
  const sigset_t& before() const { return before_; }
  /// 0: none.
  int next() const {
    signalfd_siginfo info{};
    return ::read(file_, &info, sizeof info) == sizeof info ? static_cast<int>(info.ssi_signo) : 0;
  }

 private:
  sigset_t set_{};
  sigset_t before_{};
  int file_ = -1;
};

class Supervision {
 public:
  Supervision(Supervisor::Options options, std::vector<std::string> words)
      : words_(std::move(words)),
        supervisor_(options),
        folder_("rb-supervise"),
        socket_(folder_.path() / "notify") {
    for (auto& word : words_) pointers_.push_back(word.data());
    pointers_.push_back(nullptr);
    ::setenv("NOTIFY_SOCKET", socket_.path().c_str(), 1);
    ::unsetenv("WATCHDOG_PID");  // one that watches us is not meant
    if (options.watchdog)
      ::setenv("WATCHDOG_USEC", std::to_string(std::chrono::microseconds(*options.watchdog).count()).c_str(),
               1);
    else
      ::unsetenv("WATCHDOG_USEC");
  }

  int run() {
    while (!supervisor_.over()) {
      const WallTime now = WallClock::now();
      switch (supervisor_.due(now)) {
        case Supervisor::Act::kStart:
          start(now);
          break;
        case Supervisor::Act::kKill:
          say("it hangs and is killed");
          ::kill(program_, SIGKILL);
          break;
        case Supervisor::Act::kNone:
          wait();
      }
    }
    return *supervisor_.over();
  }

 private:
  void start(WallTime now) {
    program_ = ::fork();
    if (program_ < 0) throw_errno("fork for " + words_[0]);
    if (program_ == 0) {
      ::sigprocmask(SIG_SETMASK, &signals_.before(), nullptr);
      ::execvp(pointers_[0], pointers_.data());
      std::fprintf(stderr, "rb supervise: %s: %s\n", pointers_[0], std::strerror(errno));
      ::_exit(Supervisor::kCannotExecute);
    }
    supervisor_.started(now);
  }

  void wait() {
    std::array<pollfd, 2> files{{{signals_.descriptor(), POLLIN, 0}, {socket_.descriptor(), POLLIN, 0}}};
    const auto timeout = static_cast<int>(supervisor_.time_left(WallClock::now()).count()) + 1;
    if (::poll(files.data(), files.size(), timeout) < 0 && errno != EINTR) throw_errno("poll");
    std::string message;
    while (socket_.receive(message)) supervisor_.take(message, WallClock::now());
    while (const int signal = signals_.next()) on_signal(signal);
    reap();
  }

  void on_signal(int signal) {
    if (signal == SIGCHLD) return;
    const bool ends = signal == SIGTERM || signal == SIGINT || signal == SIGQUIT;
    if (ends) supervisor_.stop();
    if (program_ > 0)
      ::kill(program_, signal);
    else if (ends)
      supervisor_.ended(128 + signal, WallClock::now());  // it came between two runs
  }

  void reap() {
    if (program_ <= 0) return;
    int status = 0;
    const pid_t reaped = ::waitpid(program_, &status, WNOHANG);
    if (reaped == 0) return;
    program_ = -1;
    const End end = reaped < 0 ? End{kUnknownCode, "is gone, nobody knows how"} : end_of(status);
    supervisor_.ended(end.code, WallClock::now());
    if (supervisor_.over()) return;
    say(end.words + "; started again, for the " + std::to_string(supervisor_.restarts()) + ". time" +
        (supervisor_.status().empty() ? "" : "; it last said: " + std::string(supervisor_.status())));
  }

  void say(const std::string& what) const {
    std::fprintf(stderr, "rb supervise: %s: %s\n", words_[0].c_str(), what.c_str());
  }

  std::vector<std::string> words_;
  std::vector<char*> pointers_;
  Supervisor supervisor_;
  const TemporaryFolder folder_;
  const NotifySocket socket_;
  const Signals signals_;
  pid_t program_ = -1;
};

struct SuperviseOptions {
  double watchdog_s = 0;
  std::vector<std::string> words;
};

int supervise(const SuperviseOptions& given) {
  Supervisor::Options options;
  if (given.watchdog_s > 0)
    options.watchdog = std::chrono::milliseconds(static_cast<std::int64_t>(given.watchdog_s * 1000));
  return Supervision(options, given.words).run();
}

}  // namespace

void add_supervise(CLI::App& app, int& code) {
  auto options = std::make_shared<SuperviseOptions>();
  CLI::App* command = app.add_subcommand(
      "supervise",
      "Keeps a program running where there is no systemd: rb supervise [--watchdog S] -- PROGRAM ...");
  command
      ->add_option(
          "--watchdog", options->watchdog_s,
          "kill it when it has not sent WATCHDOG=1 to $NOTIFY_SOCKET for so many seconds, after a start "
          "for 60 at least; 0: never")
      ->check(seconds_or_zero());
  command->add_option("program", options->words, "the program and its arguments")->required();
  command->footer(
      "Ends with the program's exit code when that is 0, 2, 3 or 127, or after SIGTERM, SIGINT or SIGQUIT.");
  command->callback([options, &code] { code = supervise(*options); });
}

}  // namespace roadbalance
