#include "common/config/address_query.hpp"

#include <algorithm>

namespace roadbalance {

AddressQuery::AddressQuery(const std::string& scheme, const std::string& address)
    : whole_(scheme + ":" + address), path_(address.substr(0, address.find('?'))) {
  std::string_view unread = address;
  unread.remove_prefix(std::min(unread.size(), path_.size() + 1));
  while (!unread.empty()) {
    const std::string_view pair = unread.substr(0, unread.find('&'));
    unread.remove_prefix(std::min(unread.size(), pair.size() + 1));
    const auto equals = pair.find('=');
    const std::string key(pair.substr(0, equals));
    const std::string_view value = equals == std::string_view::npos ? "" : pair.substr(equals + 1);
    if (!value_.emplace(key, value).second) fail("key '" + key + "' stands twice");
  }
}

std::optional<std::string> AddressQuery::text(const std::string& key) {
  asked_.push_back(key);
  const auto found = value_.find(key);
  return found == value_.end() ? std::nullopt : std::optional(found->second);
}

std::optional<double> AddressQuery::rate() {
  if (text("rate") == "max") return std::nullopt;
  asked_.pop_back();
  return number("rate", 1e-3, 1e6, ", or max").value_or(1.0);
}

void AddressQuery::fail(const std::string& reason) const {
  throw ConfigError(whole_ + ": " + reason);
}

void AddressQuery::finish() const {
  std::string known;
  for (const std::string& key : asked_) known += (known.empty() ? "" : ", ") + key;
  for (const auto& [key, value] : value_)
    if (std::find(asked_.begin(), asked_.end(), key) == asked_.end())
      fail("unknown key '" + key + "'; allowed: " + known);
}

}  // namespace roadbalance
