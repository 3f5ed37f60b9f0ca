#include "firmware/backends/dbc/dbc.hpp"

#include <algorithm>

#include "common/config/section.hpp"
#include "common/config/text_file.hpp"
#include "firmware/backends/dbc/dbc_reader.hpp"

namespace roadbalance {

const DbcSignal* DbcMessage::signal(std::string_view signal_name) const {
  const auto found = std::ranges::find(signals, signal_name, &DbcSignal::name);
  return found == signals.end() ? nullptr : &*found;
}

const DbcSignal* DbcMessage::multiplexor() const {
  const auto found = std::ranges::find(signals, true, &DbcSignal::is_multiplexor);
  return found == signals.end() ? nullptr : &*found;
}

Dbc Dbc::parse(std::string_view text, const std::string& name_for_errors) {
  if (text.size() > kMostBytes)
    throw ConfigError(name_for_errors + ": a DBC file of " + std::to_string(text.size()) +
                      " bytes; allowed: " + std::to_string(kMostBytes));
  return {.file = name_for_errors, .messages = DbcReader(text, name_for_errors).read()};
}

Dbc Dbc::read_file(const std::string& path) {
  return parse(read_text_file(path), path);
}

const DbcMessage* Dbc::message(std::string_view name) const {
  const auto found = std::ranges::find(messages, name, &DbcMessage::name);
  return found == messages.end() ? nullptr : &*found;
}

}  // namespace roadbalance
