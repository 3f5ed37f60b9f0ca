#include "host/recording/formats/separate_reader.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <initializer_list>
#include <memory>
#include <new>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "common/config/section.hpp"

namespace roadbalance {
namespace {

constexpr const char* kCannotBeRead = ": cannot be read, is perhaps damaged: reading it ";

enum class MessageKind : std::uint32_t { kChannels, kRows, kEnd, kConfigError, kError };

/// The head of a message in the pipe; `bytes` bytes follow.
struct Head {
  MessageKind kind = MessageKind::kEnd;
  std::uint32_t rows = 0;
  std::uint64_t bytes = 0;
  double part = 0.0;
};

constexpr std::size_t kMostMessageBytes = 64 << 20;  ///< limit of one message; a sound process sends less

/// @throws std::runtime_error if the reading end is closed
void put(int pipe, const void* data, std::size_t size) {
  const auto* bytes = static_cast<const char*>(data);
  while (size > 0) {
    const ssize_t wrote = write(pipe, bytes, size);
    if (wrote < 0 && errno != EINTR) throw std::runtime_error("nobody reads");
    if (wrote <= 0) continue;
    bytes += wrote;
    size -= static_cast<std::size_t>(wrote);
  }
}

void put(int pipe, MessageKind kind, std::string_view text) {
  const Head head{.kind = kind, .bytes = text.size()};
  put(pipe, &head, sizeof head);
  put(pipe, text.data(), text.size());
}

/// Lowers a limit of this process; never raises one.
void limit(__rlimit_resource resource, rlim_t most) {
  rlimit limits{};
  getrlimit(resource, &limits);
  limits.rlim_cur = std::min(most, limits.rlim_max);
  if (setrlimit(resource, &limits) != 0)
    throw std::system_error(errno, std::generic_category(), "limit what reading a file takes");
}

void allow_memory(std::int64_t more_bytes) {
  long pages = 0;
  if (std::FILE* const file =
          std::fopen("/proc/self/statm", "r")) {  // proc(5): the process's size comes first
    if (std::fscanf(file, "%ld", &pages) != 1) pages = 0;
    std::fclose(file);
  }
  const auto page = static_cast<std::int64_t>(sysconf(_SC_PAGESIZE));
  if (more_bytes == 0) more_bytes = sysconf(_SC_PHYS_PAGES) / 2 * page;
  limit(RLIMIT_AS, static_cast<rlim_t>(pages * page + more_bytes));
}

/// Limits the processor time from now on, until it is called again.  Beyond it SIGXCPU ends the process.
void allow_time(int processor_s) {
  rusage used{};
  getrusage(RUSAGE_SELF, &used);
  constexpr int kCutOff_s = 2;  // at most, of the two
  limit(RLIMIT_CPU,
        static_cast<rlim_t>(used.ru_utime.tv_sec + used.ru_stime.tv_sec + kCutOff_s + processor_s));
}

/// Sends the whole file through the pipe.
void send_all(int pipe, const std::filesystem::path& file, const OpenSamples& open, ReaderLimits limits) {
  limit(RLIMIT_CORE, 0);
  allow_memory(limits.more_bytes);
  allow_time(limits.processor_s);
  const auto source = open(file);
  std::string texts;
  for (const FileChannel& channel : source->channels())
    for (const std::string* text : {&channel.name, &channel.unit, &channel.node, &channel.quantity})
      texts.append(*text).push_back('\0');
  put(pipe, MessageKind::kChannels, texts);
  SampleRows rows;
  const int rows_s = limits.processor_s * static_cast<int>(source->channels().size());
  while (allow_time(rows_s), source->read(rows)) {
    const auto bytes_of = [](const std::vector<double>& numbers) { return numbers.size() * sizeof(double); };
    const Head head{.kind = MessageKind::kRows,
                    .rows = static_cast<std::uint32_t>(rows.rows()),
                    .bytes = bytes_of(rows.time_s) + bytes_of(rows.value),
                    .part = source->part()};
    put(pipe, &head, sizeof head);
    put(pipe, rows.time_s.data(), bytes_of(rows.time_s));
    put(pipe, rows.value.data(), bytes_of(rows.value));
  }
  put(pipe, MessageKind::kEnd, "");
}

/// The process's whole life.  It tidies up nothing that it inherits, since that is not its own.
[[noreturn]] void be_reader(int pipe, const std::filesystem::path& file, const OpenSamples& open,
                            ReaderLimits limits) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  std::signal(SIGPIPE, SIG_IGN);
  try {
    try {
      send_all(pipe, file, open, limits);
    } catch (const ConfigError& error) {
      put(pipe, MessageKind::kConfigError, error.what());
    } catch (const std::bad_alloc&) {
      put(pipe, MessageKind::kConfigError, file.string() + kCannotBeRead + "takes more memory than it may");
    } catch (const std::exception& error) {
      put(pipe, MessageKind::kError, error.what());
    }
  } catch (const std::exception&) {  // the reading end is closed
  }
  _exit(0);
}

/// The other process, as seen from here: receives its messages, and ends it with this object.
class Reader {
 public:
  Reader(const std::filesystem::path& file, const OpenSamples& open, ReaderLimits limits)
      : file_(file.string()), limits_(limits) {
    int ends[2];
    if (pipe2(ends, O_CLOEXEC) != 0) refuse("pipe to read ");
    process_ = fork();
    if (process_ == 0) {
      close(ends[0]);
      be_reader(ends[1], file, open, limits);
    }
    pipe_ = ends[0];
    close(ends[1]);
    if (process_ > 0) return;
    close(pipe_);
    refuse("fork to read ");
  }
  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;
  ~Reader() {
    close(pipe_);
    if (process_ < 0) return;
    kill(process_, SIGKILL);
    await_end();
  }

