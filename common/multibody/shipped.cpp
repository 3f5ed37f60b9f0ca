#include "common/multibody/shipped.hpp"

#include <string_view>

#include "common/config/section.hpp"
#include "embedded/half_car_description.hpp"
#include "embedded/quarter_car_description.hpp"
#include "embedded/seven_dof_description.hpp"

namespace roadbalance {
namespace {

struct Shipped {
  const char* name;
  std::string_view text;
};
constexpr Shipped kShipped[] = {{"quarter_car", embedded::kQuarterCarDescription},
                                {"half_car", embedded::kHalfCarDescription},
                                {"seven_dof", embedded::kSevenDofDescription}};

}  // namespace

std::vector<std::string> shipped_descriptions() {
  std::vector<std::string> names;
  for (const Shipped& one : kShipped) names.emplace_back(one.name);
  return names;
}

Description shipped_description(const std::string& name) {
  std::string names;
  for (const Shipped& one : kShipped) {
    if (name == one.name) return Description::parse(std::string(one.text), name + ".toml");
    names += (names.empty() ? "" : ", ") + std::string(one.name);
  }
  throw ConfigError("no description \"" + name + "\" comes with the program; allowed: " + names);
}

}  // namespace roadbalance
