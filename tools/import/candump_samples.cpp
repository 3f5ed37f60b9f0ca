#include "tools/import/candump_samples.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "common/config/section.hpp"
#include "common/dbc/candump.hpp"
#include "common/dbc/dbc_reading.hpp"
#include "host/recording/formats/candump_writer.hpp"
#include "host/recording/formats/line_reader.hpp"
#include "host/recording/formats/units.hpp"

namespace roadbalance {
namespace {

constexpr double kNoSample = std::numeric_limits<double>::quiet_NaN();

/// Remote frames have no data, error frames an identifier beyond all others.
bool is_passed_over(const std::string& line) {
  const std::size_t hash = line.find('#'), space = line.rfind(' ', hash);
  if (line.empty() || hash == std::string::npos || space == std::string::npos) return line.empty();
  const bool is_error = hash - space - 1 == 8 && line[space + 1] >= '2';
  return line.compare(hash, 2, "#R") == 0 || is_error;
}

class CandumpSamples final : public SampleSource {
 public:
  CandumpSamples(const std::filesystem::path& log, Dbc dbc)
      : dbc_(std::move(dbc)), log_(open_again_and_again(log)), lines_(log_) {
    for (const DbcMessage& message : dbc_.messages) message_[{message.id, message.extended}] = {&message, {}};
    // Which messages are channels is known once the whole log was looked through.
    while (const auto frame = next_known())
      if (!frame->known->first_column) frame->known->first_column = add_columns(*frame->known->message);
    if (channel_.empty()) lines_.fail("no frame that " + dbc_.file + " knows a signal of");
    rewind();
  }

  const std::vector<FileChannel>& channels() const override { return channel_; }
  double part() const override { return lines_.part(); }
  void rewind() override {
    lines_ = LineReader(log_);
    interface_.clear();
    first_ns_.reset();
    last_ns_ = 0;
    ahead_ = next_known();
  }
  bool read(SampleRows& rows) override {
    rows.clear();
    rows.channels = channel_.size();
    for (; ahead_; ahead_ = next_known()) {
      if (rows.rows() == 0 || ahead_->time_ns != row_ns_) {
        if (rows.rows() == kRowsAtOnce) break;
        row_ns_ = ahead_->time_ns;
        rows.time_s.push_back(time_s(row_ns_));
        rows.value.resize(rows.rows() * channel_.size(), kNoSample);
      }
      add(ahead_->frame, *ahead_->known, std::span(rows.value).last(channel_.size()));
    }
    return rows.rows() > 0;
  }

 private:
  struct KnownMessage {
    const DbcMessage* message;
    std::optional<std::size_t> first_column;  // of its signals, once a frame has come
  };
  struct KnownFrame {
    CanFrame frame;
    std::int64_t time_ns;
    KnownMessage* known;
  };

  double time_s(std::int64_t time_ns) const { return 1e-9 * static_cast<double>(time_ns - *first_ns_); }

  /// The next frame that the DBC file describes.
  std::optional<KnownFrame> next_known() {
    while (lines_.next()) {
      const std::string line(lines_.line());
      const auto logged = parse_candump(line);
      if (!logged && !is_passed_over(line))
        lines_.fail("\"" + line.substr(0, 60) +
                    "\" is no frame; allowed: (seconds.microseconds) interface ID#DATA");
      if (!logged) continue;
      const auto known = message_.find({logged->frame.id, logged->frame.extended});
      if (known == message_.end()) continue;
      if (!interface_.empty() && interface_ != logged->interface)
        lines_.fail("frames of " + logged->interface + " and " + interface_ + "; allowed: those of one bus");
      interface_ = logged->interface;
      if (known->second.message->name == kCandumpStart) {
        expect_same_channels(*known->second.message, logged->frame);
        if (first_ns_)
          lines_.fail("a recording's start behind its frames; allowed: the log of one recording");
        first_ns_ = last_ns_ = logged->time_ns;
        continue;
      }
      if (!first_ns_ && is_of_export())
        lines_.fail(
            std::string("no frame ") + kCandumpStart +
            " stands before it, so that its channels may be others than those of " + dbc_.file +
            "; allowed: the log of rb export from its first line on, or a DBC file of other programs");
      if (first_ns_ && logged->time_ns < last_ns_)
        lines_.fail("its time goes back; allowed: frames in order of time");
      if (!first_ns_) first_ns_ = logged->time_ns;
      if (!is_countable(time_s(logged->time_ns))) lines_.fail(std::string("its time ") + kTooFarOff);
      last_ns_ = logged->time_ns;
      return KnownFrame{logged->frame, logged->time_ns, &known->second};
    }
    return std::nullopt;
  }

  /// In a file of an older release neither the frame nor its message has data.
  void expect_same_channels(const DbcMessage& start, const CanFrame& frame) const {
    const DbcSignal* const meaning = start.signal(kCandumpMeaning);
    if (frame.size != start.size ||
        (meaning && read_signal(start, *meaning, frame).status != DbcReading::Status::kOk))
      lines_.fail("its channels are not those of " + dbc_.file +
                  "; allowed: the DBC file that its export made (rb export --dbc)");
  }

  /// The DBC file is that of an export, and so names the channels' nodes.
  bool is_of_export() const {
    const DbcMessage* const start = dbc_.message(kCandumpStart);
    return start && start->signal(kCandumpMeaning);
  }

  std::size_t add_columns(const DbcMessage& message) {
    const std::size_t first = channel_.size();
    for (const DbcSignal& signal : message.signals) {
      if (std::ranges::find(channel_, signal.name, &FileChannel::name) != channel_.end())
        throw ConfigError(dbc_.file + ":" + std::to_string(signal.line) + ": " + signal.name +
                          ": stands in two messages of the log; allowed: one");
      channel_.push_back({.name = signal.name,
                          .unit = signal.unit,
                          .node = is_of_export() ? message.sender : std::string()});
    }
    return first;
  }

  void add(const CanFrame& frame, const KnownMessage& known, std::span<double> row) const {
    const DbcMessage& message = *known.message;
    for (std::size_t s = 0; s < message.signals.size(); ++s) {
      const DbcReading reading = read_signal(message, message.signals[s], frame);
      if (reading.status == DbcReading::Status::kTooShort)
        lines_.fail(std::to_string(frame.size) + " bytes; message " + message.name + " has " +
                    std::to_string(message.size));
      if (reading.status != DbcReading::Status::kOk) continue;
      const std::size_t column = *known.first_column + s;
      if (!std::isnan(row[column])) lines_.fail(message.signals[s].name + " stands twice at one instant");
      row[column] = reading.value;
      if (std::isinf(row[column])) lines_.fail(message.signals[s].name + " " + kTooLarge);
    }
  }

  const Dbc dbc_;
  const std::shared_ptr<const File> log_;
  LineReader lines_;
  std::map<std::pair<std::uint32_t, bool>, KnownMessage> message_;
  std::vector<FileChannel> channel_;
  std::string interface_;
  std::optional<std::int64_t> first_ns_;  // from which times count
  std::int64_t last_ns_ = 0, row_ns_ = 0;
  std::optional<KnownFrame> ahead_;  // of the line read last, in no row yet
};

}  // namespace

std::unique_ptr<SampleSource> open_candump_samples(const std::filesystem::path& log,
                                                   const std::filesystem::path& dbc) {
  return std::make_unique<CandumpSamples>(log, Dbc::read_file(dbc.string()));
}

}  // namespace roadbalance
