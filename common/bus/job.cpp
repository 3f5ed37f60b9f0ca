#include "common/bus/job.hpp"

#include <cassert>
#include <wire/document_t.hpp>
#include <wire/job_t.hpp>

#include "common/bus/fields.hpp"

namespace roadbalance {
namespace wire_fields {

template <>
struct Fields<Job> {
  using Wire = wire::job_t;
  static void list(auto& field, auto& j, auto& m) {
    // Without jobs a single message reports that; its other fields mean nothing.
    const auto of_a_job = [&m](auto bound) {
      return [&m, bound](auto value) { return m.jobs == 0 || bound(value); };
    };
    field(j.jobs, m.jobs, up_to(kMostJobs));
    field(j.place, m.place, m.jobs == 0 ? up_to(0) : below(m.jobs));
    field(j.job, m.job);
    field(j.kind, m.kind, of_a_job(at_least(1)));
    field(j.state, m.state, of_a_job(within(JobState::kRunning, JobState::kInterrupted)));
    field.text(j.recording, m.recording);
    field.text(j.options, m.options);
    field(j.began_us, m.began_us);
    field(j.ended_us, m.ended_us);
    field(j.elapsed_s, m.elapsed_s, of_a_job(is_size));
    field(j.progress, m.progress, of_a_job(within(0.0, 1.0)));
    field(j.bytes, m.bytes, of_a_job(at_least(0)));
    field(j.bytes_to_read, m.bytes_to_read, of_a_job(at_least(0)));
    field(j.bytes_per_s, m.bytes_per_s, of_a_job(is_size));
    field(j.document_kind, m.document_kind, of_a_job(within(DocumentKind::kText, DocumentKind::kPage)));
    field(j.parts, m.parts, of_a_job(up_to(kMostParts)));
    field.text(j.transfer_to, m.transfer_to);
    field.text(j.text, m.text, m.size);
  }
};

template <>
struct Fields<DocumentPart> {
  using Wire = wire::document_t;
  static void list(auto& field, auto& d, auto& m) {
    field(d.place, m.place, below(kMostJobs));
    field(d.job, m.job);
    field(d.part, m.part);
    field(d.parts, m.parts, within(1, kMostParts));
    field.require(below(m.parts)(m.part));
    field.bytes(d.bytes, m.bytes, m.size, 1);
  }
};

}  // namespace wire_fields

static_assert(sizeof(wire::document_t::bytes) == kPartBytes);

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
  return wire_fields::encode(job);
}
std::vector<std::uint8_t> encode(const DocumentPart& part) {
  return wire_fields::encode(part);
}
std::optional<Job> decode_job(std::span<const std::uint8_t> bytes) {
  return wire_fields::decode<Job>(bytes);
}
std::optional<DocumentPart> decode_document_part(std::span<const std::uint8_t> bytes) {
  return wire_fields::decode<DocumentPart>(bytes);
}

}  // namespace roadbalance
