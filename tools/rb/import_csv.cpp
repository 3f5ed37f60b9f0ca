#include "tools/rb/import_csv.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <utility>

#include "common/bus/bus.hpp"
#include "common/bus/codec.hpp"
#include "common/config/section.hpp"
#include "common/record/part.hpp"
#include "common/record/record.hpp"
#include "firmware/seal_all.hpp"
#include "host/recorder/manifest.hpp"
#include "host/recorder/preamble.hpp"
#include "tools/rb/csv_front_end.hpp"
#include "tools/rb/csv_table.hpp"
#include "tools/rb/suspicion.hpp"

namespace roadbalance {

namespace {

constexpr double kRateTolerance = 0.01;
using ColumnOf = std::map<std::string, std::size_t>;

/// Every column is wanted by a channel and every channel in use has a column.
ColumnOf match_columns(const CsvImport& import, const SampleTable& table, const VehicleConfig& vehicle) {
  ColumnOf column;
  for (std::size_t c = 0; c < table.name.size(); ++c) column[table.name[c]] = c;
  ColumnOf unwanted = column;
  for (const auto& node : vehicle.node)
    for (const auto& channel : node.channel) {
      unwanted.erase(channel.name);
      if (channel.role != ChannelRole::kUnused && !column.contains(channel.name))
        throw ConfigError(import.samples.string() + ": no column for channel " + channel.name + " of node " +
                          node.name + "; allowed: a column of that name, or role = \"unused\"");
    }
  std::erase_if(unwanted, [](const auto& named) { return is_reference_column(named.first); });
  if (!unwanted.empty())
    throw ConfigError(import.samples.string() + ": column " + unwanted.begin()->first +
                      ": no node has a channel of that name");
  return column;
}

SampleClock clock_of(const CsvImport& import, const SampleTable& table, double nominal_hz) {
  SampleClock clock;
  try {
    clock = fit_sample_clock(table.time_s, nominal_hz);
  } catch (const std::invalid_argument& error) {
    throw ConfigError(import.samples.string() + ": time_s: " + error.what());
  }
  const double rate_hz = 1.0 / clock.period_s;
  if (std::abs(rate_hz / nominal_hz - 1.0) <= kRateTolerance) return clock;
  char text[160];
  std::snprintf(text, sizeof text,
                ": time_s: %.4g samples a second, but rate_hz is %.4g; allowed: within 1 %%", rate_hz,
                nominal_hz);
  throw ConfigError(import.samples.string() + text);
}

NodeTime instant(double seconds) {
  return node_time_from_ns(std::llround(seconds * 1e9));
}

/// Rows in which a node's cells are all empty are scans that it has not; [row].
/// @throws ConfigError if only some are
std::vector<bool> rows_of(const CsvImport& import, const NodeConfig& node, const SampleTable& table,
                          const ColumnOf& column) {
  std::vector<std::size_t> columns;
  for (const ChannelConfig& channel : node.channel)
    if (const auto found = column.find(channel.name); found != column.end()) columns.push_back(found->second);
  std::vector<bool> there(table.time_s.size(), true);
  for (std::size_t row = 0; row < there.size(); ++row) {
    const auto is_empty = [&](std::size_t c) { return std::isnan(table.value_si[c][row]); };
    const auto empty = std::count_if(columns.begin(), columns.end(), is_empty);
    there[row] = empty == 0;
    if (empty != 0 && empty != std::ssize(columns))
      throw ConfigError(import.samples.string() + ": sample " + std::to_string(row + 1) + ": " +
                        table.name[*std::find_if(columns.begin(), columns.end(), is_empty)] +
                        ": is empty; allowed: a number, or all channels of node " + node.name +
                        " empty where it has no sample");
  }
  return there;
}

std::vector<Scan> scans_of(const NodeConfig& node, const SampleTable& table, const ColumnOf& column,
                           const SampleClock& clock, const std::vector<bool>& there) {
  std::vector<Scan> scans(table.time_s.size());
  for (std::size_t row = 0; row < scans.size(); ++row) {
    scans[row].index = clock.index[row];
    scans[row].time = instant(clock.first_s + clock.period_s * static_cast<double>(clock.index[row]));
  }
  for (std::size_t k = 0; k < node.channel.size(); ++k) {
    const ChannelConfig& channel = node.channel[k];
    const auto found = column.find(channel.name);
    if (found == column.end()) continue;  // unused, its counts stay 0
    for (std::size_t row = 0; row < scans.size(); ++row) {
      if (!there[row]) continue;
      const double value = table.value_si[found->second][row];
      const double counts = value / channel.scale_m_s2_per_count + channel.offset_counts;
      constexpr double kLimit = kFullScaleCounts - 1;
      scans[row].counts[k] = static_cast<std::int32_t>(std::lround(std::clamp(counts, -kLimit, kLimit)));
      if (std::abs(value) >= kClipped * channel.range_m_s2 || std::abs(counts) > kLimit)
        scans[row].overload |= 1U << k;
    }
  }
  std::vector<Scan> taken;
  for (std::size_t row = 0; row < scans.size(); ++row)
    if (there[row]) taken.push_back(scans[row]);
  return taken;
}

std::vector<Edge> edges_of(const NodeConfig& node, const VehicleConfig& vehicle,
                           const std::vector<Pulse>& pulses) {
  std::vector<Edge> edges;
  for (const Pulse& pulse : pulses) {
    const WheelConfig& wheel = vehicle.wheel[static_cast<std::size_t>(pulse.wheel)];
    if (wheel.node == node.name)
      edges.push_back({instant(pulse.time_s), static_cast<std::uint8_t>(wheel.line), pulse.kind});
  }
  return edges;
}

std::vector<Pulse> pulses_of(const CsvImport& import, const VehicleConfig& vehicle) {
  if (!import.pulses) return {};
  auto pulses = read_pulses(*import.pulses);
  for (const Pulse& pulse : pulses) {
    const WheelConfig& wheel = vehicle.wheel[static_cast<std::size_t>(pulse.wheel)];
    if (wheel.node.empty())
      throw ConfigError(
          import.pulses->string() + ": wheel " + wheel.name +
          ": no node reads its encoder; allowed: " + "node and [wheel.encoder] in the vehicle's description");
  }
  return pulses;
}

/// The same input shall give the same record, and another another: the epoch is a digest of samples, pulses
/// and vehicle (FNV-1a).  Marks are about the drive, not of the node.
std::int64_t epoch_of(const SampleTable& table, const std::vector<Pulse>& pulses,
                      const VehicleConfig& vehicle, int node) {
  std::uint64_t hash = 14695981039346656037ULL;
  const auto mix = [&](const void* data, std::size_t size) {
    for (std::size_t i = 0; i < size; ++i)
      hash = (hash ^ static_cast<const unsigned char*>(data)[i]) * 1099511628211ULL;
  };
  mix(&node, sizeof node);
  mix(table.time_s.data(), table.time_s.size() * sizeof(double));
  for (const auto& column : table.value_si) mix(column.data(), column.size() * sizeof(double));
  for (const Pulse& pulse : pulses) {
    mix(&pulse.time_s, sizeof pulse.time_s);
    mix(&pulse.wheel, sizeof pulse.wheel);
    mix(&pulse.kind, sizeof pulse.kind);
  }
  mix(vehicle.text.data(), vehicle.text.size());
  return static_cast<std::int64_t>(hash >> 2) + 1;
}

/// All nodes side by side, as a recorder would have got them.  Within a node the order stays that of the
/// sequence: an edge block bears the time of its first edge, before scans that are sealed already.
/// @returns microseconds, index into `blocks`
std::vector<std::pair<std::int64_t, std::size_t>> arrivals(const std::vector<SealedBlock>& blocks) {
  std::map<std::int32_t, std::int64_t> latest_ns;
  std::vector<std::pair<std::int64_t, std::size_t>> order;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const BlockHeader& header = blocks[i].header;
    std::int64_t& latest = latest_ns.try_emplace(header.node, header.time_ns).first->second;
    latest = std::max(latest, header.time_ns);
    order.emplace_back(latest / 1000, i);
  }
  std::stable_sort(order.begin(), order.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  return order;
}

/// What stands in the record beside the blocks: where they are from, and the marks, each between the blocks
/// that came before and after its instant.
class ImportNotes {
 public:
  ImportNotes(RecordWriter& record, const CsvImport& import, std::vector<ImportedMark> marks)
      : record_(record), marks_(std::move(marks)) {
    put({.kind = NoteKind::kImported, .text = import.samples.filename().string()}, 0);
  }
  /// Those before an instant, in us.
  void put_before(std::int64_t time_us) {
    for (; next_ < marks_.size() && to_us(marks_[next_]) < time_us; ++next_) put(marks_[next_]);
  }
  void put_rest() {
    for (; next_ < marks_.size(); ++next_) put(marks_[next_]);
  }

