#include "common/multibody/model_text.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cstdio>

namespace roadbalance {
namespace {

struct NamedMatrix {
  const char* name;
  const ExpressionMatrix* matrix;
  const char* what;
};

std::vector<NamedMatrix> matrices(const Equations& e) {
  std::vector<NamedMatrix> all{
      {"M", &e.M, "mass"},
      {"P", &e.P, "damping"},
      {"Q", &e.Q, "stiffness"},
      {"S", &e.S, "road height to force"},
      {"Sd", &e.Sd, "its rate of change to force"},
      {"T", &e.T, "sin, cos of each rotor's angle to force, times the square of its rate"},
      {"C", &e.acceleration, "z'' to what the sensors read"},
      {"G", &e.tilt, "z to what the sensors read of gravity"}};
  std::erase_if(all,
                [](const NamedMatrix& one) { return one.matrix->rows() == 0 || one.matrix->columns() == 0; });
  return all;
}

std::string exact_number(double value) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof text, value).ptr};
}

std::string sizes(const ExpressionMatrix& m) {
  return "[" + std::to_string(m.rows()) + "][" + std::to_string(m.columns()) + "]";
}

std::string list(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

/// Names and values of one kind, if there are any.
std::string constants(const std::string& kind, const std::vector<NamedValue>& all) {
  const std::string count = "inline constexpr int k" + kind + "Count = " + std::to_string(all.size()) + ";\n";
  if (all.empty()) return count;
  std::string names, values;
  for (const NamedValue& one : all) {
    names += "    \"" + one.name + "\",\n";
    values += "    " + exact_number(one.value) + ",\n";
  }
  return count + "inline constexpr const char* k" + kind + "Name[] = {\n" + names +
         "};\ninline constexpr double k" + kind + "Value[] = {\n" + values + "};\n";
}

/// One assignment for each entry that is not 0; one below the diagonal that repeats the one above refers to
/// it.
std::string assignments(const NamedMatrix& one) {
  const ExpressionMatrix& m = *one.matrix;
  std::string text;
  for (std::size_t i = 0; i < m.rows(); ++i)
    for (std::size_t j = 0; j < m.columns(); ++j) {
      if (m(i, j).is_zero()) continue;
      const auto place = [&](std::size_t row, std::size_t column) {
        return std::string("E.") + one.name + "[" + std::to_string(row) + "][" + std::to_string(column) + "]";
      };
      const bool repeated = j < i && m.rows() == m.columns() && (m(i, j) - m(j, i)).is_zero();
      text += "  " + place(i, j) + " = " + (repeated ? place(j, i) : m(i, j).cpp()) + ";\n";
    }
  return text;
}

std::string locals(const std::string& array, const std::vector<NamedValue>& all,
                   const std::vector<Expression>& symbols, const std::vector<NamedMatrix>& used_in,
                   const std::vector<Equations::AtRest>& at_rest) {
  std::string text;
  for (std::size_t k = 0; k < all.size(); ++k) {
    const auto uses = [&](const NamedMatrix& one) {
      for (std::size_t i = 0; i < one.matrix->rows(); ++i)
        for (std::size_t j = 0; j < one.matrix->columns(); ++j)
          if ((*one.matrix)(i, j).contains(symbols[k])) return true;
      return false;
    };
    if (std::ranges::any_of(used_in, uses) ||
        std::ranges::any_of(at_rest, [&](const auto& one) { return one.value.contains(symbols[k]); }))
      text += "  const double " + all[k].name + " = " + array + "[" + std::to_string(k) + "];\n";
  }
  return text;
}

std::string matrix(const std::string& name, const ExpressionMatrix& m) {
  if (m.columns() == 0 || m.rows() == 0) return "";
  std::string text = name + " &= \\begin{bmatrix}\n";
  for (std::size_t i = 0; i < m.rows(); ++i) {
    for (std::size_t j = 0; j < m.columns(); ++j) text += (j ? " & " : "  ") + m(i, j).latex();
    text += i + 1 < m.rows() ? " \\\\\n" : "\n";
  }
  return text + "\\end{bmatrix} \\\\\n";
}

std::string column(const std::string& name, const std::vector<std::string>& entries) {
  if (entries.empty()) return "";
  std::string text = name + " &= \\begin{bmatrix}";
  for (std::size_t i = 0; i < entries.size(); ++i) text += (i ? " & " : " ") + entries[i];
  return text + " \\end{bmatrix}^\\mathsf{T} \\\\\n";
}

std::string rounded_number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

}  // namespace

