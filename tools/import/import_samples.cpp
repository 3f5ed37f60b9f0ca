#include "tools/import/import_samples.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <span>
#include <stdexcept>
#include <utility>

#include "common/config/section.hpp"
#include "common/record/part.hpp"
#include "common/text/format.hpp"
#include "common/types/block.hpp"
#include "host/recording/formats/candump_writer.hpp"
#include "host/recording/formats/line_reader.hpp"
#include "host/recording/formats/unique_names.hpp"
#include "host/recording/formats/units.hpp"
#include "host/recording/transfer/digest.hpp"
#include "tools/import/imported_record.hpp"
#include "tools/import/node_import.hpp"

namespace roadbalance {

namespace {

constexpr double kRateTolerance = 0.01;

/// Every column is wanted by a channel and every channel in use has a column.
ColumnOf match_columns(const SampleImport& import, const std::vector<FileChannel>& columns,
                       const VehicleConfig& vehicle) {
  ColumnOf column;
  for (std::size_t c = 0; c < columns.size(); ++c) column[columns[c].name] = c;
  ColumnOf unwanted = column;
  for (const auto& node : vehicle.node)
    for (const auto& channel : node.channel) {
      unwanted.erase(channel.name);
      if (const auto found = column.find(channel.name); found != column.end())
        if (const std::string& of = columns[found->second].node;
            !of.empty() && of != dbc_identifier(node.name))
          throw ConfigError(import.samples.string() + ": channel " + channel.name + " comes from node " + of +
                            "; in the vehicle's description it is of node " + node.name);
      if (channel.role != ChannelRole::kUnused && !column.contains(channel.name))
        throw ConfigError(import.samples.string() + ": no column for channel " + channel.name + " of node " +
                          node.name + "; allowed: a column of that name, or role = \"unused\"");
    }
  for (const TachometerColumn& tachometer : import.tachometer) {
    if (!column.contains(tachometer.channel))
      throw ConfigError(import.samples.string() + ": no column " + tachometer.channel +
                        " for --tachometer; allowed: a column of that name");
    unwanted.erase(tachometer.channel);
  }
  std::erase_if(unwanted, [](const auto& named) { return is_reference_column(named.first); });
  if (!unwanted.empty())
    throw ConfigError(import.samples.string() + ": column " + unwanted.begin()->first +
                      ": no node has a channel of that name");
  return column;
}

NodeTime instant(double seconds) {
  static_assert(kFarthest_s * 1e9 < static_cast<double>(kClockLimit_ns));
  return node_time_from_ns(std::llround(seconds * 1e9));
}

/// FNV-1a.
class QuickDigest {
 public:
  template <typename Value>
  void mix(std::span<const Value> values) {
    for (const std::byte byte : std::as_bytes(values))
      hash_ = (hash_ ^ static_cast<std::uint64_t>(byte)) * 1099511628211ULL;
  }
  void mix(const SampleRows& rows) {
    mix<double>(rows.time_s);
    mix<double>(rows.value);
  }
  void mix(const Pulse& pulse) {
    const std::array what{pulse.time_s, static_cast<double>(pulse.wheel), static_cast<double>(pulse.kind)};
    mix<double>(what);
  }
  std::uint64_t value() const { return hash_; }
  bool operator==(const QuickDigest&) const = default;

 private:
  std::uint64_t hash_ = 14695981039346656037ULL;
};

/// The wheels' tachometers among the columns.
class Tachometers {
 public:
  Tachometers(const SampleImport& import, const ColumnOf& column) : import_(import) {
    for (const TachometerColumn& one : import.tachometer)
      tachometer_.push_back({one, column.at(one.channel), {}, {}});
  }

