#include "tools/views/identification_json.hpp"

#include <string>

#include "tools/views/number_json.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::ordered_json;

template <std::size_t Size>
Json with_sigmas(const std::array<double, Size>& value, const std::array<double, Size>& sigma) {
  Json array = Json::array();
  for (std::size_t i = 0; i < Size; ++i)
    array.push_back({{"value", number_or_null(value[i])}, {"sigma", number_or_null(sigma[i])}});
  return array;
}

/// Name of one of five: the whole, then the wheels.
std::string part(std::size_t place, const char* whole) {
  return place == 0 ? whole : kWheelNames[place - 1];
}

}  // namespace

Json suspension_json(const Identification& identification) {
  if (identification.state != Unknown::kNone) return nullptr;
  return {
      {"spring_n_m", with_sigmas(identification.spring_n_m, identification.sigma_spring_n_m)},
      {"damper_n_s_m", with_sigmas(identification.damper_n_s_m, identification.sigma_damper_n_s_m)},
      {"stabiliser_n_m", with_sigmas(identification.stabiliser_n_m, identification.sigma_stabiliser_n_m)}};
}

Json fit_json(const Identification& identification) {
  Json misfit, share, speeds = Json::array();
  if (identification.state == Unknown::kNone)
    for (std::size_t k = 0; k < identification.misfit.size(); ++k) {
      const bool judged = identification.sigma_mass_share[k] > 0.0;
      misfit.push_back({{"of", part(k, "body")},
                        {"square", number_or_null(identification.misfit[k])},
                        {"chance", number_or_null(identification.misfit_chance[k])}});
      share.push_back({{"of", part(k, "all_wheels")},
                       {"value", judged ? number_or_null(identification.mass_share[k]) : Json()},
                       {"sigma", judged ? number_or_null(identification.sigma_mass_share[k]) : Json()}});
    }
  for (const Identification::SpeedClass& one : identification.speed_class)
    speeds.push_back({{"speed_m_s", one.speed_m_s}, {"seconds", one.seconds}});
  return {{"condition", identification.condition > 0.0 ? number_or_null(identification.condition) : Json()},
          {"misfit", misfit},
          {"mass_share", share},
          {"speeds", speeds}};
}

}  // namespace roadbalance
