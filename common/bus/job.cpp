#include "common/bus/job.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>
#include <wire/document_t.hpp>
#include <wire/job_t.hpp>

#include "common/bus/wire_format.hpp"
#include "common/bus/wire_text.hpp"

namespace roadbalance {
namespace {

static_assert(sizeof(wire::document_t::bytes) == kPartBytes);

bool in_bounds(const wire::job_t& m) {
  if (m.jobs == 0) return m.place == 0;
  return 0 < m.jobs && m.jobs <= kMostJobs && 0 <= m.place && m.place < m.jobs && 1 <= m.kind &&
         static_cast<std::int32_t>(JobState::kRunning) <= m.state &&
         m.state <= static_cast<std::int32_t>(JobState::kInterrupted) && 0 <= m.progress && m.progress <= 1 &&
         0 <= m.elapsed_s && std::isfinite(m.elapsed_s) && 0 <= m.bytes && 0 <= m.bytes_to_read &&
         0 <= m.bytes_per_s && std::isfinite(m.bytes_per_s) &&
         static_cast<std::int32_t>(DocumentKind::kText) <= m.document_kind &&
         m.document_kind <= static_cast<std::int32_t>(DocumentKind::kPage) && 0 <= m.parts &&
         m.parts <= kMostParts;
}

}  // namespace

std::vector<DocumentPart> parts_of(const std::string& document, std::int32_t place, std::int64_t job) {
  assert(document.size() <= static_cast<std::size_t>(kMostParts) * kPartBytes);
  const auto parts = static_cast<std::int32_t>((document.size() + kPartBytes - 1) / kPartBytes);
  std::vector<DocumentPart> all;
  for (std::int32_t part = 0; part < parts; ++part)
    all.push_back({.place = place,
                   .job = job,
                   .part = part,
                   .parts = parts,
                   .bytes = document.substr(static_cast<std::size_t>(part) * kPartBytes, kPartBytes)});
  return all;
}

std::vector<std::uint8_t> encode(const Job& job) {
  wire::job_t m{};
  m.place = job.place;
  m.jobs = job.jobs;
  m.job = job.job;
  m.kind = static_cast<std::int32_t>(job.kind);
  m.state = static_cast<std::int32_t>(job.state);
  wire_text::put_text(job.recording, m.recording);
  wire_text::put_text(job.options, m.options);
  m.began_us = job.began_us;
  m.ended_us = job.ended_us;
  m.elapsed_s = job.elapsed_s;
  m.progress = job.progress;
  m.bytes = job.bytes;
  m.bytes_to_read = job.bytes_to_read;
  m.bytes_per_s = job.bytes_per_s;
  m.document_kind = static_cast<std::int32_t>(job.document_kind);
  m.parts = job.parts;
  wire_text::put_text(job.transfer_to, m.transfer_to);
  wire_text::put_text(job.text, m.text, m.size);
  return wire_format::encode(m);
}

std::optional<Job> decode_job(std::span<const std::uint8_t> bytes) {
  const auto m = wire_format::decode<wire::job_t>(bytes);
  if (!m || !in_bounds(*m)) return std::nullopt;
  auto text = wire_text::text_of(m->text, m->size);
  if (!text) return std::nullopt;
  return Job{.place = m->place,
             .jobs = m->jobs,
             .job = m->job,
             .kind = static_cast<JobKind>(m->kind),
             .state = static_cast<JobState>(m->state),
             .recording = wire_text::text_until_zero(m->recording),
             .options = wire_text::text_until_zero(m->options),
             .began_us = m->began_us,
             .ended_us = m->ended_us,
             .elapsed_s = m->elapsed_s,
             .progress = m->progress,
             .bytes = m->bytes,
             .bytes_to_read = m->bytes_to_read,
             .bytes_per_s = m->bytes_per_s,
             .document_kind = static_cast<DocumentKind>(m->document_kind),
             .parts = m->parts,
             .transfer_to = wire_text::text_until_zero(m->transfer_to),
             .text = std::move(*text)};
}

std::vector<std::uint8_t> encode(const DocumentPart& part) {
  wire::document_t m{};
  m.place = part.place;
  m.job = part.job;
  m.part = part.part;
  m.parts = part.parts;
  m.size = static_cast<std::int32_t>(std::min(part.bytes.size(), kPartBytes));
  std::copy_n(part.bytes.begin(), m.size, m.bytes);
  return wire_format::encode(m);
}

std::optional<DocumentPart> decode_document_part(std::span<const std::uint8_t> bytes) {
  const auto m = wire_format::decode<wire::document_t>(bytes);
  if (!m || m->place < 0 || m->place >= kMostJobs || m->parts < 1 || m->parts > kMostParts || m->part < 0 ||
      m->part >= m->parts || m->size < 1 || m->size > static_cast<std::int32_t>(kPartBytes))
    return std::nullopt;
  return DocumentPart{.place = m->place,
                      .job = m->job,
                      .part = m->part,
                      .parts = m->parts,
                      .bytes = std::string(m->bytes, m->bytes + m->size)};
}

}  // namespace roadbalance
