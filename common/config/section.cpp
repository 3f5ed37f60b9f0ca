#include "common/config/section.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>
#include <sstream>
#include <utility>

#include "common/config/text_file.hpp"
#include "common/config/toml_library.hpp"
#include "common/text/printable.hpp"

namespace roadbalance {
namespace {

std::string written(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", value);
  return text;
}

std::string join(const std::vector<std::string>& words) {
  std::string text;
  for (const auto& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

std::string allowed_numbers(Range range) {
  if (range.low == kPositive.low)
    return range.high == kPositive.high ? "a number > 0" : "0 < number <= " + written(range.high);
  if (range.low == kAnyNumber.low && range.high == kAnyNumber.high) return "a number";
  if (range.high == kNotNegative.high) return "a number >= " + written(range.low);
  return "a number " + written(range.low) + " .. " + written(range.high);
}

/// Name without its unit: "body_mass" of body_mass_kg and of body_mass_g.
std::string stem(std::string key) {
  static const std::set<std::string> kUnits{
      "m",  "mm", "cm", "km", "s",   "s2",  "ms",  "us",  "min",  "h",   "kg",    "g",      "t",      "n",
      "kn", "nm", "m2", "hz", "khz", "rpm", "deg", "rad", "deg2", "per", "count", "counts", "percent"};
  for (auto place = key.rfind('_'); place != std::string::npos; place = key.rfind('_')) {
    if (!kUnits.contains(key.substr(place + 1))) break;
    key.resize(place);
  }
  return key;
}

/// Whether one is the other but for its unit or up to two slips of the pen, one in a short word.
bool resembles(const std::string& one, const std::string& other) {
  const std::string a = stem(one), b = stem(other);
  if (a == b) return true;
  if (std::min(a.size(), b.size()) < 3) return false;  // so short ones are alike anyway
  std::vector<std::size_t> distance(b.size() + 1);     // Levenshtein's, of a's beginning to each of b's
  for (std::size_t j = 0; j <= b.size(); ++j) distance[j] = j;
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = std::exchange(distance[0], i + 1);
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t changed = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = distance[j + 1];
      distance[j + 1] = std::min({changed, distance[j] + 1, distance[j + 1] + 1});
    }
  }
  return distance.back() <= (std::min(a.size(), b.size()) < 5 ? 1 : 2);
}

}  // namespace

std::string did_you_mean(const std::string& word, const std::vector<std::string>& known) {
  for (const std::string& one : known)
    if (resembles(one, word)) return " (did you mean " + one + "?)";
  return {};
}

struct Section::State {
  std::shared_ptr<const toml::table> root;  // keeps `table` alive
  const toml::table* table = nullptr;
  std::string file;
  mutable std::vector<std::string> asked;  // keys that some getter takes, in order

