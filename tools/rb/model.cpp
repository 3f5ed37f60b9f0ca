#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <numbers>
#include <stdexcept>
#include <string>

#include <nlohmann/json.hpp>

#include "common/config/section.hpp"
#include "common/config/text_file.hpp"
#include "common/multibody/model_text.hpp"
#include "common/multibody/modes.hpp"
#include "common/multibody/observability.hpp"
#include "common/multibody/shipped.hpp"
#include "common/vehicle/vehicle_description.hpp"
#include "tools/rb/command.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::ordered_json;

/// Rotation rates at which unbalances are looked for, rad/s: 65 to 130 km/h on wheels of 0.30 m.
const std::vector<double> kOmega{60.0, 80.0, 100.0, 120.0};

struct ModelOptions {
  std::string file;
  bool latex = false, cpp = false, modes = false, json = false;
};

/// A vehicle.toml, a description, or the name of one that comes with the program.
Description read(const std::string& file) {
  if (!std::filesystem::exists(file)) {
    std::string names;
    for (const std::string& shipped : shipped_descriptions()) {
      if (file == shipped) return shipped_description(file);
      names += ", " + shipped;
    }
    throw std::runtime_error(file + ": there is no such file; allowed: a vehicle.toml, a description" + names);
  }
  const std::string text = read_text_file(file, Section::kMostBytes);
  if (Section::parse_text(text, file).has("coordinates")) return Description::parse(text, file);
  return description_of(VehicleConfig::read_file(file));
}

/// "name[row, column] = entry" for each that is not 0; of a symmetric matrix its upper half.
void print_matrix(const char* name, const ExpressionMatrix& m, const std::vector<std::string>& rows,
                  const std::vector<std::string>& columns, bool symmetric = false) {
  for (std::size_t i = 0; i < m.rows(); ++i)
    for (std::size_t j = symmetric ? i : 0; j < m.columns(); ++j)
      if (!m(i, j).is_zero())
        std::printf("%s[%s, %s] = %s\n", name, rows[i].c_str(), columns[j].c_str(), m(i, j).cpp().c_str());
}

/// "heave'' + 0.74 roll''"
std::string combination(const Eigen::RowVectorXd& row, const std::vector<std::string>& names,
                        const char* behind) {
  std::string text;
  for (Eigen::Index j = 0; j < row.size(); ++j) {
    if (std::abs(row(j)) < 1e-12) continue;
    const bool minus = row(j) < 0.0, one = std::abs(std::abs(row(j)) - 1.0) < 1e-12;
    char number[32] = "";
    if (!one) std::snprintf(number, sizeof number, "%.4g ", std::abs(row(j)));
    text += (text.empty() ? (minus ? "-" : "")
             : minus      ? " - "
                          : " + ") +
            std::string(number) + names[static_cast<std::size_t>(j)] + behind;
  }
  return text;
}

void print_summary(const Equations& e, const AffineModel& model) {
  const std::vector<std::string>& z = model.coordinate;
  std::vector<std::string> d;
  for (const std::string& rotor : e.rotor) {
    d.push_back("sin " + rotor);
    d.push_back("cos " + rotor);
  }
  std::printf("%s: coordinates %zu, parameters %zu, tyres %zu, rotors %zu, sensors %zu\n", e.name.c_str(),
              z.size(), e.parameter.size(), e.tyre.size(), e.rotor.size(), e.sensor.size());
  std::printf("M z'' + P z' + Q z = T d + S u + Sd u', linear about rest; M, P and Q are symmetric\n");
  print_matrix("M", e.M, z, z, true);
  print_matrix("P", e.P, z, z, true);
  print_matrix("Q", e.Q, z, z, true);
  print_matrix("S", e.S, z, e.tyre);
  print_matrix("Sd", e.Sd, z, e.tyre);
  print_matrix("T/Om^2", e.T, z, d);
  for (const auto* kind : {&e.length, &e.tension})
    for (const auto& one : *kind) std::printf("%s = %s\n", one.name.c_str(), one.value.cpp().c_str());
  for (std::size_t s = 0; s < e.sensor.size(); ++s) {
    const auto row = static_cast<Eigen::Index>(s);
    const std::string moved = combination(model.acceleration.row(row), z, "''");
    const std::string tilted = combination(model.tilt.row(row), z, "");
    std::printf("%s reads %s%s%s\n", e.sensor[s].c_str(), moved.c_str(),
                moved.empty() || tilted.empty() ? "" : " + ",
                tilted.empty() ? (moved.empty() ? "nothing" : "") : ("(" + tilted + ")").c_str());
  }
  bool all = true;
  for (const auto& rotor : observability(model, model.at(model.nominal), {}, kOmega)) {
    all = all && rotor.sentence.empty();
    if (!rotor.sentence.empty()) std::printf("%s\n", rotor.sentence.c_str());
  }
  if (all && !e.rotor.empty()) std::printf("these sensors tell the unbalance in every plane\n");
}

