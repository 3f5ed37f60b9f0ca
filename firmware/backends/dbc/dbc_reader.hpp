#pragma once

#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "firmware/backends/dbc/dbc.hpp"
#include "firmware/backends/dbc/dbc_tokens.hpp"

namespace roadbalance {

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

}  // namespace roadbalance