  bool is_asked(const std::string& key) const {
    return std::find(asked.begin(), asked.end(), key) != asked.end();
  }
  const toml::node* find(const std::string& key) const {
    if (!is_asked(key)) asked.push_back(key);
    return table->get(key);
  }
  static std::size_t line_of(const toml::node& node) { return node.source().begin.line; }
  [[noreturn]] void fail_at(std::size_t line, const std::string& key, const std::string& reason) const {
    throw ConfigError(file + ":" + std::to_string(line) + ": " + key + ": " + reason);
  }
  const toml::node& require(const std::string& key, const std::string& allowed) const {
    if (const toml::node* node = find(key)) return *node;
    for (const auto& [other, node] : *table)
      if (resembles(std::string(other.str()), key) && !is_asked(std::string(other.str())))
        fail_at(other.source().begin.line, std::string(other.str()),
                "unknown key" + did_you_mean(std::string(other.str()), {key}) + "; allowed: " + allowed);
    fail_at(line_of(*table), key, "missing; allowed: " + allowed);
  }
  [[noreturn]] void refuse(const toml::node& node, const std::string& key, const std::string& allowed) const {
    std::ostringstream text;
    if (node.is_value()) node.visit([&](const auto& n) { text << n; });
    const bool short_enough = node.is_value() && text.str().size() <= 60;
    fail_at(line_of(node), key, (short_enough ? "is " + text.str() + "; " : "") + "allowed: " + allowed);
  }
  void expect_seen(const toml::node& node, const std::string& key, const std::string& text) const {
    if (const std::string hidden = first_hidden(text); !hidden.empty())
      fail_at(line_of(node), key, "has the hidden character " + hidden + "; allowed: text that can be seen");
  }
  double number(const toml::node& node, const std::string& key, Range range) const {
    const auto value = node.is_number() ? node.value<double>() : std::nullopt;
    if (!value || !std::isfinite(*value) || *value < range.low || *value > range.high)
      refuse(node, key, allowed_numbers(range));
    return *value;
  }
  std::string formula(const toml::node& node, const std::string& key, const std::string& allowed) const {
    if (const auto* text = node.as_string()) return **text;
    if (!node.is_number()) refuse(node, key, allowed);
    char text[32];
    std::snprintf(text, sizeof text, "%.17g", number(node, key, kAnyNumber));
    return text;
  }
};

Section::Section(std::unique_ptr<State> state) : state_(std::move(state)) {}
Section::Section(Section&&) noexcept = default;
Section& Section::operator=(Section&&) noexcept = default;
Section::~Section() = default;

Section Section::parse_text(const std::string& text, const std::string& name_for_errors) {
  if (text.size() > kMostBytes)
    throw ConfigError(name_for_errors + ": " + std::to_string(text.size()) +
                      " bytes or more; allowed: " + std::to_string(kMostBytes));
  auto state = std::make_unique<State>();
  state->file = name_for_errors;
  state->root = std::make_shared<const toml::table>(parse_toml(text, name_for_errors));
  state->table = state->root.get();
  return Section(std::move(state));
}

Section Section::parse_file(const std::string& path) {
  return parse_text(read_text_file(path, kMostBytes), path);
}

double Section::number(const std::string& key, Range range) {
  return state_->number(state_->require(key, allowed_numbers(range)), key, range);
}

double Section::number_or(const std::string& key, Range range, double otherwise) {
  const toml::node* node = state_->find(key);
  return node ? state_->number(*node, key, range) : otherwise;
}

std::int64_t Section::integer(const std::string& key, std::int64_t low, std::int64_t high) {
  const std::string allowed = "an integer " + std::to_string(low) + " .. " + std::to_string(high);
  const toml::node& node = state_->require(key, allowed);
  const auto* value = node.as_integer();
  if (!value || **value < low || **value > high) state_->refuse(node, key, allowed);
  return **value;
}

std::int64_t Section::integer_or(const std::string& key, std::int64_t low, std::int64_t high,
                                 std::int64_t otherwise) {
  return state_->find(key) ? integer(key, low, high) : otherwise;
}

bool Section::boolean_or(const std::string& key, bool otherwise) {
  const toml::node* node = state_->find(key);
  if (!node) return otherwise;
  const auto* value = node->as_boolean();
  if (!value) state_->refuse(*node, key, "true, false");
  return **value;
}

std::string Section::text(const std::string& key) {
  const toml::node& node = state_->require(key, "a text in quotes");
  const auto* value = node.as_string();
  if (!value) state_->refuse(node, key, "a text in quotes");
  state_->expect_seen(node, key, **value);
  return **value;
}

std::string Section::text_or(const std::string& key, const std::string& otherwise) {
  return state_->find(key) ? text(key) : otherwise;
}

std::vector<std::string> Section::texts_or(const std::string& key, std::vector<std::string> otherwise) {
  constexpr std::size_t kMost = 16;
  const std::string allowed = "at most 16 texts in quotes in [ ]";
  const toml::node* node = state_->find(key);
  if (!node) return otherwise;
  const auto* array = node->as_array();
  if (!array || array->size() > kMost) state_->refuse(*node, key, allowed);
  std::vector<std::string> values;
  for (const toml::node& element : *array) {
    const auto* value = element.as_string();
    if (!value) state_->refuse(element, key, allowed);
    state_->expect_seen(element, key, **value);
    values.push_back(**value);
  }
  return values;
}

std::size_t Section::choice(const std::string& key, const std::vector<std::string>& allowed) {
  const toml::node& node = state_->require(key, join(allowed));
  const auto* value = node.as_string();
  const auto found = value ? std::find(allowed.begin(), allowed.end(), **value) : allowed.end();
  if (found == allowed.end()) state_->refuse(node, key, join(allowed));
  return static_cast<std::size_t>(found - allowed.begin());
}

std::size_t Section::choice_or(const std::string& key, const std::vector<std::string>& allowed,
                               std::size_t otherwise) {
  return state_->find(key) ? choice(key, allowed) : otherwise;
}

std::vector<double> Section::numbers(const std::string& key, std::size_t size, Range range) {
  const std::string allowed = (size ? std::to_string(size) : std::string("one or more")) + " numbers in [ ]";
  const toml::node& node = state_->require(key, allowed);
  const auto* array = node.as_array();
  if (!array || array->empty() || (size && array->size() != size)) state_->refuse(node, key, allowed);
  std::vector<double> values;
  for (const toml::node& element : *array) values.push_back(state_->number(element, key, range));
  return values;
}

std::vector<double> Section::numbers_or(const std::string& key, std::size_t size, Range range,
                                        std::vector<double> otherwise) {
  return state_->find(key) ? numbers(key, size, range) : otherwise;
}

Range Section::bounds_or(const std::string& key, Range range, Range otherwise) {
  const toml::node* node = state_->find(key);
  if (!node) return otherwise;
  if (!node->is_array()) {
    const double both = state_->number(*node, key, range);
    return {both, both};
  }
  const std::vector<double> two = numbers(key, 2, range);
  if (two[0] > two[1]) state_->refuse(*node, key, "[low, high] with low <= high");
  return {two[0], two[1]};
}

std::string Section::formula(const std::string& key) {
  const std::string allowed = "a formula in quotes, or a number";
  return state_->formula(state_->require(key, allowed), key, allowed);
}

std::vector<std::string> Section::formulas(const std::string& key, std::size_t size) {
  const std::string allowed = std::to_string(size) + " formulas in quotes, or numbers, in [ ]";
  const toml::node& node = state_->require(key, allowed);
  const auto* array = node.as_array();
  if (!array || array->size() != size) state_->refuse(node, key, allowed);
  std::vector<std::string> texts;
  for (const toml::node& element : *array) texts.push_back(state_->formula(element, key, allowed));
  return texts;
}

bool Section::has(const std::string& key) const {
  return state_->find(key) != nullptr;
}

std::vector<std::string> Section::keys() const {
  std::vector<std::pair<toml::source_position, std::string>> places;
  for (const auto& [key, node] : *state_->table) places.emplace_back(key.source().begin, key.str());
  std::ranges::sort(places, [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<std::string> names;
  for (auto& [place, name] : places) names.push_back(std::move(name));
  return names;
}

Section Section::section(const std::string& key) {
  const toml::node& node = state_->require(key, "a table [" + key + "]");
  const auto* table = node.as_table();
  if (!table) state_->refuse(node, key, "a table [" + key + "]");
  auto inner = std::make_unique<State>();
  inner->root = state_->root;
  inner->table = table;
  inner->file = state_->file;
  return Section(std::move(inner));
}

std::optional<Section> Section::section_if(const std::string& key) {
  if (!has(key)) return std::nullopt;
  return section(key);
}

std::vector<Section> Section::sections(const std::string& key, std::size_t least) {
  const std::string allowed = "at least " + std::to_string(least) + " tables [[" + key + "]]";
  const toml::node* node = state_->find(key);
  std::vector<Section> result;
  if (node) {
    const auto* array = node->as_array();
    if (!array) state_->refuse(*node, key, allowed);
    for (const toml::node& element : *array) {
      const auto* table = element.as_table();
      if (!table) state_->refuse(element, key, allowed);
      auto inner = std::make_unique<State>();
      inner->root = state_->root;
      inner->table = table;
      inner->file = state_->file;
      result.push_back(Section(std::move(inner)));
    }
  }
  if (result.size() < least)
    state_->fail_at(State::line_of(node ? *node : static_cast<const toml::node&>(*state_->table)), key,
                    "allowed: " + allowed);
  return result;
}

void Section::finish() const {
  for (const auto& [key, node] : *state_->table) {
    const std::string name(key.str());
    if (state_->is_asked(name)) continue;
    state_->fail_at(
        key.source().begin.line, name,
        "unknown key" + did_you_mean(name, state_->asked) + "; allowed here: " + join(state_->asked));
  }
}

void Section::fail(const std::string& key, const std::string& reason) const {
  const toml::node* node = state_->find(key);
  state_->fail_at(State::line_of(node ? *node : static_cast<const toml::node&>(*state_->table)), key, reason);
}

}  // namespace roadbalance