 private:
  static std::int64_t to_us(const ImportedMark& mark) { return std::llround(mark.time_s * 1e6); }
  void put(const ImportedMark& mark) {
    put({.host_ns = std::llround(mark.time_s * 1e9),
         .kind = NoteKind::kMark,
         .a = mark.number,
         .text = mark.text},
        to_us(mark));
  }
  void put(const Note& note, std::int64_t time_us) { record_.append(kNoteChannel, encode(note), time_us); }

  RecordWriter& record_;
  const std::vector<ImportedMark> marks_;
  std::size_t next_ = 0;
};

void write_folder(const std::filesystem::path& folder, const CsvImport& import,
                  const std::vector<SealedBlock>& blocks, const std::vector<ImportedMark>& marks) {
  std::map<NodeEpoch, std::vector<SealedBlock>> metas;
  for (const auto& block : blocks)
    if (block.kind == BlockKind::kMeta) metas[{block.header.node, block.header.epoch}].push_back(block);
  RecordWriter record({.folder = folder});
  record.set_preamble(make_preamble(metas));
  ImportNotes notes(record, import, marks);
  for (const auto& [time_us, i] : arrivals(blocks)) {
    notes.put_before(time_us);
    record.append(block_channel(blocks[i].header.node, blocks[i].kind), blocks[i].bytes(), time_us);
  }
  notes.put_rest();
  record.sync();
  record.close();
  write_manifest(folder);
}

/// The folder appears with all it is to hold, or not at all.
void write_whole(const CsvImport& import, const std::vector<SealedBlock>& blocks,
                 const std::vector<ImportedMark>& marks) {
  Part folder(import.folder, Part::Kind::kFolder);
  write_folder(folder.part(), import, blocks, marks);
  folder.keep();
}

}  // namespace

CsvImportReport import_csv(const CsvImport& import, const VehicleConfig& vehicle) {
  if (std::filesystem::exists(import.folder) && !std::filesystem::is_empty(import.folder))
    throw ConfigError(import.folder.string() + ": holds something already; allowed: a new or empty folder");
  const SampleTable table = import.read(import.samples);
  const ColumnOf column = match_columns(import, table, vehicle);
  const SampleClock clock = clock_of(import, table, vehicle.node.front().rate_hz);
  const std::vector<Pulse> pulses = pulses_of(import, vehicle);
  const auto marks = import.marks ? read_marks(*import.marks) : std::vector<ImportedMark>();

  CsvImportReport report;
  report.rows = static_cast<std::int64_t>(table.time_s.size());
  report.rate_hz = 1.0 / clock.period_s;
  report.seconds = clock.period_s * static_cast<double>(clock.index.back() + 1);
  report.stamp_rms_s = clock.stamp_rms_s;
  report.stamp_max_s = clock.stamp_max_s;
  report.holes = clock.hole;
  report.has_pulses = !pulses.empty();
  report.marks = marks.size();
  std::vector<SealedBlock> blocks;
  for (NodeConfig node : vehicle.node) {
    node.rate_hz = report.rate_hz;
    for (const auto& channel : node.channel) {
      const auto found = column.find(channel.name);
      if (found == column.end() || channel.role != ChannelRole::kAcceleration) continue;
      for (auto& what : suspicions_of(table.value_si[found->second], channel, report.rate_hz))
        report.suspicions.push_back({channel.name, std::move(what)});
    }
    const std::vector<bool> there = rows_of(import, node, table, column);
    CsvFrontEnd source(scans_of(node, table, column, clock, there), edges_of(node, vehicle, pulses));
    auto& counts = report.nodes.emplace_back(CsvImportReport::Node{node.name, node.id, 0, 0, 0, 0});
    const auto take = [&](const SealedBlock& block) {
      ++counts.blocks;
      if (block.kind == BlockKind::kScan) counts.scans += block.header.scans;
      if (block.kind == BlockKind::kGap) counts.scans_missing += block.header.scans;
      if (block.kind == BlockKind::kEdge) counts.edges += decode_edge(block).edges;
      blocks.push_back(block);
    };
    seal_all(source, vehicle, node, epoch_of(table, pulses, vehicle, node.id), take, GapCause::kSourceGap);
  }
  write_whole(import, blocks, marks);
  return report;
}

}  // namespace roadbalance