std::string cpp_name(const std::string& name) {
  std::string result;
  for (const char c : name) {
    const bool letter = std::isalnum(static_cast<unsigned char>(c)) != 0;
    result += letter ? static_cast<char>(std::tolower(static_cast<unsigned char>(c))) : '_';
  }
  return is_formula_name(result) ? result : "model_" + result;
}

std::string cpp_text(const Equations& e) {
  const std::vector<NamedMatrix> all = matrices(e);
  std::vector<std::string> coordinates;
  for (const NamedValue& one : e.coordinate) coordinates.push_back(one.name);
  std::string text = "// " + e.name + ": M z'' + P z' + Q z = T d + S u + Sd u', made by rb model --cpp\n";
  text += "#pragma once\n\n#include <cmath>\n\nnamespace " + cpp_name(e.name) + " {\n\n";
  text += "inline constexpr int kCoordinates = " + std::to_string(coordinates.size()) + ";  // " +
          list(coordinates) + "\n";
  if (!e.tyre.empty())
    text += "inline constexpr int kTyres = " + std::to_string(e.tyre.size()) + ";  // " + list(e.tyre) + "\n";
  if (!e.rotor.empty())
    text +=
        "inline constexpr int kRotors = " + std::to_string(e.rotor.size()) + ";  // " + list(e.rotor) + "\n";
  if (!e.sensor.empty())
    text += "inline constexpr int kSensors = " + std::to_string(e.sensor.size()) + ";  // " + list(e.sensor) +
            "\n";
  text += constants("Parameter", e.parameter) + constants("Geometry", e.geometry);
  text += "\nstruct Equations {\n";
  for (const NamedMatrix& one : all)
    text += std::string("  double ") + one.name + sizes(*one.matrix) + " = {};  // " + one.what + "\n";
  text +=
      "};\n\ninline Equations equations([[maybe_unused]] const double* parameter, [[maybe_unused]] const "
      "double* geometry) {\n";
  text += locals("parameter", e.parameter, e.parameter_symbol, all, e.tension);
  std::vector<Equations::AtRest> at_rest = e.length;
  at_rest.insert(at_rest.end(), e.tension.begin(), e.tension.end());
  text += locals("geometry", e.geometry, e.geometry_symbol, all, at_rest);
  for (const auto& one : e.length) text += "  const double " + one.name + " = " + one.value.cpp() + ";\n";
  if (!e.tension.empty()) text += "  // These factors hold where the geometry is that of kGeometryValue.\n";
  for (const auto& one : e.tension) text += "  const double " + one.name + " = " + one.value.cpp() + ";\n";
  text += "  Equations E;\n";
  for (const NamedMatrix& one : all) text += assignments(one);
  return text + "  return E;\n}\n\n}  // namespace " + cpp_name(e.name) + "\n";
}

std::string latex_text(const Equations& e) {
  std::vector<std::string> z, u, d;
  for (const NamedValue& one : e.coordinate) z.push_back(one.latex);
  for (const std::string& tyre : e.tyre) u.push_back("u_{" + latex_name(tyre) + "}");
  for (const std::string& rotor : e.rotor) {
    d.push_back("\\sin\\alpha_{" + latex_name(rotor) + "}");
    d.push_back("\\cos\\alpha_{" + latex_name(rotor) + "}");
  }
  std::string text = "% " + e.name + ": M z'' + P z' + Q z = T d + S u + Sd u', made by rb model --latex\n";
  text += "\\begin{align*}\n";
  text += "M \\ddot z + P \\dot z + Q z &= T d + S u + \\dot S \\dot u \\\\\n";
  text += column("z", z) + column("u", u) + column("d", d);
  text += matrix("M", e.M) + matrix("P", e.P) + matrix("Q", e.Q) + matrix("S", e.S);
  text += matrix("\\dot S", e.Sd) + matrix("T / \\Omega^2", e.T);
  for (const auto* kind : {&e.length, &e.tension})
    for (const Equations::AtRest& one : *kind)
      text += one.symbol.latex() + " &= " + one.value.latex() + " \\\\\n";
  if (!e.sensor.empty()) {
    std::vector<std::string> y;
    for (const std::string& sensor : e.sensor) y.push_back(latex_name(sensor));
    text +=
        "y &= C \\ddot z + G z \\\\\n" + column("y", y) + matrix("C", e.acceleration) + matrix("G", e.tilt);
  }
  const auto last = text.rfind(" \\\\\n");
  text.erase(last, 3);
  text += "\\end{align*}\n";
  for (const auto* kind : {&e.parameter, &e.geometry})
    for (const NamedValue& one : *kind)
      text += "% $" + one.latex + "$ = " + rounded_number(one.value) + "  " + one.name + "\n";
  return text;
}

}  // namespace roadbalance
