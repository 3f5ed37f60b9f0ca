#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace roadbalance {

inline constexpr const char* kRemarkChannel = "RB_REMARK";
inline constexpr std::size_t kMostRemarkBytes = 800;
inline constexpr std::int32_t kMostRemarks = 16;

/// One sentence about the newest estimate; fields as in common/wire/remark_t.
struct Remark {
  std::int64_t time_ns = 0;
  std::int32_t number = 0;
  std::int32_t remarks = 0;  ///< at most kMostRemarks
  std::string text{};        ///< cut after kMostRemarkBytes
};

/// The messages that carry these sentences: one each, or one that there is none.
std::vector<Remark> remarks_of(std::int64_t time_ns, const std::vector<std::string>& sentences);

std::vector<std::uint8_t> encode(const Remark& remark);
std::optional<Remark> decode_remark(std::span<const std::uint8_t> bytes);

}  // namespace roadbalance