  /// Of all rows first: a threshold is of the whole signal.
  void look(std::span<const double> cells) {
    for (Tachometer& one : tachometer_) one.levels.add(cells[one.place]);
  }
  /// @throws ConfigError naming a column that does not change
  void begin() {
    for (Tachometer& one : tachometer_) {
      if (!(one.levels.largest > one.levels.least))
        throw ConfigError(import_.samples.string() + ": --tachometer: column " + one.column.channel +
                          (one.levels.samples == 0 ? " has no sample" : " never changes") +
                          "; allowed: a signal with a pulse in each turn, or of each tooth");
      one.pulses.emplace(one.levels);
    }
  }
  /// Pulses between the row before and this one, in order of time.
  std::vector<Pulse> read(std::span<const double> cells, double time_s, double period_s) {
    std::vector<Pulse> pulses;
    for (Tachometer& one : tachometer_)
      if (const auto at_s = one.pulses->add(time_s, period_s, cells[one.place]))
        pulses.push_back({*at_s, one.column.wheel, EdgeKind::kTooth});
    std::ranges::stable_sort(pulses, {}, &Pulse::time_s);
    return pulses;
  }
  std::vector<ImportReport::Tachometer> report() const {
    std::vector<ImportReport::Tachometer> all;
    for (const Tachometer& one : tachometer_)
      all.push_back({one.column.channel, one.column.wheel, one.pulses->pulses(), one.pulses->threshold(),
                     one.pulses->sigma_s()});
    return all;
  }

 private:
  struct Tachometer {
    TachometerColumn column;
    std::size_t place;
    TachometerLevels levels;
    std::optional<TachometerPulses> pulses;
  };
  const SampleImport& import_;
  std::vector<Tachometer> tachometer_;
};

/// Other programs' files, read from the first row to the last as often as one likes.
class Input {
 public:
  Input(const SampleImport& import, const VehicleConfig& vehicle, std::stop_token stop,
        const ImportProgress& progress)
      : import_(import),
        vehicle_(vehicle),
        stop_(std::move(stop)),
        progress_(progress),
        source_(import.open(import.samples)),
        units_(understand_units(import.samples, source_->channels(), vehicle, import.units)) {
    if (import.pulses) pulses_.emplace(*import.pulses);
    for (const TachometerColumn& tachometer : import.tachometer)
      refuse_without_encoder(tachometer.wheel, "--tachometer " + tachometer.channel);
  }

  const std::vector<FileChannel>& columns() const { return source_->channels(); }
  const std::vector<ChannelUnit>& units() const { return units_; }

  void rewind() {
    ++passes_;
    source_->rewind();
    if (pulses_) pulses_->rewind();
  }
  /// The next rows, in SI.
  /// @throws std::runtime_error if asked to stop
  bool read(SampleRows& rows) {
    if (stop_.stop_requested())
      throw std::runtime_error("stopped; nothing is left of " + import_.folder.string());
    if (progress_) progress_(0.5 * (passes_ + source_->part()));
    if (!source_->read(rows)) return false;
    for (std::size_t k = 0; k < rows.value.size(); ++k) {
      const ChannelUnit& unit = units_[k % units_.size()];
      rows.value[k] *= unit.factor;
      if (std::isinf(rows.value[k]))
        throw ConfigError(import_.samples.string() + ": channel " + unit.channel +
                          format(": its sample at %.9g s ", rows.time_s[k / units_.size()]) + kTooLarge);
    }
    return true;
  }
  std::optional<Pulse> next_pulse() {
    const auto pulse = pulses_ ? pulses_->next() : std::nullopt;
    if (pulse) refuse_without_encoder(pulse->wheel, import_.pulses->string());
    return pulse;
  }
  const WheelConfig& wheel_of(const Pulse& pulse) const {
    return vehicle_.wheel[static_cast<std::size_t>(pulse.wheel)];
  }

 private:
  void refuse_without_encoder(int wheel, const std::string& source) const {
    if (const WheelConfig& config = vehicle_.wheel[static_cast<std::size_t>(wheel)]; config.node.empty())
      throw ConfigError(
          source + ": wheel " + config.name +
          ": no node reads its encoder; allowed: node and [wheel.encoder] in the vehicle's description");
  }

