#include "tools/views/identification_json.hpp"

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

}  // namespace

Json suspension_json(const Identification& identification) {
  if (identification.state != Unknown::kNone) return nullptr;
  return {
      {"spring_n_m", with_sigmas(identification.spring_n_m, identification.sigma_spring_n_m)},
      {"damper_n_s_m", with_sigmas(identification.damper_n_s_m, identification.sigma_damper_n_s_m)},
      {"stabiliser_n_m", with_sigmas(identification.stabiliser_n_m, identification.sigma_stabiliser_n_m)}};
}

Json speeds_json(const Identification& identification) {
  Json speeds = Json::array();
  for (const Identification::SpeedClass& one : identification.speed_class)
    speeds.push_back({{"speed_m_s", one.speed_m_s}, {"seconds", one.seconds}});
  return speeds;
}

}  // namespace roadbalance
