#include "host/analyser/before_drive.hpp"

#include <exception>
#include <stdexcept>

#include "host/analyser/identify_record.hpp"
#include "host/analyser/recorded_vehicle.hpp"

namespace roadbalance {
namespace {

std::string name_of(const std::filesystem::path& folder) {
  const std::filesystem::path whole = std::filesystem::absolute(folder).lexically_normal();
  return whole.has_filename() ? whole.filename().string() : whole.parent_path().filename().string();
}

}  // namespace

BalancedDrive evaluate_drive(const std::filesystem::path& folder, const std::stop_token& stop) {
  const RecordedEstimate found = identify_record(folder, false, stop);
  return {name_of(folder), recorded_vehicle(folder).value(), found.estimate.balance, found.compensation};
}

void recall_before(std::stop_token stop, const std::filesystem::path& folder, Out<BalancedDrive> drive,
                   const std::function<void(const std::string&)>& warn) {
  try {
    drive.send(evaluate_drive(folder, stop));
  } catch (const Interrupted&) {
    return;
  } catch (const std::exception& error) {
    warn("--before " + folder.string() + ": " + error.what());
  }
}

}  // namespace roadbalance