  const SampleImport& import_;
  const VehicleConfig& vehicle_;
  const std::stop_token stop_;
  const ImportProgress& progress_;
  const std::unique_ptr<SampleSource> source_;
  const std::vector<ChannelUnit> units_;  ///< [column]
  std::optional<PulseSource> pulses_;
  double passes_ = 0.0;  ///< behind us
};

/// Everything that must be known before the first scan is sealed.
struct Looked {
  SampleClock clock;
  std::int64_t rows = 0;
  bool has_pulses = false;
  QuickDigest samples, pulses;
};

Looked look_through(Input& input, Tachometers& tachometers, const SampleImport& import, double nominal_hz) {
  Looked looked;
  SampleClockFit fit(nominal_hz);
  const auto of_time = [&](auto work) {
    try {
      return work();
    } catch (const std::invalid_argument& error) {
      throw ConfigError(import.samples.string() + ": time_s: " + error.what());
    }
  };
  for (SampleRows rows; input.read(rows); looked.samples.mix(rows)) {
    of_time([&] { std::ranges::for_each(rows.time_s, [&](double time_s) { fit.add(time_s); }); });
    for (std::size_t k = 0; k < rows.rows(); ++k) tachometers.look(rows.row(k));
  }
  tachometers.begin();
  looked.clock = of_time([&] { return fit.clock(); });
  looked.rows = fit.rows();
  const double rate_hz = 1.0 / looked.clock.period_s;
  if (std::abs(rate_hz / nominal_hz - 1.0) > kRateTolerance)
    throw ConfigError(import.samples.string() +
                      format(": time_s: %.4g samples a second, but rate_hz is %.4g; allowed: within 1 %%",
                             rate_hz, nominal_hz));
  while (const auto pulse = input.next_pulse()) {
    looked.has_pulses = true;
    looked.pulses.mix(*pulse);
  }
  return looked;
}

/// The same input shall give the same record, and another another.  Marks are about the drive, not of the
/// node.
std::int64_t epoch_of(const Looked& looked, const SampleImport& import, const VehicleConfig& vehicle,
                      int node) {
  QuickDigest digest;
  const std::array sums{looked.samples.value(), looked.pulses.value(), static_cast<std::uint64_t>(node)};
  digest.mix<std::uint64_t>(sums);
  digest.mix<char>(vehicle.text);
  for (const TachometerColumn& tachometer : import.tachometer) {
    digest.mix<char>(tachometer.channel);
    digest.mix<int>(std::span(&tachometer.wheel, 1));
  }
  return static_cast<std::int64_t>(digest.value() >> 2) + 1;
}

/// Seals what the input holds, and compares it with what it held before.
class Sealing {
 public:
  Sealing(Input& input, Tachometers& tachometers, const SampleImport& import, const Looked& looked,
          ImportReport& report)
      : input_(input),
        tachometers_(tachometers),
        import_(import),
        looked_(looked),
        index_(looked.clock),
        report_(report) {}

  void run(std::deque<NodeImport>& nodes, ImportedRecord& record) {
    // Blocks wait for the end of a filter, for the edges of their angles and to be full.
    const double longest_wait_s = 2.0 + 200.0 * looked_.clock.period_s;
    pulse_ = input_.next_pulse();
    double square = 0.0;
    for (SampleRows rows; input_.read(rows); samples_.mix(rows)) {
      for (std::size_t k = 0; k < rows.rows(); ++k, ++row_) {
        const std::int64_t index = index_.next();
        time_s_ = looked_.clock.time_s(index);
        const double off_s = rows.time_s[k] - time_s_;
        square += off_s * off_s;
        report_.stamp_max_s = std::max(report_.stamp_max_s, std::abs(off_s));
        hand_over_pulses(nodes, instant(time_s_));
        for (const Pulse& pulse : tachometers_.read(rows.row(k), time_s_, looked_.clock.period_s))
          hand_over(nodes, pulse);
        for (NodeImport& node : nodes) node.add(rows.row(k), row_, index, instant(time_s_));
        report_.seconds = looked_.clock.period_s * static_cast<double>(index + 1);
      }
      record.write_before(std::llround((time_s_ - longest_wait_s) * 1e6));
    }
    hand_over_pulses(nodes, NodeTime::max());
    for (NodeImport& node : nodes) node.end();
    if (!(samples_ == looked_.samples)) refuse_change(import_.samples);
    if (!(pulses_ == looked_.pulses)) refuse_change(*import_.pulses);
    report_.stamp_rms_s = std::sqrt(square / static_cast<double>(row_));
  }

