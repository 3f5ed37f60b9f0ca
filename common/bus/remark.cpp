#include "common/bus/remark.hpp"

#include <algorithm>
#include <wire/remark_t.hpp>

#include "common/bus/fields.hpp"

namespace roadbalance {
namespace wire_fields {

template <>
struct Fields<Remark> {
  using Wire = wire::remark_t;
  static void list(auto& field, auto& r, auto& m) {
    field(r.time_ns, m.time_ns);
    field(r.remarks, m.remarks, up_to(kMostRemarks));
    field(r.number, m.number, below(std::max(m.remarks, 1)));
    field.text(r.text, m.text, m.size);
  }
};

}  // namespace wire_fields

static_assert(sizeof(wire::remark_t::text) == kMostRemarkBytes);

std::vector<Remark> remarks_of(std::int64_t time_ns, const std::vector<std::string>& sentences) {
  if (sentences.empty()) return {{.time_ns = time_ns}};
  std::vector<Remark> remarks;
  const auto count = std::min(static_cast<std::int32_t>(sentences.size()), kMostRemarks);
  for (std::int32_t k = 0; k < count; ++k)
    remarks.push_back({time_ns, k, count, sentences[static_cast<std::size_t>(k)]});
  return remarks;
}

std::vector<std::uint8_t> encode(const Remark& remark) {
  return wire_fields::encode(remark);
}

std::optional<Remark> decode_remark(std::span<const std::uint8_t> bytes) {
  return wire_fields::decode<Remark>(bytes);
}

}  // namespace roadbalance
