#include "common/dbc/dbc.hpp"

#include <algorithm>
#include <charconv>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "common/config/section.hpp"
#include "common/config/text_file.hpp"
#include "common/dbc/dbc_tokens.hpp"

namespace roadbalance {
namespace {

/// From the words of a DBC file to its messages; see Dbc.
class DbcReader {
 public:
  DbcReader(std::string_view text, const std::string& name) : tokens_(text, name) {}

  /// @throws ConfigError "name:line: expected ..., found ..."
  std::vector<DbcMessage> read();

 private:
  using Id = std::int64_t;  // as the file writes it: bit 31 marks a long one

  void read_section();
  void read_message();
  void read_signal(DbcMessage& message);
  void read_multiplexing(DbcSignal& signal);
  void read_place(const DbcMessage& message, DbcSignal& signal);
  void read_meaning(DbcSignal& signal);
  void check_multiplexing(const DbcMessage& message) const;
  void read_codes();
  void read_number_kind();
  DbcSignal* take_signal();
  void skip_names();
  void skip_line();
  void skip_to_semicolon(const DbcToken& section);

  DbcTokens tokens_;
  std::vector<DbcMessage> messages_;
  std::map<Id, std::size_t> by_id_;
  std::set<std::string, std::less<>> names_;
};

constexpr std::int64_t kLongIdMark = 1LL << 31;
// The pseudo-message that editors keep signals in which belong to no message.
constexpr std::int64_t kUnusedSignals = 0xC000'0000;
constexpr std::int64_t kLongestTransported = 1785;  // bytes, of SAE J1939-21
constexpr std::int64_t kHighestStartBit = 8 * kLongestTransported - 1;

std::vector<DbcMessage> DbcReader::read() {
  while (tokens_.peek().kind != DbcToken::Kind::kEnd) read_section();
  // The pseudo-message has served its VAL_ lines.
  std::erase_if(messages_, [](const DbcMessage& message) { return message.name.empty(); });
  return std::move(messages_);
}

void DbcReader::read_section() {
  const DbcToken section = tokens_.peek();
  if (section.kind != DbcToken::Kind::kName) tokens_.fail_expected("a section such as BO_,");
  if (section.text == "BO_") return read_message();
  if (section.text == "SG_") tokens_.fail(section.line, "SG_ stands outside of a message (BO_)");
  if (section.text == "SG_MUL_VAL_")
    tokens_.fail(section.line, "extended multiplexing (SG_MUL_VAL_) is not supported");
  tokens_.take();
  if (section.text == "VERSION") {
    static_cast<void>(tokens_.quoted("the version"));
  } else if (section.text == "NS_" || section.text == "BU_") {
    tokens_.expect(':', section.text == "NS_" ? "after NS_," : "after BU_,");
    skip_names();
  } else if (section.text == "BS_") {
    tokens_.expect(':', "after BS_,");
    skip_line();
  } else if (section.text == "VAL_") {
    read_codes();
  } else if (section.text == "SIG_VALTYPE_") {
    read_number_kind();
  } else {
    skip_to_semicolon(section);
  }
}

void DbcReader::read_message() {
  DbcMessage message;
  message.line = tokens_.take().line;
  const Id id = tokens_.integer("the message's identifier", 0, UINT32_MAX);
  message.extended = (id & kLongIdMark) != 0;
  message.id = static_cast<std::uint32_t>(id & ~kLongIdMark);
  if (id != kUnusedSignals && message.id > (message.extended ? kHighestExtendedId : kHighestStandardId))
    tokens_.fail(message.line, "message " + std::to_string(id) +
                                   ": the identifier has more than 11 bits, or 29 beside bit 31");
  message.name = tokens_.name("the message's name,");
  tokens_.expect(':', "after the message's name,");
  message.size = static_cast<std::size_t>(tokens_.integer("the message's bytes", 0, kLongestTransported));
  message.sender = tokens_.name("the message's sender,");

  const auto earlier = by_id_.find(id);
  if (earlier != by_id_.end())
    tokens_.fail(message.line, "message " + std::to_string(id) + " is there already in line " +
                                   std::to_string(messages_[earlier->second].line));
  if (!names_.insert(message.name).second)
    tokens_.fail(message.line, "a message " + message.name + " is there already");
  if (messages_.size() >= Dbc::kMostMessages)
    tokens_.fail(message.line, "more than " + std::to_string(Dbc::kMostMessages) + " messages");

  const bool unused = id == kUnusedSignals;
  if (unused) message.size = static_cast<std::size_t>(kLongestTransported);
  while (tokens_.next_is("SG_")) read_signal(message);
  check_multiplexing(message);
  if (unused) message.name.clear();
  by_id_[id] = messages_.size();
  messages_.push_back(std::move(message));
}

// SG_ name [M|m3] : start|length@order sign (scale,offset) [low|high] "unit" receiver,...
void DbcReader::read_signal(DbcMessage& message) {
  DbcSignal signal;
  signal.line = tokens_.take().line;
  signal.name = tokens_.name("the signal's name,");
  if (message.signal(signal.name))
    tokens_.fail(signal.line, "signal " + signal.name + " is there already in message " + message.name);
  if (message.signals.size() >= Dbc::kMostSignals)
    tokens_.fail(signal.line, "message " + message.name + " has more than " +
                                  std::to_string(Dbc::kMostSignals) + " signals");
  if (!tokens_.next_is(':')) read_multiplexing(signal);
  tokens_.expect(':', "after the signal's name,");
  read_place(message, signal);
  read_meaning(signal);
  while (!tokens_.peek().begins_line &&
         (tokens_.peek().kind == DbcToken::Kind::kName || tokens_.next_is(',')))
    tokens_.take();
  message.signals.push_back(std::move(signal));
}

void DbcReader::read_multiplexing(DbcSignal& signal) {
  const int line = tokens_.peek().line;
  const std::string_view mark = tokens_.name("\":\", M or m and a number after the signal's name,");
  if (mark == "M") {
    signal.is_multiplexor = true;
    return;
  }
  std::uint32_t value = 0;
  const char* const end = mark.data() + mark.size();
  const auto [after, error] = std::from_chars(mark.data() + 1, end, value);
  const bool numbered = mark.front() == 'm' && error == std::errc();
  if (numbered && after + 1 == end && *after == 'M')
    tokens_.fail(line, "signal " + signal.name + ": extended multiplexing (" + std::string(mark) +
                           ") is not supported");
  if (!numbered || after != end)
    tokens_.fail(line, "expected \":\", M or m and a number after the signal's name, found \"" +
                           std::string(mark.substr(0, 30)) + "\"");
  signal.when_bits = value;
}

void DbcReader::read_place(const DbcMessage& message, DbcSignal& signal) {
  CanSignal& place = signal.place;
  place.start_bit = static_cast<int>(tokens_.integer("the start bit", 0, kHighestStartBit));
  tokens_.expect('|', "between start bit and length,");
  place.length = static_cast<int>(tokens_.integer("the length in bits", 1, 64));
  tokens_.expect('@', "after the length,");
  place.order = tokens_.integer("the byte order, 0 Motorola or 1 Intel", 0, 1) == 0
                    ? ByteOrder::kBigEndian
                    : ByteOrder::kLittleEndian;
  if (tokens_.take_if('-')) {
    place.number = CanNumber::kSigned;
  } else {
    tokens_.expect('+', "or \"-\", the signal's sign,");
  }
  if (!place.fits(message.size))
    tokens_.fail(signal.line, "signal " + signal.name + " does not fit into the " +
                                  std::to_string(message.size) + " bytes of message " + message.name);
}

void DbcReader::read_meaning(DbcSignal& signal) {
  tokens_.expect('(', "before scale and offset,");
  signal.place.scale = tokens_.number("the scale,");
  if (signal.place.scale == 0.0) tokens_.fail(signal.line, "signal " + signal.name + ": the scale is 0");
  tokens_.expect(',', "between scale and offset,");
  signal.place.offset = tokens_.number("the offset,");
  tokens_.expect(')', "after scale and offset,");
  tokens_.expect('[', "before the range,");
  signal.low = tokens_.number("the range's lower end,");
  tokens_.expect('|', "between the ends of the range,");
  signal.high = tokens_.number("the range's upper end,");
  if (signal.low > signal.high)
    tokens_.fail(signal.line, "signal " + signal.name + ": the range ends below its beginning");
  tokens_.expect(']', "after the range,");
  signal.unit = tokens_.quoted("the unit");
}

void DbcReader::check_multiplexing(const DbcMessage& message) const {
  const DbcSignal* const multiplexor = message.multiplexor();
  for (const DbcSignal& signal : message.signals) {
    if (signal.is_multiplexor && &signal != multiplexor)
      tokens_.fail(signal.line, "message " + message.name + " has a second multiplexor, " + signal.name);
    if (signal.when_bits && !multiplexor)
      tokens_.fail(signal.line, "signal " + signal.name + " is multiplexed, but message " + message.name +
                                    " has no multiplexor");
    if (signal.when_bits && multiplexor->place.length < 64 &&
        *signal.when_bits >> multiplexor->place.length != 0)
      tokens_.fail(signal.line, "signal " + signal.name + ": its multiplexor " + multiplexor->name +
                                    " never has that value");
  }
}

/// "identifier signal" of VAL_ and SIG_VALTYPE_.
DbcSignal* DbcReader::take_signal() {
  const int line = tokens_.peek().line;
  const Id id = tokens_.integer("a message's identifier", 0, UINT32_MAX);
  const auto found = by_id_.find(id);
  if (found == by_id_.end()) tokens_.fail(line, "there is no message " + std::to_string(id));
  DbcMessage& message = messages_[found->second];
  const std::string_view name = tokens_.name("a signal's name,");
  const auto signal = std::ranges::find(message.signals, name, &DbcSignal::name);
  if (signal == message.signals.end())
    tokens_.fail(line, "message " + std::to_string(id) + " has no signal " + std::string(name));
  return &*signal;
}

// VAL_ identifier signal 0 "text" 1 "text" ;   or of an environment variable: VAL_ name 0 "text" ;
void DbcReader::read_codes() {
  const DbcToken first = tokens_.peek();
  DbcSignal* const signal = first.kind == DbcToken::Kind::kName ? nullptr : take_signal();
  if (!signal) tokens_.take();
  std::size_t count = 0;
  while (!tokens_.take_if(';')) {
    DbcCode code;
    code.raw = tokens_.number("a value or \";\",");
    code.meaning = tokens_.quoted("the value's meaning");
    if (++count > Dbc::kMostCodes)
      tokens_.fail(first.line, "more than " + std::to_string(Dbc::kMostCodes) + " values");
    if (signal) signal->codes.push_back(std::move(code));
  }
}

// SIG_VALTYPE_ identifier signal : 0 | 1 | 2 ;
void DbcReader::read_number_kind() {
  const int line = tokens_.peek().line;
  DbcSignal& signal = *take_signal();
  tokens_.take_if(':');  // some editors leave it out
  const auto kind = tokens_.integer("the kind of number, 0 integer, 1 float or 2 double", 0, 2);
  tokens_.expect(';', "after SIG_VALTYPE_,");
  if (kind == 0) return;
  const int bits = kind == 1 ? 32 : 64;
  if (signal.place.length != bits)
    tokens_.fail(line, "signal " + signal.name + " has " + std::to_string(signal.place.length) +
                           " bits, its kind of number " + std::to_string(bits));
  signal.place.number = kind == 1 ? CanNumber::kFloat : CanNumber::kDouble;
}

/// Names up to the next section: NS_ lists words that begin sections too, but a section goes on with
/// something else than another word at the margin.
void DbcReader::skip_names() {
  while (tokens_.peek().kind == DbcToken::Kind::kName) {
    const DbcToken& after = tokens_.peek(1);
    const bool section =
        tokens_.peek().at_margin && !(after.kind == DbcToken::Kind::kName && after.begins_line);
    if (section || after.kind == DbcToken::Kind::kMark) return;
    tokens_.take();
  }
}

void DbcReader::skip_line() {
  while (!tokens_.peek().begins_line) tokens_.take();
}

void DbcReader::skip_to_semicolon(const DbcToken& section) {
  while (!tokens_.take_if(';')) {
    const DbcToken& next = tokens_.peek();
    // A forgotten end must not swallow messages.
    if (next.kind == DbcToken::Kind::kEnd || (next.at_margin && next.text == "BO_"))
      tokens_.fail(next.line, "expected \";\" after section " + std::string(section.text) + " of line " +
                                  std::to_string(section.line) + ", found " + next.shown());
    tokens_.take();
  }
}

}  // namespace

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
  return parse(read_text_file(path, kMostBytes), path);
}

const DbcMessage* Dbc::message(std::string_view name) const {
  const auto found = std::ranges::find(messages, name, &DbcMessage::name);
  return found == messages.end() ? nullptr : &*found;
}

}  // namespace roadbalance