void print_modes(const AffineModel& model) {
  std::printf("     Hz  damping  shape\n");
  for (const Mode& mode : modes(model.at(model.nominal))) {
    std::string shape;
    for (Eigen::Index i = 0; i < mode.shape.size(); ++i) {
      if (std::abs(mode.shape(i)) < 0.005) continue;
      char text[96];
      std::snprintf(text, sizeof text, "%s%s %.2f", shape.empty() ? "" : ", ",
                    model.coordinate[static_cast<std::size_t>(i)].c_str(), std::abs(mode.shape(i)));
      shape += text;
      const double phase_deg = std::arg(mode.shape(i)) * 180.0 / std::numbers::pi;
      std::snprintf(text, sizeof text, " at %.0f°", phase_deg);
      if (std::abs(phase_deg) >= 0.5) shape += text;
    }
    if (mode.swings())
      std::printf("%7.3f  %7.3f  %s\n", mode.frequency_hz(), mode.damping(), shape.c_str());
    else
      std::printf("      -        -  e^(%.4g t)  %s\n", mode.pole.real(), shape.c_str());
  }
}

Json rows(const Eigen::MatrixXd& m) {
  Json list = Json::array();
  for (Eigen::Index i = 0; i < m.rows(); ++i) {
    list.push_back(Json::array());
    for (Eigen::Index j = 0; j < m.cols(); ++j) list.back().push_back(m(i, j));
  }
  return list;
}

Json matrices_json(const ModelMatrices& m) {
  Json json;
  const std::pair<const char*, const Eigen::MatrixXd*> six[] = {
      {"M", &m.M}, {"P", &m.P}, {"Q", &m.Q}, {"S", &m.S}, {"Sd", &m.Sd}, {"T_per_omega2", &m.T}};
  for (const auto& [name, matrix] : six)
    if (matrix->size() > 0 && !matrix->isZero(0.0)) json[name] = rows(*matrix);
  return json.is_null() ? Json::object() : json;
}

Json model_json(const Equations& e, const AffineModel& model) {
  Json json{{"name", e.name}, {"coordinates", model.coordinate}, {"tyres", e.tyre}, {"rotors", e.rotor}};
  json["constant"] = matrices_json(model.constant);
  json["parameters"] = Json::array();
  for (std::size_t k = 0; k < model.parameter.size(); ++k)
    json["parameters"].push_back({{"name", model.parameter[k]},
                                  {"value", model.nominal(static_cast<Eigen::Index>(k))},
                                  {"matrices", matrices_json(model.of[k])}});
  json["sensors"] = {
      {"names", e.sensor}, {"acceleration", rows(model.acceleration)}, {"tilt", rows(model.tilt)}};
  json["modes"] = Json::array();
  for (const Mode& mode : modes(model.at(model.nominal))) {
    Json shape = Json::array();
    for (const auto& part : mode.shape) shape.push_back({part.real(), part.imag()});
    json["modes"].push_back({{"frequency_hz", mode.swings() ? Json(mode.frequency_hz()) : Json(nullptr)},
                             {"damping", mode.swings() ? Json(mode.damping()) : Json(nullptr)},
                             {"pole", {mode.pole.real(), mode.pole.imag()}},
                             {"shape", shape}});
  }
  json["observability"] = Json::array();
  for (const auto& rotor : observability(model, model.at(model.nominal), {}, kOmega))
    json["observability"].push_back({{"rotor", rotor.rotor},
                                     {"planes", rotor.plane},
                                     {"observable", rotor.observable.cols()},
                                     {"sentence", rotor.sentence}});
  return json;
}

int show(const ModelOptions& options) {
  const Equations equations = derive(read(options.file));
  if (options.latex || options.cpp) {
    std::fputs((options.latex ? latex_text(equations) : cpp_text(equations)).c_str(), stdout);
    return kDone;
  }
  const AffineModel model = affine_model(equations);
  if (options.json)
    std::printf("%s\n", model_json(equations, model).dump().c_str());
  else if (options.modes)
    print_modes(model);
  else
    print_summary(equations, model);
  return kDone;
}

}  // namespace

void add_model(CLI::App& app, int& code) {
  auto options = std::make_shared<ModelOptions>();
  CLI::App* command =
      app.add_subcommand("model", "Derives a vehicle's equations of motion from its description");
  command
      ->add_option("file", options->file,
                   "a vehicle.toml, a description, or one that comes with the program: quarter_car, "
                   "half_car, seven_dof")
      ->required();
  std::vector<CLI::Option*> forms{
      command->add_flag("--latex", options->latex,
                        "the equations for a report, a fragment for LaTeX with amsmath"),
      command->add_flag("--cpp", options->cpp, "the equations as a header of C++"),
      command->add_flag("--modes", options->modes, "frequencies, damping and shapes of the free motions"),
      command->add_flag("--json", options->json,
                        "matrices per parameter, modes and more: one JSON object on standard output")};
  for (CLI::Option* form : forms)
    for (CLI::Option* other : forms)
      if (form != other) form->excludes(other);
  command->callback([options, &code] { code = show(*options); });
}

}  // namespace roadbalance
