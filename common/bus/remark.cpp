#include "common/bus/remark.hpp"

#include <algorithm>
#include <utility>
#include <wire/remark_t.hpp>

#include "common/bus/wire_format.hpp"
#include "common/bus/wire_text.hpp"

namespace roadbalance {

static_assert(sizeof(wire::remark_t::text) == kMostRemarkBytes);

std::vector<Remark> remarks_of(std::int64_t time_ns, const std::vector<std::string>& sentences) {
  if (sentences.empty()) return {{.time_ns = time_ns}};
  std::vector<Remark> remarks;
  const auto count = std::min(static_cast<std::int32_t>(sentences.size()), kMostRemarks);
  for (std::int32_t k = 0; k < count; ++k)
    remarks.push_back({time_ns, k, count, sentences[static_cast<std::size_t>(k)]});
  return remarks;
}

std::vector<std::uint8_t> encode(const Remark& r) {
  wire::remark_t m{};
  m.time_ns = r.time_ns;
  m.number = r.number;
  m.remarks = r.remarks;
  wire_text::put_text(r.text, m.text, m.size);
  return wire_format::encode(m);
}

std::optional<Remark> decode_remark(std::span<const std::uint8_t> bytes) {
  const auto m = wire_format::decode<wire::remark_t>(bytes);
  if (!m || m->remarks < 0 || m->remarks > kMostRemarks || m->number < 0 ||
      m->number >= std::max(m->remarks, 1))
    return std::nullopt;
  auto text = wire_text::text_of(m->text, m->size);
  if (!text) return std::nullopt;
  return Remark{m->time_ns, m->number, m->remarks, std::move(*text)};
}

}  // namespace roadbalance