  /// @throws the error that the process sent, and on a message of a kind that is not expected now
  Head next(std::initializer_list<MessageKind> allowed) {
    Head head;
    take(&head, sizeof head);
    if (head.bytes > kMostMessageBytes) fail(kOutOfStep);
    if (head.kind == MessageKind::kConfigError) throw ConfigError(take_text(head));
    if (head.kind == MessageKind::kError) throw std::runtime_error(take_text(head));
    if (std::ranges::find(allowed, head.kind) == allowed.end()) fail(kOutOfStep);
    return head;
  }
  void take_rows(const Head& head, SampleRows& rows) {
    if (head.rows > SampleSource::kRowsAtOnce ||
        head.bytes != head.rows * (1 + rows.channels) * sizeof(double))
      fail(kOutOfStep);
    rows.time_s.resize(head.rows);
    rows.value.resize(head.rows * rows.channels);
    take(rows.time_s.data(), rows.time_s.size() * sizeof(double));
    take(rows.value.data(), rows.value.size() * sizeof(double));
  }
  std::string take_text(const Head& head) {
    std::string text(head.bytes, '\0');
    take(text.data(), text.size());
    return text;
  }

 private:
  static constexpr const char* kOutOfStep = "came out of step";

  [[noreturn]] void fail(const std::string& reason) const {
    throw ConfigError(file_ + kCannotBeRead + reason);
  }
  [[noreturn]] void refuse(const char* what) const {
    throw std::system_error(errno, std::generic_category(), what + file_);
  }

  void take(void* into, std::size_t size) {
    auto* bytes = static_cast<char*>(into);
    while (size > 0) {
      pollfd wanted{.fd = pipe_, .events = POLLIN, .revents = 0};
      if (poll(&wanted, 1, limits_.wait_s * 1000) == 0)
        fail("does not get on: nothing came for " + std::to_string(limits_.wait_s) + " s");
      const ssize_t got = ::read(pipe_, bytes, size);
      if (got == 0) fail_by_end();
      if (got < 0 && errno != EINTR) refuse("read ");
      if (got <= 0) continue;
      bytes += got;
      size -= static_cast<std::size_t>(got);
    }
  }

  int await_end() {
    int status = 0;
    while (waitpid(process_, &status, 0) < 0 && errno == EINTR) {
    }
    process_ = -1;
    return status;
  }

  [[noreturn]] void fail_by_end() {
    const int status = await_end();
    const int signal = WIFSIGNALED(status) ? WTERMSIG(status) : 0;
    if (signal == SIGXCPU) fail("does not get on, though a processor works at it");
    fail("fails in the library" + (signal == 0 ? "" : std::string(": ") + strsignal(signal)));
  }

  const std::string file_;
  const ReaderLimits limits_;
  pid_t process_ = -1;
  int pipe_ = -1;
};

class SeparateSamples final : public SampleSource {
 public:
  SeparateSamples(std::filesystem::path file, OpenSamples open, ReaderLimits limits)
      : file_(std::move(file)), open_(std::move(open)), limits_(limits), channel_(begin()) {}

  const std::vector<FileChannel>& channels() const override { return channel_; }
  double part() const override { return part_; }
  void rewind() override {
    if (begin() != channel_)
      throw ConfigError(file_.string() +
                        ": has other channels than when it was opened; allowed: a file that is done");
  }
  bool read(SampleRows& rows) override {
    rows.clear();
    rows.channels = channel_.size();
    if (is_done_) return false;
    const Head head = reader_->next({MessageKind::kRows, MessageKind::kEnd});
    is_done_ = head.kind == MessageKind::kEnd;
    if (is_done_) return false;
    reader_->take_rows(head, rows);
    part_ = head.part;
    return true;
  }

 private:
  std::vector<FileChannel> begin() {
    reader_.reset();  // so that there are never two
    reader_ = std::make_unique<Reader>(file_, open_, limits_);
    is_done_ = false;
    part_ = 0.0;
    const std::string text = reader_->take_text(reader_->next({MessageKind::kChannels}));
    std::vector<FileChannel> channels;
    for (std::size_t at = 0; at < text.size();) {
      FileChannel& channel = channels.emplace_back();
      for (std::string* part : {&channel.name, &channel.unit, &channel.node, &channel.quantity})
        if (at < text.size()) at += (*part = text.c_str() + at).size() + 1;
    }
    return channels;
  }

  const std::filesystem::path file_;
  const OpenSamples open_;
  const ReaderLimits limits_;
  std::unique_ptr<Reader> reader_;
  double part_ = 0.0;
  bool is_done_ = false;
  const std::vector<FileChannel> channel_;
};

}  // namespace

std::unique_ptr<SampleSource> read_separately(const std::filesystem::path& file, OpenSamples open,
                                              ReaderLimits limits) {
  return std::make_unique<SeparateSamples>(file, std::move(open), limits);
}

}  // namespace roadbalance