 private:
  void hand_over_pulses(std::deque<NodeImport>& nodes, NodeTime until) {
    for (; pulse_ && instant(pulse_->time_s) <= until; pulse_ = input_.next_pulse()) {
      pulses_.mix(*pulse_);
      hand_over(nodes, *pulse_);
    }
  }
  void hand_over(std::deque<NodeImport>& nodes, const Pulse& pulse) const {
    const WheelConfig& wheel = input_.wheel_of(pulse);
    for (NodeImport& node : nodes)
      if (node.node().name == wheel.node)
        node.add({instant(pulse.time_s), static_cast<std::uint8_t>(wheel.line), pulse.kind});
  }
  [[noreturn]] static void refuse_change(const std::filesystem::path& file) {
    throw ConfigError(file.string() + ": was written to while it was read; allowed: a file that is done");
  }

  Input& input_;
  Tachometers& tachometers_;
  const SampleImport& import_;
  const Looked& looked_;
  SampleIndex index_;
  ImportReport& report_;
  QuickDigest samples_, pulses_;
  std::optional<Pulse> pulse_;  ///< the next one
  std::int64_t row_ = 0;
  double time_s_ = 0.0;
};

std::string sha256_of(const std::filesystem::path& path) {
  const auto file = open_again_and_again(path);
  DigestOfBytes digest;
  std::vector<std::uint8_t> bytes(1 << 20);
  for (std::uint64_t at = 0; const std::size_t read = file->read_at(at, bytes); at += read)
    digest.add(std::span(bytes).first(read));
  return hexadecimal(digest.end());
}

/// The origin, as the record keeps it: the file, then the units as they were read.
std::vector<std::string> origin_of(const SampleImport& import, const ImportReport& report) {
  std::vector<std::string> notes{import.samples.filename().string() + ", SHA-256 " + report.sha256};
  std::string some;
  for (const ChannelUnit& unit : report.channels) {
    if (unit.meaning.empty()) continue;
    const std::string one =
        unit.channel + (unit.in_file.empty() ? "" : " in \"" + unit.in_file + "\"") + ": " + unit.meaning;
    if (!some.empty() && some.size() + 2 + one.size() > kMaxNoteBytes)
      notes.push_back(std::exchange(some, ""));
    some += (some.empty() ? "" : "; ") + one;
  }
  if (!some.empty()) notes.push_back(some);
  return notes;
}

}  // namespace

ImportReport import_samples(const SampleImport& import, const VehicleConfig& as_described,
                            std::stop_token stop, const ImportProgress& progress) {
  const VehicleConfig vehicle = with_unique_names(as_described);
  Part folder(import.folder, Part::Kind::kFolder);
  Input input(import, vehicle, std::move(stop), progress);
  const ColumnOf column = match_columns(import, input.columns(), vehicle);
  auto marks = import.marks ? read_marks(*import.marks) : std::vector<ImportedMark>();
  Tachometers tachometers(import, column);
  const Looked looked = look_through(input, tachometers, import, vehicle.node.front().rate_hz);

  ImportReport report;
  report.sha256 = sha256_of(import.samples);
  report.channels = input.units();
  report.rows = looked.rows;
  report.rate_hz = 1.0 / looked.clock.period_s;
  report.holes = looked.clock.hole;
  report.marks = marks.size();
  report.has_pulses = looked.has_pulses;
  ImportedRecord record(folder.part(), origin_of(import, report), std::llround(looked.clock.time_s(0) * 1e6),
                        std::move(marks));
  std::vector<NodeConfig> config = vehicle.node;
  std::deque<NodeImport> nodes;
  for (std::size_t n = 0; n < config.size(); ++n) {
    config[n].rate_hz = report.rate_hz;
    nodes.emplace_back(vehicle, config[n], column, epoch_of(looked, import, vehicle, config[n].id),
                       import.samples, [&record, n](const SealedBlock& block) { record.add(n, block); });
  }
  input.rewind();
  Sealing(input, tachometers, import, looked, report).run(nodes, record);
  report.tachometers = tachometers.report();
  for (const auto& tachometer : report.tachometers)
    report.has_pulses = report.has_pulses || tachometer.pulses > 0;
  record.finish();
  folder.keep();
  for (const NodeImport& node : nodes) {
    const NodeImport::Counts& counts = node.counts();
    report.nodes.push_back(
        {node.node().name, node.node().id, counts.blocks, counts.scans, counts.scans_missing, counts.edges});
    for (auto& [channel, what] : node.suspicions()) report.suspicions.push_back({channel, what});
  }
  return report;
}

}  // namespace roadbalance
