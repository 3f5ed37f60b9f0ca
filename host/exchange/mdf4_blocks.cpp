#include "host/exchange/mdf4_blocks.hpp"

#include <algorithm>

namespace roadbalance {
namespace {

constexpr std::size_t kHeader = 24;

}  // namespace

void Mdf4Blocks::identify(std::string_view program) {
  Mdf4Fields id;
  std::string name(program.substr(0, 8));
  name.resize(8, ' ');
  id.text("MDF     ").text("4.10    ").text(name).zeros(4);
  id << std::uint16_t{410};
  id.zeros(30 + 2 + 2);  // finished: no flags
  bytes_.assign(id.bytes().begin(), id.bytes().end());
}

Mdf4Blocks::Position Mdf4Blocks::add(std::string_view id, std::vector<Position> links,
                                     std::span<const std::uint8_t> data) {
  const Position at = bytes_.size();
  Mdf4Fields block;
  block.text("##").text(id).zeros(4);
  block << std::uint64_t{kHeader + 8 * links.size() + data.size()} << std::uint64_t{links.size()};
  for (const Position link : links) block << link;
  bytes_.insert(bytes_.end(), block.bytes().begin(), block.bytes().end());
  bytes_.insert(bytes_.end(), data.begin(), data.end());
  bytes_.resize((bytes_.size() + 7) / 8 * 8, 0);
  return at;
}

Mdf4Blocks::Position Mdf4Blocks::add_zero_ended(std::string_view id, std::string_view text) {
  std::vector<std::uint8_t> data(text.begin(), text.end());
  std::replace(data.begin(), data.end(), std::uint8_t{0}, std::uint8_t{' '});
  data.resize((text.size() + 8) / 8 * 8, 0);  // at least one zero
  return add(id, {}, data);
}

void Mdf4Blocks::set_link(Position block, std::size_t link, Position to) {
  std::memcpy(bytes_.data() + block + kHeader + 8 * link, &to, sizeof to);
}

}  // namespace roadbalance
