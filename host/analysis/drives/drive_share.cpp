#include "host/analysis/drives/drive_share.hpp"

#include <algorithm>
#include <exception>
#include <map>

#include "common/bus/codec.hpp"
#include "common/bus/notes.hpp"
#include "common/record/record_reader.hpp"
#include "common/text/format.hpp"
#include "host/analysis/drives/identify_record.hpp"
#include "host/analysis/identify/byte_archive.hpp"

namespace roadbalance {
namespace {

void note_scans(const SealedBlock& block, std::vector<MeasuredTime>& measured) {
  if (block.kind != BlockKind::kScan || block.header.scans == 0) return;
  const BlockHeader& header = block.header;
  const std::int64_t last_ns = header.time_ns + (header.scans - 1) * summary_of(block).period_ps / 1000;
  const auto same = std::find_if(measured.rbegin(), measured.rend(), [&](const MeasuredTime& time) {
    return time.node == header.node && time.epoch == header.epoch;
  });
  if (same == measured.rend())
    measured.push_back({header.node, header.epoch, header.time_ns, last_ns});
  else
    same->last_ns = std::max(same->last_ns, last_ns);
}

/// Maps the epochs of a recording that is made of another one (`rb select`, `rb reduce`) to the epochs
/// of the recording that was measured, also if that was a subset in turn.  Empty: it was measured
/// itself, or made before subsets held this.  An epoch's clock is that of its origin.
/// @throws std::system_error naming the folder if it cannot be read
std::map<std::int64_t, std::int64_t> subset_origins(const std::filesystem::path& folder) {
  RecordReader reader(folder);
  reader.finish();
  bool is_subset = false;  // noted before its first scan
  std::map<std::int64_t, std::int64_t> made_of;
  while (const auto event = reader.next()) {
    if (!is_subset && event->channel.ends_with("_SCAN")) return {};
    const auto note = event->channel == kNoteChannel ? decode_note(event->data) : std::nullopt;
    if (!note) continue;
    is_subset = is_subset || note->kind == NoteKind::kSubset;
    if (note->kind == NoteKind::kSubsetEpoch) made_of.emplace(note->a, note->b);
  }
  std::map<std::int64_t, std::int64_t> origins;
  for (const auto& [epoch, before] : made_of) {
    std::int64_t origin = before;
    // No more steps than there are notes: hostile ones may form a ring.
    for (std::size_t step = 0; step < made_of.size() && made_of.contains(origin); ++step)
      origin = made_of.at(origin);
    origins[epoch] = origin;
  }
  return origins;
}

/// A subset's epochs have numbers of their own.
void name_origins(const std::filesystem::path& recording, std::vector<MeasuredTime>& measured) {
  const auto origins = subset_origins(recording);
  for (MeasuredTime& time : measured)
    if (const auto origin = origins.find(time.epoch); origin != origins.end()) time.epoch = origin->second;
}

/// Empty: there is nothing wrong.
std::string damage(const RecordingDefects& defects) {
  if (defects.damaged_bytes == 0 && defects.refused_blocks == 0) return {};
  return format("damaged: %llu bytes unreadable, %lld blocks refused; rb verify lists them",
                static_cast<unsigned long long>(defects.damaged_bytes),
                static_cast<long long>(defects.refused_blocks));
}

std::string why_no_sections(const DriveSums& sums, const VehicleConfig& vehicle) {
  switch (sums.state) {
    case Unknown::kNone:
      return {};
    case Unknown::kTooSlow:
      return format("no section at %.0f km/h or more", 3.6 * vehicle.drive.least_speed_m_s);
    case Unknown::kTooShort:
      return format("too short: no section of %.0f s at a steady speed of %.0f km/h or more",
                    vehicle.drive.section_s, 3.6 * vehicle.drive.least_speed_m_s) +
             (sums.refusal.empty() ? "" : "; " + sums.refusal);
    default:
      return sums.refusal.empty() ? "tells nothing" : sums.refusal;
  }
}

template <typename Archive>
void fields(Archive& archive, DriveShare& share) {
  archive.text(share.unusable);
  archive(share.not_read);
  archive.text(share.contradictions);
  archive(share.missing_blocks);
  std::uint64_t times = share.measured.size();
  archive(times);
  if (times > archive.most(sizeof(MeasuredTime))) throw std::length_error("too short");
  share.measured.resize(times);
  for (MeasuredTime& time : share.measured) {
    archive(time.node);
    archive(time.epoch);
    archive(time.first_ns);
    archive(time.last_ns);
  }
}

}  // namespace

DriveShare share_of(const std::filesystem::path& recording, bool refine, const std::stop_token& stop) {
  DriveShare share;
  try {
    DrivenRecording drive = driven_recording(
        recording, refine, stop, [&](const SealedBlock& block) { note_scans(block, share.measured); });
    name_origins(recording, share.measured);
    share.missing_blocks = drive.defects.missing_blocks;
    share.contradictions = drive.contradictions;
    share.sums = drive.estimator->sums();
    share.sums->common_sigma_rad = drive.common_sigma_rad;
    share.unusable = damage(drive.defects);
    if (share.unusable.empty()) share.unusable = why_no_sections(*share.sums, *drive.vehicle);
  } catch (const Interrupted&) {
    throw;
  } catch (const std::exception& error) {
    share.unusable = error.what();
    share.not_read = true;
  }
  if (!share.unusable.empty()) share.sums.reset();
  return share;
}

std::vector<char> encode(const DriveShare& of) {
  DriveShare share = of;
  ByteWriter writer;
  fields(writer, share);
  if (!share.sums) return writer.bytes;
  const std::vector<char> sums = encode(*share.sums);
  writer.bytes.insert(writer.bytes.end(), sums.begin(), sums.end());
  return writer.bytes;
}

std::optional<DriveShare> decode_drive_share(std::span<const char> bytes) {
  ByteReader reader(bytes);
  DriveShare share;
  try {
    fields(reader, share);
  } catch (const std::length_error&) {
    return std::nullopt;
  }
  if (reader.ended()) return share;
  share.sums = decode_drive_sums(reader.left());
  if (!share.sums) return std::nullopt;
  return share;
}

}  // namespace roadbalance
